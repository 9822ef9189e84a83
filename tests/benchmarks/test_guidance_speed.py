"""The page about the guidance's speed says what was measured."""

from benchmarks import guidance_speed
from benchmarks.guidance_speed import measured, page


def run(seconds, lines=400):
    steps = {"detection": (2.0, 3.0), "cross field and poles": (seconds, 6.0)}
    steps["lines of curvature"] = (5.0, 5.5)
    dense = {"dropped umbilics leave": (2.0, 2.5), "automatic cross field": (5.0, 10.0)}
    return {
        "triangles": 81920,
        "seconds": steps,
        "lines": lines,
        "field": 3.0,
        "dense": dense,
        "dropped": 12345,
    }


def test_figures_are_medians_and_ratios_to_the_detection():
    text = page([run(5.0), run(4.0, 410), run(9.0, 405)], "two cores")
    assert "on two cores." in text
    assert "81,920" in text
    assert "| detection | 2.00 | 3.00 | 1.0 |" in text
    assert "| cross field and poles | 5.00 | 6.00 | 2.5 |" in text
    assert "| 405 lines of curvature | 5.00 | 5.50 | 2.5 |" in text
    assert "takes 1.5 times the detection" in text
    assert "12,345 umbilics" in text
    assert "| dropped umbilics leave | 2.00 | 2.50 |" in text
    assert "leave in 0.25 of the automatic cross field's processor time" in text


def test_every_step_is_measured(monkeypatch):
    monkeypatch.setattr(guidance_speed, "SPACING", 0.3)
    found = measured(3)
    assert found["triangles"] == 1280
    assert found["lines"] > 0
    assert len(found["seconds"]) == 4
    assert len(found["dense"]) == 2
    assert found["dropped"] > 50
    assert all(clock > 0.0 for clock, _ in found["seconds"].values())
