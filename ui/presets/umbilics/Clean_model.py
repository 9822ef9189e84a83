import bpy

settings = bpy.context.scene.umbilics

settings.method = "S"
settings.parametrization = "conformal"
settings.triangles = "certified"
settings.charts = "automatic"
settings.curvature = "jets"
settings.scale_auto = True
settings.scale = 2.0
settings.scale_unit = "rings"
settings.crease_angle_auto = True
settings.crease_angle = 0.5235987755982988
settings.crease_marks = True
settings.join_borders = True
settings.normal_smoothing = 0
settings.normal_filter = "mean"
settings.opening = 0
settings.flatness = 0.01
settings.persistence_auto = True
settings.persistence = 0.0
settings.at_most = 0
settings.regions = True
settings.merge = True
