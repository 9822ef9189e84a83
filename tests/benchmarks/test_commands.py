"""The commands of the benchmarks call what there is, and a page says all of them."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
COMMANDS = sorted(path for path in (ROOT / "benchmarks").iterdir() if path.is_file())
COMMANDS = [path for path in COMMANDS if not path.suffix]


@pytest.mark.parametrize("command", COMMANDS, ids=lambda path: path.name)
def test_a_command_runs_what_there_is(command):
    text = command.read_text()
    tools = re.findall(r"\$tools/(\w+\.(?:py|sh))", text)
    (module,) = re.findall(r"-m benchmarks\.(\w+)", text)
    assert tools
    for tool in tools:
        assert (ROOT / "tools" / tool).is_file(), tool
    assert (ROOT / "benchmarks" / f"{module}.py").is_file()
    assert f"`benchmarks/{command.name}`" in (ROOT / "docs" / "testing.md").read_text()
