"""One detection in a process of its own, for `benchmarks.speed`.

    python -m benchmarks.speed_task MESH.npz [DIRECTIONS.npy]

Prints seconds, peak memory in MB after reading and at the end, the stages, and the threads.
"""

from __future__ import annotations

import json
import sys
import time

import numpy as np

import core
from core.parallel import threads

from .peers.measurement import memory_mb


def main(mesh: str, directions: str | None = None) -> None:
    with np.load(mesh) as file:
        vertices, triangles = file["vertices"], file["triangles"]
    before = memory_mb("VmRSS")
    start = time.perf_counter()
    detection = core.detect(vertices, triangles)
    seconds = time.perf_counter() - start
    found = {
        "seconds": seconds,
        "input_mb": before,
        "peak_mb": memory_mb("VmHWM"),
        "stages": detection.timings,
        "threads": threads(),
        "umbilics": len(detection.umbilics),
    }
    if directions is not None:
        np.save(directions, detection.curvature.d1)
    print(json.dumps(found))


if __name__ == "__main__":
    main(*sys.argv[1:])
