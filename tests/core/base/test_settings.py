"""The settings: one definition, checked on construction."""

import dataclasses

import pytest

import core


def test_every_setting_has_an_option_and_a_default_that_passes():
    assert list(core.options()) == [item.name for item in dataclasses.fields(core.Settings)]
    assert core.Settings(**core.defaults()) == core.Settings()
    for name, option in core.options().items():
        assert option.label and option.help, name


@pytest.mark.parametrize(
    "wrong",
    [
        {"method": "X"},
        {"curvature": "jet"},
        {"normal_smoothing": -1},
        {"normal_smoothing": 1.5},
        {"normal_smoothing": True},
        {"opening": 1000},
        {"persistence": -0.1},
        {"persistence": float("nan")},
        {"persistence": "automatic"},
        {"scale": float("inf")},
        {"crease_angle": 181},
        {"regions": 1},
        {"curvature": "given", "normal_smoothing": 2},
    ],
)
def test_wrong_values_are_named(wrong):
    with pytest.raises(core.InvalidSettingsError) as error:
        core.Settings(**wrong)
    assert "must" in str(error.value) or "needs" in str(error.value)


def test_settings_cannot_be_changed():
    with pytest.raises(dataclasses.FrozenInstanceError):
        core.Settings().method = "I"
