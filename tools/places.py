"""Where things are, and the little that all the tools share."""

import contextlib
import fcntl
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

TOOLS = Path(__file__).resolve().parent
REPOSITORY = TOOLS.parent
BLENDER = TOOLS / "blender"


# What pip and others print when they reach no server.
_NO_NETWORK = re.compile(
    r"resolution|resolve|unreachable|connection (refused|failed|broken|timed out)|max retries|"
    r"newconnectionerror|proxyerror",
    re.IGNORECASE,
)
_NETWORK_HINT = (
    " No server could be reached: this needs the network once, later runs take what is in the "
    "cache. Behind a proxy, set https_proxy."
)


def cache_folder() -> Path:
    """The user's cache folder of these tools, the one that tools/blender uses too."""
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "umbilics"


def say(message: str) -> None:
    print(f"umbilics: {message}", file=sys.stderr, flush=True)


def fail(message: str) -> None:
    """End the tool with a message to its user."""
    say(message)
    raise SystemExit(1)


def run_quietly(command: list, what: str, **options) -> str:
    """Run a program; on failure say what could not be done, with its last lines, and end."""
    done = subprocess.run(
        [str(part) for part in command],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        errors="replace",
        check=False,
        **options,
    )
    if done.returncode != 0:
        print("\n".join(done.stdout.splitlines()[-20:]), file=sys.stderr)
        hint = _NETWORK_HINT if _NO_NETWORK.search(done.stdout) else ""
        fail(f"could not {what} (exit code {done.returncode}); see above.{hint}")
    return done.stdout


@contextlib.contextmanager
def locked(path: Path, shared: bool = False) -> Iterator[None]:
    """Hold a lock, alone or with others; it ends with the process, however that ends."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with open(path, "w") as file:
        kind = fcntl.LOCK_SH if shared else fcntl.LOCK_EX
        try:
            fcntl.flock(file, kind | fcntl.LOCK_NB)
        except BlockingIOError:
            # A run with a limit of its own seems to hang otherwise.
            say(f"waiting for another that holds {path.name} …")
            fcntl.flock(file, kind)
        yield


def made_once(folder: Path, make: Callable[[Path], None]) -> Path:
    """The folder, made by `make` if it is not there; never found half made."""
    if not folder.exists():
        with locked(folder.with_name(folder.name + ".lock")):
            if not folder.exists():
                partial = folder.with_name(folder.name + ".partial")
                shutil.rmtree(partial, ignore_errors=True)
                make(partial)
                partial.rename(folder)
    return folder
