"""Save Blender's monkey, subdivided, as a .blend file.

blender -b --factory-startup --python tools/make_monkey.py -- FILE.blend
"""

import sys

import bpy

(file,) = sys.argv[sys.argv.index("--") + 1 :]
bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
bpy.ops.mesh.primitive_monkey_add()
monkey = bpy.context.object
monkey.modifiers.new("Subdivision", "SUBSURF").levels = 3
bpy.ops.object.modifier_apply(modifier="Subdivision")
bpy.ops.object.shade_smooth()
bpy.ops.wm.save_as_mainfile(filepath=file, compress=True)
