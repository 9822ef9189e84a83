"""Pictures of cross fields, poles and features: docs/figures/field-NAME.png.

    python3 -m benchmarks.field_pictures [MESH ...] [--before CHECKOUT] [--out FOLDER]

With --before the picture of another checkout of this repository stands at the left, plans as they
were there. Drawn with NumPy alone.
"""

from __future__ import annotations

import argparse
import os
import struct
import subprocess
import sys
import tempfile
import zlib
from pathlib import Path

import numpy as np
from mesh_files import read_mesh

import core

ROOT = Path(__file__).resolve().parents[1]
NAMES = ("bunny_hr_os", "spot_os", "rocker-arm", "skull_os")
# Which way each is seen: the axis that is up, and degrees about it.
VIEWS = {
    "bunny_hr_os": (1, 0.0),
    "spot_os": (1, 40.0),
    "rocker-arm": (2, 20.0),
    "skull_os": (1, 25.0),
}
SIZE = 760
# Points of a surface to a pixel, so that no gap is left; crosses along a side of the picture.
DENSE, CROSSES = 8.0, 60
CLAY, STROKE, FEATURE = (206, 202, 194), (96, 112, 140), (20, 20, 20)
POLES = {3: (255, 150, 0), 5: (0, 120, 95)}


class Picture:
    """An image with a depth for each pixel."""

    def __init__(self, points: np.ndarray, up: int, turn: float) -> None:
        other = [axis for axis in range(3) if axis != up]
        c, s = np.cos(np.radians(turn)), np.sin(np.radians(turn))
        right = c * np.eye(3)[other[0]] + s * np.eye(3)[other[1]]
        upward = np.eye(3)[up]
        self.axes = np.stack([right, upward, np.cross(right, upward)])
        # A little from above.
        tilt = np.radians(12.0)
        c, s = np.cos(tilt), np.sin(tilt)
        self.axes = np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]]) @ self.axes
        seen = points @ self.axes.T
        low, high = seen.min(axis=0), seen.max(axis=0)
        self.scale = 0.94 * SIZE / float((high - low)[:2].max())
        self.middle = 0.5 * (low + high)
        self.image = np.full((SIZE, SIZE, 3), 255, np.uint8)
        self.depth = np.full((SIZE, SIZE), -np.inf)

    def put(self, points: np.ndarray, colour: np.ndarray, nearer: float, wide: int = 0) -> None:
        """Points (p, 3) of a colour (3,) or (p, 3), `nearer` by so many pixels than they are, as
        squares of 2 wide + 1 pixels."""
        seen = (points @ self.axes.T - self.middle) * self.scale
        column = np.rint(SIZE / 2 + seen[:, 0]).astype(int)
        row = np.rint(SIZE / 2 - seen[:, 1]).astype(int)
        height = seen[:, 2] + nearer
        colour = np.broadcast_to(np.asarray(colour, np.uint8), (len(points), 3))
        steps = range(-wide, wide + 1)
        for down in steps:
            for across in steps:
                y, x = row + down, column + across
                inside = (y >= 0) & (y < SIZE) & (x >= 0) & (x < SIZE)
                order = np.flatnonzero(inside)[np.argsort(height[inside], kind="stable")]
                y, x = y[order], x[order]
                seen_first = height[order] >= self.depth[y, x]
                y, x, order = y[seen_first], x[seen_first], order[seen_first]
                self.depth[y, x], self.image[y, x] = height[order], colour[order]


def drawn(path: Path) -> np.ndarray:
    """The image of a mesh with the default plan: crosses, features in black, 3-poles in orange,
    5-poles in green."""
    vertices, triangles = read_mesh(path)
    detection = core.detect(vertices, triangles)
    guidance = core.Guide(vertices, triangles, detection).guidance()
    up, turn = VIEWS.get(path.stem, (2, 0.0))
    corner = vertices[triangles]
    picture = Picture(vertices[np.unique(triangles)], up, turn)
    cross = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    twice = np.linalg.norm(cross, axis=1)
    normal = cross / np.maximum(twice, np.finfo(float).tiny)[:, None]
    random = np.random.default_rng(0)
    count = np.ceil(0.5 * twice * picture.scale**2 * DENSE).astype(int)
    face = np.repeat(np.arange(len(triangles)), count)
    a, b = np.sqrt(random.random(len(face))), random.random(len(face))
    weights = np.stack([1.0 - a, a * (1.0 - b), a * b], axis=1)
    points = np.einsum("pc,pcx->px", weights, corner[face])
    light = np.clip(0.45 + 0.55 * (normal @ picture.axes.T) @ [-0.25, 0.45, 0.86], 0.3, 1.0)
    picture.put(points, np.asarray(CLAY) * light[face, None], 0.0)
    _crosses(picture, corner, normal, guidance.face_direction, points, face)
    side = guidance.feature_side
    rows = triangles[guidance.feature_triangle]
    along = np.arange(len(rows))
    ends = vertices[rows[along, side]], vertices[rows[along, (side + 1) % 3]]
    picture.put(_between(*ends, 12), np.array(FEATURE), 9.0, 1)
    for valence, colour in POLES.items():
        mine = guidance.poles.position[guidance.poles.valence == valence]
        picture.put(mine, np.array(colour), 12.0, 4)
    return picture.image


def _crosses(
    picture: Picture,
    corner: np.ndarray,
    normal: np.ndarray,
    direction: np.ndarray,
    points: np.ndarray,
    face: np.ndarray,
) -> None:
    """One cross for each cell of a grid over the surface."""
    cell = SIZE / CROSSES / picture.scale
    number = np.floor(points / cell).astype(np.int64)
    _, some = np.unique(number, axis=0, return_index=True)
    some = some[np.isfinite(direction[face[some]]).all(axis=1)]
    at, one = points[some], direction[face[some]]
    for arm in (one, np.cross(normal[face[some]], one)):
        ends = at - 0.42 * cell * arm, at + 0.42 * cell * arm
        picture.put(_between(*ends, 14), np.array(STROKE), 7.0)


def _between(one: np.ndarray, two: np.ndarray, count: int) -> np.ndarray:
    """(r count, 3) points on the ways between points (r, 3)."""
    share = np.linspace(0.0, 1.0, count)[None, :, None]
    return ((1.0 - share) * one[:, None] + share * two[:, None]).reshape(-1, 3)


def write_png(path: Path, image: np.ndarray) -> None:
    """Write (h, w, 3) uint8 pixels."""

    def part(name: bytes, content: bytes) -> bytes:
        check = struct.pack(">I", zlib.crc32(name + content))
        return struct.pack(">I", len(content)) + name + content + check

    height, width, _ = image.shape
    rows = np.concatenate([np.zeros((height, 1), np.uint8), image.reshape(height, -1)], axis=1)
    about = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    pixels = zlib.compress(rows.tobytes(), 9)
    parts = part(b"IHDR", about), part(b"IDAT", pixels), part(b"IEND", b"")
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + b"".join(parts))


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="benchmarks.field_pictures", description=__doc__)
    parser.add_argument("meshes", type=Path, nargs="*", help="OBJ, PLY or STL files")
    parser.add_argument("--before", type=Path, help="another checkout, for the left half")
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "figures")
    parser.add_argument("--raw", type=Path, help="write the one image as an array")
    options = parser.parse_args(arguments)
    folder = Path(os.environ.get("UMBILICS_MESHES") or ROOT.parent / "shared" / "meshes")
    for path in options.meshes or [folder / f"{name}.obj" for name in NAMES]:
        image = drawn(path)
        if options.raw:
            np.save(options.raw, image)
            continue
        if options.before:
            with tempfile.TemporaryDirectory() as name:
                raw = Path(name) / "before.npy"
                words = [sys.executable, __file__, str(path), "--raw", str(raw)]
                paths = os.pathsep.join(map(str, (options.before, options.before / "tests")))
                subprocess.run(words, env={**os.environ, "PYTHONPATH": paths}, check=True)
                image = np.hstack([np.load(raw), image])
        write_png(options.out / f"field-{path.stem}.png", image)
        print(path.stem, flush=True)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
