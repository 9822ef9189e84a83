"""The decisions that `tools/mutate --decisions` switches off are those that there are."""

from pathlib import Path

import pytest
from decisions import DECISIONS

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.parametrize("decision", DECISIONS, ids=lambda decision: decision.change)
def test_a_decision_stands_in_its_module_once(decision):
    source = (ROOT / decision.module).read_text()
    assert source.count(decision.before) == 1
    changed = source.replace(decision.before, decision.after)
    assert changed != source
    compile(changed, decision.module, "exec")
    assert (ROOT / "tests" / "core" / decision.tests).is_file()
