"""No option gets lost: not on the way to a batch's processes, for --resume, or in reports."""

import argparse
import re
import shlex
from importlib import import_module, util
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]

CANDIDATES = ("1", "2", "0.5", "0.25", "30", "3", "50", "NAME", "1-3", "csv", "more.obj")
# What says where results go and how the work is shared out, and changes nothing in a result.
ELSEWHERE = {
    *("help", "json", "blend", "png", "ply", "usda", "out", "also", "guide", "jobs", "report"),
    *("resume", "part", "tolerant", "summary", "time_limit", "memory_limit", "progress", "options"),
    *("worker", "final"),
}
# What asks for more in a report and is no setting of what is there.
NO_SETTING = {
    *("object", "frames", "per_vertex", "compare", "guide_files", "ridges", "check_topology"),
    *("strokes", "align_to", "find_symmetry"),
}
# What a request says of the results.
FACTS = (
    *("objects", "frames", "source", "settings", "given_names", "per_vertex", "compare"),
    *("planning", "matching", "check", "steering"),
)


@pytest.fixture
def arguments(addon):
    return import_module(f"{addon.__name__}.operators.command_line.arguments.parser")


@pytest.fixture
def base(tmp_path):
    """Arguments with which every option counts for something."""
    for name in ("x.obj", "more.obj", "strokes.obj"):
        (tmp_path / name).write_text("v 0 0 0\n")
    return [
        *(tmp_path / "x.obj", "--out", tmp_path / "o", "--guide", tmp_path / "g"),
        *("--quads", 100, "--check-topology", tmp_path / "more.obj"),
        *("--strokes", tmp_path / "strokes.obj", "--align-to", tmp_path / "more.obj"),
    ]


def changes(action):
    """What may be said of an option, some of it wrong."""
    name = action.option_strings[0]
    if action.dest == "scope_group":
        yield ["--scope", "group", name, "NAME"]
    elif isinstance(action, argparse.BooleanOptionalAction):
        yield [action.option_strings[1] if action.default else name]
    elif action.nargs == 0:
        yield [name]
    elif action.choices and action.dest != "guide_files":
        yield from ([name, choice] for choice in action.choices if choice != action.default)
    else:
        # That one counts with given curvature alone.
        before = ["--curvature", "given"] if action.dest in ("k1", "k2", "d1", "d2") else []
        yield from ([*before, name, value] for value in CANDIDATES)


def options(arguments):
    found = [action for action in arguments._parser()._actions if action.option_strings]
    return [action for action in found if action.dest not in ELSEWHERE]


def facts(request):
    found = {name: getattr(request, name) for name in FACTS}
    return found | {"files": request.guidance.kinds, "quads": request.guidance.remeshing}


@pytest.fixture
def requests(arguments, base, tmp_path, monkeypatch, capsys):
    """What is asked for, without and with each option: its action and the two requests."""
    monkeypatch.chdir(tmp_path)

    def parsed(*more):
        return arguments.parse([str(argument) for argument in (*base, *more)])

    plain = parsed()
    found = []
    for action in options(arguments):
        for change in changes(action):
            try:
                request = parsed(*change)
            except SystemExit:
                continue
            if facts(request) != facts(plain):
                found.append((action, request))
                break
        else:
            pytest.fail(f"{action.option_strings[0]} changes nothing")
    assert len(found) > 40
    return plain, found


def test_a_process_of_a_batch_is_asked_for_the_same(arguments, requests):
    _, found = requests
    for action, request in found:
        given = request.batch.worker_arguments
        again = arguments.parse([*given, "--worker", "--json=j", "--guide=g2", "--", "x.obj"])
        assert facts(again) == facts(request), action.dest


def test_what_was_done_with_another_setting_is_done_again(requests):
    plain, found = requests
    for action, request in found:
        keys = [(one.batch.worker_arguments, one.batch.key) for one in (plain, request)]
        assert keys[0] != keys[1], action.dest


def test_every_setting_is_in_the_report(requests):
    plain, found = requests
    before = plain.every_setting()
    for action, request in found:
        if action.dest not in NO_SETTING:
            after = request.every_setting()
            assert after.get(action.dest) != before.get(action.dest), action.dest
    assert all(isinstance(value, str | int | float | bool) for value in before.values())


def test_what_was_not_asked_for_is_not_said_to_be_set(arguments, base):
    detection = arguments.parse([str(base[0]), "--json", "o.json"]).every_setting()
    assert {"method", "source", "scope", "at_most"} <= detection.keys()
    assert not {"plan", "k1", "scope_group", "quads", "stroke_influence"} & detection.keys()


def test_an_option_that_counts_for_nothing_is_refused(arguments, base, capsys):
    """Alone, without what it belongs to."""

    def parsed(*more):
        return arguments.parse([str(base[0]), *more])

    plain = parsed()
    counting = {name: getattr(plain, name) for name in FACTS} | plain.every_setting()
    refused = set()
    for action in options(arguments):
        for change in changes(action):
            try:
                request = parsed(*change)
            except SystemExit as stop:
                assert stop.code == 2
                if f"error: {action.option_strings[0]} needs " in capsys.readouterr().err:
                    refused.add(action.dest)
                continue
            found = {name: getattr(request, name) for name in FACTS} | request.every_setting()
            is_usual = action.type is not None and action.type(change[-1]) == action.default
            assert found != counting or is_usual, change
    expected = {"edge_length", "spacing", "stroke_influence", "guide_files", "ridges"}
    assert expected <= refused and not {"opening", "frames", "object"} & refused
    with pytest.raises(SystemExit):
        parsed("--k1", "NAME")
    assert "error: --k1 needs --curvature given." in capsys.readouterr().err


def test_a_wrong_setting_is_called_as_its_option(arguments, base, capsys):
    for option, value, words in (
        ("--stroke-influence", "3", "--stroke-influence must lie between 0 and 1, not 3."),
        ("--line-smoothness", "3", "--line-smoothness must lie between 0 and 1, not 3."),
        ("--spacing", "-1", "--spacing must be 0 or more, not -1."),
        ("--quad-smoothness", "7", "--quad-smoothness must lie between 0 and 1, not 7."),
        ("--opening", "-1", "--opening must "),
    ):
        with pytest.raises(SystemExit):
            arguments.parse([*map(str, base), option, value])
        assert f"error: {words}" in capsys.readouterr().err


def test_a_refusal_names_a_way_that_there_is(arguments, tmp_path, capsys):
    for option, words in (
        ("--json", "each file has its JSON there"),
        ("--png", "say --also png"),
        ("--options", "--options: expected one argument"),
    ):
        given = ["a.obj", "--out", str(tmp_path), option]
        with pytest.raises(SystemExit):
            arguments.parse(given if option == "--options" else [*given, "o"])
        assert words in capsys.readouterr().err


@pytest.mark.parametrize("option", ["--check-topology", "--strokes", "--align-to"])
def test_what_was_done_with_another_file_beside_it_is_done_again(arguments, base, option):
    given = [str(argument) for argument in base]
    before = arguments.parse(given).batch.key
    with open(given[given.index(option) + 1], "a") as file:
        file.write("v 1 0 0\n")
    assert arguments.parse(given).batch.key != before


def test_the_page_says_what_the_help_says(arguments):
    spec = util.spec_from_file_location("page", ROOT / "tools" / "make_command_page.py")
    tool = util.module_from_spec(spec)
    spec.loader.exec_module(tool)
    assert tool.page(arguments._parser()) == tool.PAGE.read_text("utf-8"), f"run {tool.__doc__}"


def commands():
    """What follows the name of the command in every line of a block of the pages that calls it."""
    for page in (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))):
        text = page.read_text("utf-8")
        for block in re.findall(r"^```\n(.*?)^```", text, re.MULTILINE | re.DOTALL):
            for line in block.replace("\\\n", " ").splitlines():
                _, called, words = line.partition("--command umbilics")
                if called:
                    yield words


# What the commands of the pages read.
FILES = ("part.stl", "scans/a.ply", "extra.ply", "meshes/b.obj", "c.stl")


@pytest.mark.parametrize("words", [one for one in commands() if "[FILE" not in one])
def test_the_commands_of_the_pages_are_understood(arguments, tmp_path, monkeypatch, words):
    monkeypatch.chdir(tmp_path)
    for name in FILES:
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text("v 0 0 0\n")
    given = shlex.split(words.replace("$SLURM_ARRAY_TASK_ID", "3"))
    if "--help" in given:
        with pytest.raises(SystemExit) as ended:
            arguments.parse(given)
        assert ended.value.code == 0
    else:
        assert arguments.parse(given)
