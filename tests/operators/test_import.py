"""What Blender's importers add to a mesh, and that it does not change the curvature."""

import bpy
import numpy as np
from scene_building import add_ellipsoid, empty_scene


def detected(addon):
    bpy.ops.umbilics.detect()
    mesh = bpy.context.active_object.data
    return addon.operators.mesh.attributes.read_result(mesh, "umbilics_k1")


def test_a_file_with_a_normal_for_each_corner_gives_what_one_without_gives(addon, tmp_path):
    empty_scene()
    found = []
    for normals in (True, False):
        path = tmp_path / f"{normals}.obj"
        empty_scene()
        add_ellipsoid(subdivisions=5).data.shade_flat()
        bpy.ops.wm.obj_export(filepath=str(path), export_materials=False, export_normals=normals)
        empty_scene()
        bpy.ops.wm.obj_import(filepath=str(path))
        bpy.context.view_layer.objects.active = bpy.context.selected_objects[0]
        found.append(detected(addon))
        marked = np.zeros(len(bpy.context.active_object.data.edges), bool)
        bpy.context.active_object.data.edges.foreach_get("use_edge_sharp", marked)
        # From 4.3 on the importer marks edges as soon as there are normals.
        assert (marked.mean() > 0.5) == (normals and bpy.app.version >= (4, 3))
    np.testing.assert_allclose(found[0], found[1], rtol=1e-5)
