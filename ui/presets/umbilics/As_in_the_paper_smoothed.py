import bpy

settings = bpy.context.scene.umbilics

settings.method = "S"
settings.parametrization = "projection"
settings.triangles = "published"
settings.charts = "automatic"
settings.curvature = "normals"
settings.scale_auto = True
settings.scale = 2.0
settings.scale_unit = "rings"
settings.crease_angle_auto = False
settings.crease_angle = 3.141592653589793
settings.crease_marks = True
settings.join_borders = True
settings.normal_smoothing = 10
settings.normal_filter = "mean"
settings.opening = 2
settings.flatness = 0.01
settings.persistence_auto = False
settings.persistence = 0.0
settings.regions = False
settings.at_most = 0
settings.merge = False
