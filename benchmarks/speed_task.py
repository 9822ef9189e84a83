"""Detections in a process of their own, for `benchmarks.speed`.

    python -m benchmarks.speed_task MESH.npz ROUNDS [DIRECTIONS.npy]

Prints the seconds of each round, the least of all threads together, peak memory in MB after reading
and at the end, the stages of the median round, and the threads.
"""

from __future__ import annotations

import json
import sys
import time

import numpy as np

import core
from core.base.parallel import threads

from .peers.measurement import memory_mb


def main(mesh: str, rounds: str, directions: str | None = None) -> None:
    with np.load(mesh) as file:
        vertices, triangles = file["vertices"], file["triangles"]
    before = memory_mb("VmRSS")
    runs, processor, detection = [], [], None
    for _ in range(int(rounds)):
        detection = None  # or it would be counted beside the next one
        start, worked = time.perf_counter(), time.process_time()
        detection = core.detect(vertices, triangles)
        processor.append(time.process_time() - worked)
        runs.append((time.perf_counter() - start, detection.timings))
    found = {
        "seconds": [seconds for seconds, _ in runs],
        "processor": min(processor),
        "input_mb": before,
        "peak_mb": memory_mb("VmHWM"),
        "stages": sorted(runs, key=lambda run: run[0])[len(runs) // 2][1],
        "threads": threads(),
        "umbilics": len(detection.umbilics),
    }
    if directions is not None:
        np.save(directions, detection.curvature.d1)
    print(json.dumps(found))


if __name__ == "__main__":
    main(*sys.argv[1:])
