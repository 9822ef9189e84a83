"""Inside Blender: plan, lines and separatrices of meshes, drawn by Workbench."""

import importlib
import sys
from pathlib import Path

import bmesh
import bpy
import numpy as np
from mathutils import Matrix

ADD_ON = "bl_ext.user_default.umbilics"
stages = importlib.import_module(f"{ADD_ON}.operators.command_line.pictures.stage")

SIZE = 900
CLAY = (0.82, 0.80, 0.76, 1.0)
COLOURS = {0: (0.80, 0.16, 0.08, 1.0), 1: (0.08, 0.30, 0.80, 1.0)}
POLES = {3: (1.0, 0.62, 0.0, 1.0), 5: (0.02, 0.45, 0.35, 1.0)}
# Up axis and turn of the view.
# Bumpy surfaces, whose lines are smoothed.
SMOOTH = {"bunny_hr_os": 0.5, "rocker-arm": 0.4}
VIEWS = {"spot_os": ("Y", 35.0), "hand_closed_os": ("Y", 0.0), "bunny_hr_os": ("Y", 0.0)}


def empty_file() -> None:
    bpy.ops.wm.read_homefile(use_empty=True)
    if ADD_ON not in bpy.context.preferences.addons:
        bpy.ops.preferences.addon_enable(module=ADD_ON)


def ellipsoid():
    empty_file()
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=6)
    obj = bpy.context.object
    obj.name = "ellipsoid"
    points = np.array([vertex.co for vertex in obj.data.vertices])
    points *= np.array([3.0, 2.0, 1.0]) / np.linalg.norm(points, axis=1, keepdims=True)
    obj.data.vertices.foreach_set("co", points.astype(np.float32).ravel())
    return obj


def monkey():
    empty_file()
    bpy.ops.mesh.primitive_monkey_add()
    obj = bpy.context.object
    obj.name = "monkey"
    modifier = obj.modifiers.new("Subdivision", "SUBSURF")
    modifier.levels = 3
    bpy.ops.object.modifier_apply(modifier=modifier.name)
    return obj


def imported(path):
    empty_file()
    bpy.ops.wm.obj_import(filepath=str(path), forward_axis="Y", up_axis="Z")
    obj = bpy.context.selected_objects[0]
    bpy.context.view_layer.objects.active = obj
    obj.name = path.stem
    return obj


def ball(radius):
    mesh = bpy.data.meshes.new("ball")
    shape = bmesh.new()
    bmesh.ops.create_icosphere(shape, subdivisions=3, radius=radius)
    shape.to_mesh(mesh)
    shape.free()
    return mesh


def draw(obj, folder):
    """Lines with poles beside separatrices with poles, as NAME-retopology.png."""
    name = obj.name
    guidance = bpy.context.scene.umbilics_guidance
    guidance.line_smoothness_auto = False
    guidance.line_smoothness = SMOOTH.get(name, 0.0)
    for step in ("detect", "guide", "lines", "separatrices"):
        try:
            getattr(bpy.ops.umbilics, step)()
        except RuntimeError as error:
            print(f"{name}: {error}")
    bpy.context.view_layer.update()
    children = {part: [] for part in ("poles", "lines", "separatrices")}
    for child in obj.children:
        if child.get("umbilics_guidance") in children:
            children[child["umbilics_guidance"]].append(child)
    total = sum(4 - pole["umbilics_valence"] for pole in children["poles"])
    print(
        f"{name}: {len(children['poles'])} poles, sum {total} of {obj.umbilics_plan.expected}, "
        f"{sum(len(c.data.splines) for c in children['lines'])} lines, "
        f"{sum(len(c.data.splines) for c in children['separatrices'])} separatrices"
    )
    points = np.array([obj.matrix_world @ vertex.co for vertex in obj.data.vertices])
    extent = float(np.ptp(points, axis=0).max())
    up, turn = VIEWS.get(name, ("Z", 0.0))
    images = []
    for part in ("lines", "separatrices"):
        with stages.Stage(SIZE, SIZE) as stage:
            body = obj.data.copy()
            body.shade_smooth()
            stage.add(body, CLAY).matrix_world = obj.matrix_world
            for child in children[part]:
                colour = COLOURS[child["umbilics_family"]]
                curve = child.data.copy()
                curve.bevel_depth *= 1.6
                stage.add(curve, colour).matrix_world = child.matrix_world
            for pole in children["poles"]:
                mark = ball(0.011 * extent)
                place = Matrix.Translation(pole.matrix_world.translation)
                stage.add(mark, POLES[pole["umbilics_valence"]]).matrix_world = place
            stage.look(stages.View(points, up, turn, 1.0))
            images.append(stage.pixels())
    stages.save_pixels(folder / f"retopology-{name}.png", np.hstack(images))


target, *files = map(Path, sys.argv[sys.argv.index("--") + 1 :])
target.mkdir(parents=True, exist_ok=True)
for make in (ellipsoid, monkey):
    draw(make(), target)
for file in files:
    draw(imported(file), target)
