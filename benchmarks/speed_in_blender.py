"""Reading, detection and writing back in Blender, with the installed extension.

    blender -b --python-exit-code 1 --python benchmarks/speed_in_blender.py -- LEVEL ROUNDS

Prints a line "SECONDS read detect write" for each round.
"""

import importlib
import sys
import time

import bpy
import numpy as np

AXES = (3.0, 2.0, 1.0)


def ellipsoid_object(level: int) -> bpy.types.Object:
    """Blender's own icosphere (whose levels count from 1), stretched."""
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=level + 1, radius=1.0)
    obj = bpy.context.active_object
    position = obj.data.attributes["position"].data
    values = np.empty(3 * len(position), np.float32)
    position.foreach_get("vector", values)
    position.foreach_set("vector", (values.reshape(-1, 3) * np.float32(AXES)).ravel())
    obj.data.update()
    return obj


def seconds(package: str, obj: bpy.types.Object) -> tuple[float, float, float]:
    """What reading, detection and writing back take, by the installed package of that name."""
    core = importlib.import_module(f"{package}.core")
    engine = importlib.import_module(f"{package}.operators.jobs.detect")
    start = time.perf_counter()
    inputs = engine.gather(obj, core.Settings())
    read = time.perf_counter()
    found = engine.results_of(inputs, engine.compute(inputs))
    detected = time.perf_counter()
    engine.write(bpy.context, inputs, found)
    return read - start, detected - read, time.perf_counter() - detected


def main(level: int, rounds: int) -> None:
    bpy.ops.wm.read_homefile(use_empty=True)
    obj = ellipsoid_object(level)
    for _ in range(rounds):
        print("SECONDS", *seconds("bl_ext.user_default.umbilics", obj), flush=True)


if __name__ == "__main__":
    main(*map(int, sys.argv[sys.argv.index("--") + 1 :]))
