"""Single files within limits: each in a process of its own, which is ended at a limit."""

from __future__ import annotations

import subprocess
import time
from pathlib import Path

from ....core.formats.whole import PARTIAL
from .. import exit_codes
from ..arguments import Request
from ..guard import shown
from ..messages import complain
from . import machine

_PAUSE = 0.05


def run(request: Request, blender: list[str]) -> int:
    """Do the files one after the other; the command's exit code."""
    failed = False
    for file, outputs in zip(request.files, request.outputs, strict=True):
        failed |= not _one_file(request, file, outputs, blender)
    return exit_codes.FAILED if failed else exit_codes.DONE


def _one_file(request: Request, file: str | None, outputs: dict, blender: list[str]) -> bool:
    command = [*blender, *request.worker_arguments, "--worker"]
    command += [f"--{kind}={path}" for kind, path in outputs.items()]
    if request.guidance:
        command.append(f"--guide={request.guidance.folder}")
    if request.events:
        command.append("--progress=jsonl")
    command += [] if file is None else ["--", file]
    label = "" if file is None else f"{shown(file)}: "
    # Its sentences are this command's; Blender's own at start and end are for nobody.
    process = subprocess.Popen(command, stdin=subprocess.PIPE)
    limits = request.limits
    if limits.memory:
        machine.limit_memory(process.pid, limits.memory)
    start = time.monotonic()
    try:
        while process.poll() is None:
            if limits.seconds is not None and time.monotonic() - start > limits.seconds:
                complain(f"{label}given up after {limits.seconds:g} s (--time-limit).")
                return False
            time.sleep(_PAUSE)
    finally:
        process.kill()
        process.wait()
        process.stdin.close()
        folders = {Path(path).parent for path in outputs.values()}
        folders |= {request.guidance.folder} if request.guidance else set()
        for folder in folders:
            for left in folder.glob(f"{PARTIAL}{process.pid}-*"):
                left.unlink(missing_ok=True)
    if process.returncode not in (exit_codes.DONE, exit_codes.FAILED):
        memory = " It may have needed more than --memory-limit." if limits.memory else ""
        complain(f"{label}Blender ended with {machine.end_in_words(process.returncode)}.{memory}")
    return process.returncode == exit_codes.DONE
