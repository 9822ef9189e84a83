"""Install the zip given in the bpy of this Python, and say where SciPy then comes from."""

import sys
from pathlib import Path

import bpy

zip_file = sys.argv[1]
bpy.ops.extensions.package_install_files(
    filepath=zip_file, repo="user_default", enable_on_install=True
)

import scipy  # noqa: E402

extensions = Path(bpy.utils.user_resource("EXTENSIONS"))
if not Path(scipy.__file__).is_relative_to(extensions):
    raise SystemExit(f"SciPy is not the zip's own but {scipy.__file__}")
bpy.ops.umbilics.detect.get_rna_type()
place = Path(scipy.__file__).parent.relative_to(extensions)
print(f"SciPy {scipy.__version__} from {place}")
