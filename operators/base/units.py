"""Units of curvature, as the scene measures lengths."""

import bpy

_FOOT = 0.3048


def of_curvature(scene: bpy.types.Scene, power: int = 1) -> tuple[str, float]:
    """The name of 1 / length to a power, and what a value in Blender's units is times in it."""
    measured = scene.unit_settings
    raised = "²" if power == 2 else ""
    if measured.system == "METRIC":
        return f"1/m{raised}", measured.scale_length**-power
    if measured.system == "IMPERIAL":
        return f"1/ft{raised}", (measured.scale_length / _FOOT) ** -power
    return f"1/unit{raised}", 1.0


def length(scene: bpy.types.Scene, value: float) -> str:
    """A length as the scene shows it, for example "1.2 mm"."""
    measured = scene.unit_settings
    if measured.system == "NONE":
        return f"{value:.3g}"
    in_metres = value * measured.scale_length
    return str(bpy.utils.units.to_string(measured.system, "LENGTH", in_metres, precision=4))


def curvature(scene: bpy.types.Scene, value: float) -> str:
    """A curvature as the scene measures lengths, for example "0.12 1/m"."""
    unit, factor = of_curvature(scene)
    return f"{value * factor:.3g} {unit}"
