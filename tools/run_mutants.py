"""Mutation testing of the modules that decide: would a test notice if they decided otherwise?

Cosmic Ray makes the mutants: another number, operator or comparison, a loop that does not run, and
so on. Each is run against the fast tests of its module, in a copy of the repository, one after the
other. A module has thousands of mutants, so that some are drawn: first places in its code, all as
likely as each other, then one of the mutants of each place. Annotations are left out, which
nothing evaluates. docs/testing.md says what came of it.
"""

import argparse
import ast
import importlib
import os
import random
import shutil
import signal
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import cosmic_ray.plugins
import pytest
from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code
from decisions import DECISIONS

REPOSITORY = Path(__file__).resolve().parents[1]
# The modules that decide, and the tests that are to notice; the quickest first.
MODULES = {
    "core/base/blas.py": ("base/test_blas.py",),
    "core/base/subsets.py": ("base/test_subsets.py",),
    "core/mesh/half_edges.py": ("mesh/test_half_edges.py", "mesh/test_cleaning.py"),
    "core/mesh/creases.py": ("mesh/test_creases.py",),
    "core/mesh/mending/slits.py": ("mesh/test_cleaning.py",),
    "core/mesh/mending/t_junctions.py": ("mesh/test_mending.py",),
    "core/curvature/outliers.py": ("curvature/test_outliers.py",),
    "core/curvature/scale.py": ("curvature/test_scale.py",),
    "core/curvature/noise.py": ("curvature/test_noise.py",),
    "core/curvature/fits/flattened.py": ("curvature/test_flattened.py",),
    "core/umbilics/pairing/persistence.py": (
        "umbilics/pairing/test_persistence.py",
        "umbilics/test_importance.py",
    ),
    "core/umbilics/pairing/cancelling.py": (
        "umbilics/pairing/test_cancelling.py",
        "umbilics/pairing/test_persistence.py",
    ),
    "core/umbilics/filters.py": ("umbilics/test_filters.py", "curvature/test_opening.py"),
    "core/umbilics/pairing/merge_tree.py": (
        "umbilics/pairing/test_merge_tree.py",
        "umbilics/pairing/test_persistence.py",
    ),
    "core/umbilics/regions/find.py": (
        "umbilics/regions/test_regions.py",
        "mesh/test_tessellated.py",
        "umbilics/regions/test_curves.py",
    ),
    "core/umbilics/regions/round_shapes.py": (
        "umbilics/regions/test_regions.py",
        "mesh/test_tessellated.py",
    ),
    "core/umbilics/regions/unresolved.py": (
        "umbilics/regions/test_curves.py",
        "umbilics/regions/test_drowned.py",
        "umbilics/regions/test_regions.py",
    ),
    "core/umbilics/regions/waves.py": ("umbilics/regions/test_waves.py",),
    "core/umbilics/refine.py": ("umbilics/test_refine.py",),
    "core/umbilics/fitted_zero.py": ("umbilics/test_refine.py",),
    "core/umbilics/kind.py": ("umbilics/test_kind.py",),
    "core/umbilics/suitability.py": ("curvature/test_suitability.py",),
    "core/umbilics/judged.py": ("umbilics/test_judged.py", "umbilics/pairing/test_unseen_pairs.py"),
    "core/curvature/close_up/closer.py": ("umbilics/test_refine.py",),
    "core/retopology/poles.py": ("retopology/test_poles.py",),
    "core/retopology/pole_places.py": ("retopology/test_poles.py",),
    "core/retopology/crosses/cross_field.py": (
        "retopology/crosses/test_cross_field_minimum.py",
        "retopology/crosses/test_cross_field.py",
    ),
    "core/retopology/crosses/smoothing.py": (
        "retopology/crosses/test_smoothing.py",
        "retopology/crosses/test_cross_field_minimum.py",
    ),
    "core/retopology/crosses/dipoles.py": (
        "retopology/crosses/test_dipoles.py",
        "retopology/test_thin_sheets.py",
    ),
    "core/matching/mirror_planes.py": ("matching/test_symmetry.py",),
    "core/retopology/field/near_pairs.py": ("retopology/crosses/test_near_pairs.py",),
    "core/retopology/quads/finishing/faults/mending.py": (
        "retopology/quads/test_quads_finishing.py",
    ),
    "core/retopology/quads/finishing/opening.py": ("retopology/quads/test_opening.py",),
}
# Loaded once: each mutant is run in a fork of this process.
WARM = ("numpy", "scipy.sparse.linalg", "scipy.sparse.csgraph", "scipy.spatial", "hypothesis")
KILLED, SURVIVED, TOO_LONG = "killed", "SURVIVED", "killed (does not end)"


def mutants_of(source: str) -> dict[tuple[int, int], list[tuple[str, int]]]:
    """Of each place (line, column) in the code the operators, and which of their occurrences."""
    found: dict[tuple[int, int], list[tuple[str, int]]] = {}
    spans = list(_annotations(source))
    nodes = list(ast_nodes(get_ast(source)))
    for name in cosmic_ray.plugins.operator_names():
        kind = cosmic_ray.plugins.get_operator(name)
        if kind.arguments():
            continue
        operator = kind()
        places = (start for node in nodes for start, _ in operator.mutation_positions(node))
        for occurrence, place in enumerate(places):
            if not any(first <= place < last for first, last in spans):
                found.setdefault(place, []).append((name, occurrence))
    return found


def _annotations(source: str) -> Iterator[tuple[tuple[int, int], tuple[int, int]]]:
    for node in ast.walk(ast.parse(source)):
        for name in ("annotation", "returns"):
            inside = getattr(node, name, None)
            if inside is not None:
                yield (
                    (inside.lineno, inside.col_offset),
                    (inside.end_lineno, inside.end_col_offset),
                )


def drawn(source: str, count: int, seed: int) -> list[tuple[int, str]]:
    """Line and source of `count` mutants; all places once before any a second time."""
    mutants = mutants_of(source)
    chance = random.Random(seed)
    places = sorted(mutants)
    chance.shuffle(places)
    made = []
    for place in sorted(places[:count]):
        name, occurrence = chance.choice(mutants[place])
        operator = cosmic_ray.plugins.get_operator(name)()
        made.append((place[0], mutate_code(source, operator, occurrence)))
    return made


def outcome_of(folder: Path, tests: list[str], seconds: float) -> str:
    """What becomes of the tests with the code in a folder."""
    child = os.fork()
    if child == 0:
        os.setpgid(0, 0)
        silent = os.open(os.devnull, os.O_WRONLY)
        os.dup2(silent, 1)
        os.dup2(silent, 2)
        os.chdir(folder)
        options = ["-x", "-q", "-p", "no:cacheprovider", "-m", "not slow", "--hypothesis-seed=0"]
        os._exit(pytest.main([*options, *tests]))
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            return SURVIVED if status == 0 else KILLED
        time.sleep(0.02)
    os.killpg(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return TOO_LONG


def changed_line(before: str, after: str, line: int) -> str:
    old, new = before.splitlines(), after.splitlines()
    now = new[line - 1].strip() if line <= len(new) else ""
    return f"{old[line - 1].strip()}  ->  {now}"


def run(module: str, count: int, seed: int, folder: Path) -> tuple[int, int]:
    """How many mutants of a module there were, and how many were killed."""
    tests = [f"tests/core/{name}" for name in MODULES[module]]
    path = folder / module
    source = path.read_text()
    start = time.monotonic()
    if outcome_of(folder, tests, 600.0) != SURVIVED:
        raise SystemExit(f"{module}: its tests fail as it is")
    usual = time.monotonic() - start
    mutants = drawn(source, count, seed)
    killed = 0
    for line, mutant in mutants:
        path.write_text(mutant)
        outcome = outcome_of(folder, tests, 30.0 + 5.0 * usual)
        killed += outcome != SURVIVED
        print(f"{outcome}: {module}:{line}: {changed_line(source, mutant, line)}", flush=True)
    path.write_text(source)
    share = 100.0 * killed / max(len(mutants), 1)
    print(f"{module}: {killed} of {len(mutants)} killed ({share:.0f} %)\n", flush=True)
    return len(mutants), killed


def run_decisions(folder: Path) -> tuple[int, int]:
    """How many decisions were switched off, and how many of them a test noticed."""
    killed = 0
    for one in DECISIONS:
        path = folder / one.module
        source = path.read_text()
        if source.count(one.before) != 1:
            raise SystemExit(f"{one.module}: {one.before!r} does not stand there once")
        path.write_text(source.replace(one.before, one.after))
        outcome = outcome_of(folder, [f"tests/core/{one.tests}"], 600.0)
        killed += outcome != SURVIVED
        print(f"{outcome}: {one.change} ({one.tests})", flush=True)
        path.write_text(source)
    return len(DECISIONS), killed


def main() -> None:
    parser = argparse.ArgumentParser(
        prog="tools/mutate",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("modules", nargs="*", metavar="MODULE", help=f"of {', '.join(MODULES)}")
    parser.add_argument("--sample", type=int, default=30, help="mutants of each (default: 30)")
    parser.add_argument("--seed", type=int, default=0, help="which are drawn (default: 0)")
    parser.add_argument(
        "--decisions", action="store_true", help="switch off those of tools/decisions.py instead"
    )
    chosen = parser.parse_args()
    unknown = set(chosen.modules) - set(MODULES)
    if unknown:
        parser.error(f"{', '.join(sorted(unknown))}: not in the list; see --help")
    os.nice(10)
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        os.environ[name] = "1"
    sys.dont_write_bytecode = True
    for name in WARM:
        importlib.import_module(name)
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch) / "umbilics"
        shutil.copytree(
            REPOSITORY, folder, ignore=shutil.ignore_patterns(".git", "__pycache__", ".*_cache")
        )
        if chosen.decisions:
            totals = [run_decisions(folder)]
        else:
            modules = chosen.modules or MODULES
            totals = [run(module, chosen.sample, chosen.seed, folder) for module in modules]
    made, killed = map(sum, zip(*totals, strict=True))
    print(f"{killed} of {made} mutants killed ({100.0 * killed / made:.1f} %)")


if __name__ == "__main__":
    main()
