"""Stands for the Blender process of one file in tests of batches, so that they take no time.

Takes the command's arguments as the real one does. What it does is said by the file's content:
lines "torn", "silent", "half", "hang", "crash", "word TEXT", "guide NAME", "with NAME" (read beside
it), "touch" (somebody saves the file meanwhile), or else a report is written.
"""

import json
import os
import sys
import time

# What a batch starts in place of Blender.
COMMAND = [sys.executable, os.path.abspath(__file__)]

OBJECT = {
    "object": "Egg",
    "vertices": 162,
    "triangles": 320,
    "index_sum": 2.0,
    "expected_index_sum": 2.0,
    "euler_characteristic": 2,
    "counts": {"lemon": 4},
    "warnings": [],
    "regions": [],
}


def main(arguments: list[str]) -> int:
    source = arguments[arguments.index("--") + 1]
    places = {}
    for argument in arguments:
        for kind in ("json", "ply", "guide"):
            if argument.startswith(f"--{kind}="):
                places[kind] = argument.split("=", 1)[1]
    with open(source, "rb") as file:
        what = file.read().decode("utf-8", "replace").strip()
    if what == "silent":
        print("umbilics: ", file=sys.stderr)
        return 1
    if what.startswith("word "):
        print(f"umbilics: {what[5:]}", file=sys.stderr)
        return 1
    if what == "crash":
        os.abort()
    if "ply" in places:
        with open(places["ply"], "w") as file:
            file.write("ply\n")
    if "guide" in places:
        os.makedirs(places["guide"])
        name = what[6:] if what.startswith("guide ") else "Egg.rosy"
        with open(os.path.join(places["guide"], name), "w") as file:
            file.write("0\n4\n")
    if what == "half":
        return 1
    if what == "hang":
        time.sleep(600)
    if what == "touch":
        later = time.time() + 1.0
        os.utime(source, (later, later))
    told = {"file": source}
    if what.startswith("with "):
        other = os.path.join(os.path.dirname(source), what[5:])
        told["beside"] = [{"file": other, "bytes": None, "sha256": None}]
    text = json.dumps({"schema": 1, "source": told, "objects": [OBJECT]})
    with open(places["json"], "w") as file:
        file.write(text[: len(text) // 2] if what == "torn" else text)
    return 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
