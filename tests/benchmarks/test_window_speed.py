"""The page about the window says what was measured."""

from benchmarks.window_speed import page


def _run(**seconds):
    return {"seconds": 10.0, "reading": 0.1, "longest": 0.2, "writing": 0.5, "draws": 0} | seconds


def _drag(orbit, drag):
    shown = {"filtering": [0.01, 0.02, 0.03], "building": [0.0, 0.03, 0.02]}
    return {"orbit": orbit, "drag": drag, "shown": [9000, 500, 4]} | shown


def test_freezes_rates_and_ratios_are_those_measured():
    text = page(
        {
            "triangles": 1310720,
            "candidates": 9000,
            "detect_away": _run(longest=0.12),
            "detect_seen": _run(longest=0.24, draws=3),
            "seen, no overlay": _drag(0.6, 0.7),
            "seen, overlay": _drag(0.8, 1.4),
            "away, no overlay": _drag(0.2, 0.3),
            "away, overlay": _drag(0.4, 0.3),
        },
        "two cores",
    )
    assert "on two cores." in text
    assert "1,310,720 triangles" in text
    assert "| mesh out of view | 10.0 s | 0.10 s | 0.12 s | 0.50 s | 0 |" in text
    assert "| mesh in view | 10.0 s | 0.10 s | 0.24 s | 0.50 s | 3 |" in text
    # Orbit: how much of the frame rate is left.
    assert "| mesh in view | 0.60 s | 0.80 s | 0.75 |" in text
    assert "| mesh out of view | 0.20 s | 0.40 s | 0.50 |" in text
    # Drag: work of each step after the first, and frames.
    assert "| 500 | 20 ms | 30 ms | 20 |" in text
    assert "| 9,000 |" not in text
    assert "| mesh in view | 0.70 s | 1.40 s | 0.50 |" in text
