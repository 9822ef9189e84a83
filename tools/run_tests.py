"""Run the tests: without Blender, inside it, and in its window.

All set-up is done here: a Python with NumPy, SciPy and pytest, a Blender if there is none, the
extension's zip, and its installation in preferences of its own. The suites are

  core      tests/core and tests/benchmarks, in an ordinary Python
  tools     tests/tools, there as well; they use Blender from outside
  blender   tests/operators, tests/ui and (without those marked slow or once) tests/core, in
            `blender -b` against the installed zip
  gui       tests/gui, in an ordinary Python, which drives windows by tools/window

and, only with --matrix,

  matrix    tests/operators and tests/ui in each Blender that there is as a Python module: 4.2 LTS,
            4.5 LTS, 5.0 and 5.2 LTS, where SciPy must come from the zip's own wheel

On a machine with two cores or more two run beside each other, the long ones in parts, so that both
cores have work to the end, and windows beside both, for these wait more than they compute; what the
second and third print comes when a part is through. --quick is core's tests but for those marked
slow, which take most of the time.

Other arguments are pytest's. Paths among them choose the suites too.
"""

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
import threading
import time
import xml.etree.ElementTree as ElementTree
from collections import Counter, deque
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import blender_modules
import build_extension
import isolated_blender
from places import BLENDER, REPOSITORY, cache_folder, say
from python_packages import packages_for_blender, test_python

SUITES = {
    "core": ("tests/core", "tests/benchmarks"),
    "tools": ("tests/tools",),
    "blender": ("tests/operators", "tests/ui", "tests/core"),
    "gui": ("tests/gui",),
    "matrix": ("tests/operators", "tests/ui"),
}
# Those that run when none is named. Whoever is free takes the next: those that start something of
# their own come first, the even parts of core fill what is left of the time.
USUAL = ("blender", "gui", "tools", "core")
# How many parts a suite is cut in: those that come last are short, so that nobody waits for one.
PARTS = {"core": 12, "blender": 2, "gui": 6}
# How many others a test that is marked slow takes as long as (2.3 s and 0.1 s on one core).
SLOWNESS = 20

# pytest's own exit codes.
NO_TESTS = 5


def paths_of(suite: str, given: list[str]) -> list[str]:
    """Which of the paths given, or of its own folders, a suite runs."""
    folders = [REPOSITORY / name for name in SUITES[suite]]
    if not given:
        return [str(folder) for folder in folders if any(folder.glob("**/test_*.py"))]
    return [
        path
        for path in given
        if any(Path(path.split("::")[0]).resolve().is_relative_to(folder) for folder in folders)
        or Path(path).resolve() in (REPOSITORY, REPOSITORY / "tests")
    ]


@dataclass(frozen=True)
class Part:
    """Some of a suite's tests, which run in one process."""

    suite: str
    name: str
    paths: list[str]


def parts_of(suite: str, given: list[str]) -> list[Part]:
    """What a suite runs, in as many parts as it is cut in; one if paths are given."""
    paths = paths_of(suite, given)
    count = 1 if given else PARTS.get(suite, 1)
    if count == 1:
        return [Part(suite, suite, paths)] if paths else []
    files = [file for path in paths for file in sorted(Path(path).rglob("test_*.py"))]
    dealt: list[list[str]] = [[] for _ in range(min(count, len(files)))]
    loads = [0] * len(dealt)
    for load, file in sorted(((_load(suite, file), file) for file in files), reverse=True):
        least = loads.index(min(loads))
        dealt[least].append(str(file))
        loads[least] += load
    return [
        Part(suite, f"{suite} {number} of {len(dealt)}", sorted(some))
        for number, some in enumerate(dealt, start=1)
    ]


def _load(suite: str, file: Path) -> int:
    """About how long a file's tests take, in tests that are not marked slow."""
    text = file.read_text(encoding="utf-8")
    slow = text.count("pytest.mark.slow") if suite == "core" else 0
    return text.count("def test_") + SLOWNESS * slow


def split_arguments(arguments: list[str]) -> tuple[list[str], list[str]]:
    """pytest's arguments as paths of tests and all the others."""
    paths, options = [], []
    for previous, argument in zip(["", *arguments], arguments, strict=False):
        is_value = previous in ("-k", "-m", "-n", "-o", "-p", "-c", "-W")
        is_path = not is_value and Path(argument.split("::")[0]).exists()
        (paths if is_path else options).append(argument)
    return paths, options


def counts_in(report: Path) -> Counter:
    """Passed, failed and skipped tests of a JUnit report; empty if pytest did not get to it."""
    if not report.exists():
        return Counter()
    counts = Counter()
    for suite in ElementTree.parse(report).getroot().iter("testsuite"):
        total, failed, skipped = (
            int(suite.get("tests", 0)),
            int(suite.get("failures", 0)) + int(suite.get("errors", 0)),
            int(suite.get("skipped", 0)),
        )
        counts += Counter(passed=total - failed - skipped, failed=failed, skipped=skipped)
    return counts


def in_words(counts: Counter) -> str:
    return ", ".join(f"{counts[kind]} {kind}" for kind in ("passed", "failed", "skipped"))


class Tests:
    """One run of some suites, with the folders and the Blender that they share."""

    def __init__(self, folder: Path, given: list[str], options: list[str]):
        self.folder = folder
        self.given = given
        self.options = options
        self.reports = folder
        self.counts = Counter()
        self.failed = []
        self._installed: dict[str, str] = {}
        self._parts = 0
        self._installing = threading.Lock()
        self._counting = threading.Lock()
        self._taking = threading.Lock()
        # Where a suite beside another puts what it prints, by thread.
        self._aside = threading.local()

    def run(self, suites: Iterable[str]) -> None:
        """Suites in their order, two parts beside each other where there are two cores, and one
        of those that wait for a window beside these."""
        parts = [part for suite in suites for part in parts_of(suite, self.given)]
        if (os.cpu_count() or 1) < 2:
            self._run_next(deque(parts))
            return
        windows = deque(part for part in parts if part.suite == "gui")
        others = deque(part for part in parts if part.suite != "gui")
        with ThreadPoolExecutor(2) as pool:
            beside = [pool.submit(self._run_next, others, windows, aside=True)]
            if windows and others:
                beside.append(pool.submit(self._run_next, windows, aside=True))
            self._run_next(others, windows)
            for one in beside:
                one.result()

    def _run_next(self, *waiting: deque[Part], aside: bool = False) -> None:
        """Run parts until none is left; what one `aside` prints comes when it is through."""
        while True:
            with self._taking:
                line = next(filter(None, waiting), None)
                if line is None:
                    return
                part = line.popleft()
            run = getattr(self, f"_{part.suite}")
            if not aside:
                self._counted(part.name, run, part.paths)
                continue
            path = self.folder / f"{part.name}.txt"
            with path.open("w") as self._aside.output:
                self._counted(part.name, run, part.paths)
            print(path.read_text(errors="replace"), end="", flush=True)

    def run_matrix(self) -> None:
        """Every Blender module, two at a time; one that must be there and is not fails."""
        paths = paths_of("matrix", self.given)
        if not paths:
            return
        isolated_blender.describe()  # sets up the Blender that builds the zip, and says so
        zip_file = build_extension.build(self.folder / "matrix", "linux-x64")
        with ThreadPoolExecutor(min(2, os.cpu_count() or 1)) as pool:
            running = [
                pool.submit(self._module, module, zip_file, paths)
                for module in blender_modules.MODULES
            ]
            for one in running:
                one.result()

    def _module(self, module: blender_modules.Module, zip_file: Path, paths: list[str]) -> None:
        name = f"Blender {module.name}, Python {module.python}"
        try:
            command = blender_modules.command_of(module)
        except blender_modules.UnavailableError as reason:
            say(f"{name}: NOT TESTED, {reason}.")
            if module.required:
                self.failed.append(name)
            return
        environment = isolated_blender.environment(self.folder / module.bpy)
        say(f"{name}: {blender_modules.install(command, zip_file, environment)}")
        path = self.folder / f"{module.bpy}.txt"
        with path.open("w") as self._aside.output:
            self._counted(name, partial(self._inside, command, environment), paths)
        print(path.read_text(errors="replace"), end="", flush=True)

    def _counted(self, name: str, run: Callable[[list[str]], int], paths: list[str]) -> None:
        report = self.reports / f"{name}.xml"
        report.unlink(missing_ok=True)
        start = time.monotonic()
        code = run([f"--junitxml={report}", *self.options, *paths])
        counts = counts_in(report)
        say(f"{name}: {in_words(counts)} in {time.monotonic() - start:.0f} s")
        with self._counting:
            self.counts += counts
            if code not in (0, NO_TESTS):
                self.failed.append(name)

    def _core(self, arguments: list[str]) -> int:
        return self._pytest([test_python(), "-m", "pytest"], arguments, dict(os.environ))

    def _tools(self, arguments: list[str]) -> int:
        return self._pytest([test_python(), "-m", "pytest"], arguments, self._environment())

    def _blender(self, arguments: list[str]) -> int:
        command = [BLENDER, "-b", "--python-exit-code", "1", "--python"]
        return self._inside(command, self._environment(), arguments)

    def _inside(self, command: list, environment: dict, arguments: list[str]) -> int:
        if not any(argument in ("-m", "--markexpr") for argument in arguments) and not self.given:
            arguments = ["-m", "not slow and not once", *arguments]
        script = REPOSITORY / "tools" / "pytest_in_blender.py"
        command = [*command, script, "--", packages_for_blender()]
        return self._pytest(command, arguments, environment)

    def _gui(self, arguments: list[str]) -> int:
        environment = self._environment() | {"UMBILICS_WINDOW": str(REPOSITORY / "tools/window")}
        return self._pytest([test_python(), "-m", "pytest"], arguments, environment)

    def _environment(self) -> dict[str, str]:
        """Preferences of a part's own in which the extension is installed and enabled."""
        with self._installing:
            if not self._installed:
                self._installed = self._install()
            self._parts += 1
            own = self.folder / f"blender-{self._parts}"
            shutil.copytree(self.folder / "blender", own, symlinks=True)
        return isolated_blender.environment(own) | self._installed

    def _install(self) -> dict[str, str]:
        """Build the zip and install it; what tells the tests where it lies."""
        start = time.monotonic()
        zip_file = build_extension.build_for_this_blender(self.folder)
        built = time.monotonic()
        isolated_blender.install(zip_file, self.folder / "blender")
        say(
            f"built {zip_file.name} in {built - start:.0f} s, "
            f"installed it in {time.monotonic() - built:.0f} s"
        )
        return {"UMBILICS_ZIP": str(zip_file)}

    def _pytest(self, command: list, arguments: list[str], environment: dict) -> int:
        sys.stdout.flush()
        return subprocess.run(
            [*map(str, command), *arguments],
            cwd=REPOSITORY,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=getattr(self._aside, "output", None),
            stderr=getattr(self._aside, "output", None),
            check=False,
        ).returncode


def main() -> None:
    parser = argparse.ArgumentParser(
        prog="tools/test",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    for suite in SUITES:
        parser.add_argument(
            f"--{suite}", action="append_const", const=suite, dest="suites", help="only this suite"
        )
    parser.add_argument(
        "--quick", action="store_true", help="core's tests that take no more than a moment"
    )
    parser.add_argument("--summary", type=Path, help="write the closing line to this file too")
    parser.add_argument(
        "--reports", type=Path, help="a folder for what JUnit would say, durations too"
    )
    chosen, rest = parser.parse_known_args()
    paths, options = split_arguments(rest)
    if chosen.quick:
        options += ["-m", "not slow"]

    scratch = cache_folder() / "test-runs"
    scratch.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=scratch) as folder:
        tests = Tests(Path(folder), paths, options)
        if chosen.reports:
            chosen.reports.mkdir(parents=True, exist_ok=True)
            tests.reports = chosen.reports.resolve()
        if chosen.quick:
            tests.run(["core"])
        else:
            tests.run(suite for suite in chosen.suites or USUAL if suite != "matrix")
            if "matrix" in (chosen.suites or ()):
                tests.run_matrix()

    if tests.failed:
        say(f"failed: {', '.join(tests.failed)}")
    summary = in_words(tests.counts)
    print(summary, flush=True)
    if chosen.summary:
        chosen.summary.write_text(summary + "\n")
    ran = tests.counts["passed"] + tests.counts["failed"]
    if not ran:
        say("no test was run.")
    raise SystemExit(1 if tests.failed or not ran else 0)


if __name__ == "__main__":
    main()
