"""Files read by the programs they are for, where these can be had: none of them is on PyPI.

Set UMBILICS_READERS to a folder that holds checkouts of the repositories

    Directional   github.com/avaxman/Directional
    quadwild      github.com/nicopietroni/quadwild
    vcglib        github.com/cnr-isti-vclab/vcglib

with g++ and Eigen's headers installed. libigl is taken from any Python named in UMBILICS_LIBIGL
that has it (pip install libigl), or from this one.
"""

import os
import shutil
import subprocess
import sys
from collections import defaultdict
from pathlib import Path

import numpy as np
import pytest
from surfaces import ellipsoid

import core
from core import formats

HERE = Path(__file__).with_name("foreign")
EIGEN = Path("/usr/include/eigen3")
KINDS = ["mesh", "rosy", "sharp", "rawfield", "sing", "dmat"]


def with_creases():
    """An ellipsoid cut off below: it has a sharp rim and a flat face."""
    mesh = ellipsoid(subdivisions=4)
    vertices = mesh.vertices.copy()
    vertices[:, 2] = np.maximum(vertices[:, 2], -0.6)
    return vertices, mesh.triangles


def plain():
    mesh = ellipsoid(subdivisions=4)
    return mesh.vertices, mesh.triangles


@pytest.fixture(scope="module", params=[plain, with_creases], ids=["ellipsoid", "creases"])
def written(request, tmp_path_factory):
    """The files' common name."""
    vertices, triangles = request.param()
    detection = core.detect(vertices, triangles)
    guide = core.Guide(vertices, triangles, detection)
    stem = tmp_path_factory.mktemp("files") / "thing"
    core.write_guidance(stem, KINDS, core.Exported(vertices, triangles, guide, guide.guidance()))
    return stem


@pytest.fixture(scope="module")
def program(tmp_path_factory):
    """Compile one of the programs beside this file against the checkouts, and run it."""
    chosen = os.environ.get("UMBILICS_READERS")
    if not chosen:
        pytest.skip("UMBILICS_READERS names no checkouts of Directional, quadwild and vcglib")
    if not shutil.which("g++") or not EIGEN.is_dir():
        pytest.skip("g++ or Eigen's headers are missing")
    root = Path(chosen).resolve()
    folder = tmp_path_factory.mktemp("programs")

    def run(name, includes, sources, *files):
        binary = folder / name
        if not binary.exists():
            command = ["g++", "-std=c++20", "-O1", "-w", f"-I{EIGEN}"]
            command += [f"-I{root / include}" for include in includes]
            command += [HERE / f"{name}.cpp", *(root / source for source in sources)]
            subprocess.run([*command, "-o", binary], check=True)
        done = subprocess.run([binary, *files], capture_output=True, text=True, check=True)
        found = defaultdict(list)
        for line in done.stdout.splitlines():
            word, *values = line.split()
            found[word].append(values)
        return {word: rows for word, rows in found.items() if word.islower()}

    return run


def test_quadwild_reads_the_field_and_the_features(program, written):
    found = program(
        "quadwild_reads",
        ["vcglib", "quadwild/components/viz_mesh_results"],
        ["vcglib/wrap/ply/plylib.cpp"],
        *(f"{written}{ending}" for ending in (".obj", ".rosy", ".sharp")),
    )
    direction, _ = formats.read_rosy(f"{written}.rosy")
    # QuadWild keeps single precision.
    assert np.array(found["direction"], float) == pytest.approx(direction, abs=1e-6)
    vertex, _, _ = formats.read_sing(f"{written}.sing")
    singular = np.array(found["singular"], int).ravel()
    assert sorted(singular) == sorted(vertex)
    _, face, side = formats.read_sharp(f"{written}.sharp")
    marked = {tuple(map(int, pair)) for pair in found.get("sharp", [])}
    assert marked == set(zip(face.tolist(), side.tolist(), strict=True))


def test_directional_finds_the_singularities_that_we_list(program, written):
    found = program(
        "directional_reads",
        ["Directional/include"],
        [],
        *(f"{written}{ending}" for ending in (".obj", ".rawfield", ".sing")),
    )
    assert found["degree"] == [["4", "4"]]
    ours = formats.read_rawfield(f"{written}.rawfield")
    theirs = np.array(found["vectors"], float).reshape(ours.shape)
    # It lays the vectors into the planes of its triangles.
    assert theirs == pytest.approx(ours, abs=1e-9)
    vertex, quarters, _ = formats.read_sing(f"{written}.sing")
    listed = sorted(zip(vertex.tolist(), quarters.tolist(), strict=True))
    assert sorted(tuple(map(int, row)) for row in found["read"]) == listed
    assert sorted(tuple(map(int, row)) for row in found["found"]) == listed


LIBIGL = """
import sys, igl, numpy as np
vertices, triangles = igl.read_triangle_mesh(sys.argv[1] + ".obj")
matrix = igl.readDMAT(sys.argv[1] + ".dmat")
np.savez(sys.argv[2], vertices=vertices, triangles=triangles, matrix=matrix)
"""


def test_libigl_reads_the_mesh_and_the_matrix(written, tmp_path):
    python = os.environ.get("UMBILICS_LIBIGL", sys.executable)
    if subprocess.run([python, "-c", "import igl"], capture_output=True, check=False).returncode:
        pytest.skip("there is no libigl: pip install libigl, or name a Python in UMBILICS_LIBIGL")
    target = tmp_path / "read.npz"
    subprocess.run([python, "-c", LIBIGL, written, target], check=True)
    direction, _ = formats.read_rosy(f"{written}.rosy")
    vertices, triangles = formats.read_mesh(f"{written}.obj")
    with np.load(target) as found:
        assert np.array_equal(found["matrix"], direction)
        assert np.array_equal(found["vertices"], vertices)
        assert np.array_equal(found["triangles"], triangles)
