"""Other programs that make quad meshes: Instant Meshes from its Python package, and Blender's
QuadriFlow."""

from __future__ import annotations

import subprocess
import sys
import tempfile
import venv
from pathlib import Path

import numpy as np

from .. import ROOT

PACKAGE = "pyinstantmeshes==1.0.0"

# What the environment's Python runs: vertices, triangles and a number in, vertices, quads and
# seconds out. Pure quads come of one subdivision, so a quarter is asked for; the package hands
# each quad a b c d over as the triangles a b c and d a c.
_INSTANT = """
import sys, time
import numpy as np, pyinstantmeshes
data = np.load(sys.argv[1])
start = time.perf_counter()
vertices, faces = pyinstantmeshes.remesh(
    data["vertices"].astype(np.float32), data["triangles"].astype(np.int32),
    target_face_count=int(sys.argv[3]) // 4, pure_quad=True, deterministic=True,
    align_to_boundaries=True, crease_angle=40.0,
)
seconds = time.perf_counter() - start
one, two = faces[::2], faces[1::2]
assert (one[:, [0, 2]] == two[:, [1, 2]]).all()
np.savez(sys.argv[2], vertices=vertices, quads=np.column_stack([one, two[:, 0]]), seconds=seconds)
"""

_QUADRIFLOW = """
import sys, time
import bpy, numpy as np
source, target, count = sys.argv[-3:]
data = np.load(source)
mesh = bpy.data.meshes.new("mesh")
mesh.from_pydata(data["vertices"].tolist(), [], data["triangles"].tolist())
thing = bpy.data.objects.new("mesh", mesh)
bpy.context.collection.objects.link(thing)
bpy.context.view_layer.objects.active = thing
thing.select_set(True)
start = time.perf_counter()
bpy.ops.object.quadriflow_remesh(
    mode="FACES", target_faces=int(count), use_preserve_sharp=True, use_preserve_boundary=True
)
seconds = time.perf_counter() - start
mesh = thing.data
quads = np.array([list(face.vertices) for face in mesh.polygons if len(face.vertices) == 4])
other = sum(len(face.vertices) != 4 for face in mesh.polygons)
vertices = np.array([list(vertex.co) for vertex in mesh.vertices])
np.savez(target, vertices=vertices, quads=quads, seconds=seconds, other=other)
"""


class PeerError(Exception):
    """A program cannot be had here, or failed; the text says why."""


def instant_meshes(cache: Path) -> list[str]:
    """The command that runs Instant Meshes, in a folder that is made once and kept.

    Raises
    ------
    PeerError
        Its package cannot be installed.
    """
    folder = cache / f"{PACKAGE}-python{sys.version_info.major}.{sys.version_info.minor}"
    python = folder / "bin" / "python"
    if not (folder / "ready").exists():
        venv.create(folder, with_pip=True, clear=True, symlinks=True)
        command = [python, "-m", "pip", "install", "--quiet", PACKAGE, "numpy"]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode:
            raise PeerError(f"it could not be installed: {done.stderr.strip()[-200:]}")
        (folder / "ready").touch()
    return [str(python), "-c", _INSTANT]


def quadriflow() -> list[str]:
    """The command that runs Blender's QuadriFlow.

    Raises
    ------
    PeerError
        There is no Blender.
    """
    blender = str(ROOT / "tools" / "blender")
    done = subprocess.run([blender, "--version"], capture_output=True, text=True, check=False)
    if done.returncode:
        raise PeerError("there is no Blender")
    return [
        blender,
        "-b",
        "--factory-startup",
        "--python-exit-code",
        "1",
        "--python-expr",
        _QUADRIFLOW,
        "--",
    ]


def run(
    command: list[str], vertices: np.ndarray, triangles: np.ndarray, quads: int
) -> tuple[np.ndarray, np.ndarray, float]:
    """Vertices, quads and seconds of a program's remeshing.

    Raises
    ------
    PeerError
        It has failed, taken more than ten minutes or made no quads.
    """
    with tempfile.TemporaryDirectory() as name:
        source, target = Path(name) / "in.npz", Path(name) / "out.npz"
        np.savez(source, vertices=vertices, triangles=triangles)
        try:
            done = subprocess.run(
                [*command, str(source), str(target), str(quads)],
                capture_output=True,
                text=True,
                check=False,
                timeout=600,
            )
        except subprocess.TimeoutExpired as error:
            raise PeerError("no result in ten minutes") from error
        if done.returncode or not target.exists():
            raise PeerError("it failed")
        found = np.load(target)
        if not len(found["quads"]):
            raise PeerError("it made no quads")
        return found["vertices"].astype(float), found["quads"], float(found["seconds"])
