"""Draw the extension's icon, docs/images/icon.png: lines of curvature around a lemon.

The lines are level sets of a function whose gradient has the index one half; made with NumPy only.
"""

import struct
import sys
import zlib
from pathlib import Path

import numpy as np

SIZE, OVERSAMPLED = 256, 4
_GROUND = np.array([0.96, 0.95, 0.92])
_DISK = np.array([0.16, 0.30, 0.52])
_LINE = np.array([0.93, 0.95, 0.98])
_MARK = np.array([1.0, 0.65, 0.10])


def picture() -> np.ndarray:
    """(SIZE, SIZE, 4) colours and opacity, 0 to 1."""
    side = SIZE * OVERSAMPLED
    axis = (np.arange(side) + 0.5) / side * 2.0 - 1.0
    x, y = np.meshgrid(axis, -axis)
    radius = np.hypot(x, y)
    # Confocal parabolas are the lines of the simplest field of index one half.
    level = np.sqrt(np.maximum(radius - x, 0.0))
    near = np.abs(level * 7.0 - np.rint(level * 7.0)) / 7.0
    steepness = np.maximum(np.abs(np.gradient(level, axis[1] - axis[0])).sum(axis=0), 1e-3)
    colour = np.where((near < 0.018 * steepness)[..., None], _LINE, _DISK)
    colour = np.where((radius < 0.13)[..., None], _GROUND, colour)
    colour = np.where((radius < 0.10)[..., None], _MARK, colour)
    image = np.concatenate([colour, (radius < 0.97)[..., None].astype(float)], axis=2)
    blocks = image.reshape(SIZE, OVERSAMPLED, SIZE, OVERSAMPLED, 4)
    return blocks.mean(axis=(1, 3))


def png(image: np.ndarray) -> bytes:
    """A PNG file of (h, w, 4) values from 0 to 1."""
    height, width, _ = image.shape
    rows = np.rint(255 * image).astype(np.uint8).reshape(height, -1)
    raw = b"".join(b"\0" + row.tobytes() for row in rows)

    def part(kind: bytes, data: bytes) -> bytes:
        end = struct.pack(">I", zlib.crc32(kind + data))
        return struct.pack(">I", len(data)) + kind + data + end

    about = struct.pack(">IIBBBBB", width, height, 8, 6, 0, 0, 0)
    parts = [part(b"IHDR", about), part(b"IDAT", zlib.compress(raw, 9)), part(b"IEND", b"")]
    return b"\x89PNG\r\n\x1a\n" + b"".join(parts)


def main() -> None:
    repository = Path(__file__).resolve().parent.parent
    path = Path(sys.argv[1]) if len(sys.argv) > 1 else repository / "docs" / "images" / "icon.png"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(png(picture()))


if __name__ == "__main__":
    main()
