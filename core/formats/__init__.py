"""Files that remeshers and field libraries read: each format has a writer and a reader.

docs/formats.md says who reads what. All but PLY are text in ASCII with Unix line ends.
"""

from .curves import read_curves, write_curves
from .fields.dmat import read_dmat, write_dmat
from .fields.rawfield import read_rawfield, write_rawfield
from .fields.rosy import read_rosy, write_rosy
from .fields.sharp import read_sharp, write_sharp
from .fields.sing import read_sing, write_sing
from .mesh import read_mesh, write_mesh
from .points import read_points_csv, read_points_json, write_points_csv, write_points_json
from .quads import write_quads

__all__ = [
    "read_curves",
    "read_dmat",
    "read_mesh",
    "read_points_csv",
    "read_points_json",
    "read_rawfield",
    "read_rosy",
    "read_sharp",
    "read_sing",
    "write_curves",
    "write_dmat",
    "write_mesh",
    "write_points_csv",
    "write_points_json",
    "write_quads",
    "write_rawfield",
    "write_rosy",
    "write_sharp",
    "write_sing",
]
