"""The presets that are shipped: each sets every setting, and the paper's are the paper."""

import dataclasses
from pathlib import Path

import bpy
import pytest

FOLDER = Path(__file__).resolve().parents[2] / "ui" / "presets" / "umbilics"
PRESETS = sorted(FOLDER.glob("*.py"))


def chosen(addon, preset):
    """The settings after a preset, whatever they were before."""
    exec(compile(preset.read_text(), preset.name, "exec"), {})
    return addon.operators.data.properties.to_settings(bpy.context.scene.umbilics)


def upset(addon):
    """Settings that are all another than the defaults."""
    group = bpy.context.scene.umbilics
    for name, option in addon.core.options().items():
        if option.kind == "choice":
            setattr(group, name, option.choices[-1].value)
        elif option.kind == "flag":
            setattr(group, name, not getattr(group, name))
        else:
            setattr(group, name, 1)
            if option.automatic:
                setattr(group, f"{name}_auto", not getattr(group, f"{name}_auto"))


@pytest.mark.parametrize("preset", PRESETS, ids=lambda preset: preset.stem)
def test_a_preset_sets_every_setting(addon, preset):
    fresh = chosen(addon, preset)
    upset(addon)
    assert dataclasses.asdict(chosen(addon, preset)) == dataclasses.asdict(fresh)


@pytest.mark.parametrize(
    ("name", "passes"), [("As_in_the_paper", 0), ("As_in_the_paper_smoothed", 10)]
)
def test_the_papers_presets_are_the_paper(addon, name, passes):
    core = addon.core
    assert chosen(addon, FOLDER / f"{name}.py") == core.Settings(
        parametrization="projection",
        triangles="published",
        curvature="normals",
        crease_angle=180.0,
        normal_smoothing=passes,
        opening=2,
        persistence=0.0,
        regions=False,
        merge=False,
    )
