"""The one shader of the overlay, made when something is drawn for the first time.

It moves each vertex from its place along two directions on the surface, by lengths of the world
and by pixels, and lifts it a little towards the viewer, so that strokes lie on a curved surface
without sinking in.
"""

from __future__ import annotations

import functools

import gpu
import numpy as np
from mathutils import Matrix, Vector

from ...operators.drawing.shapes import Shape
from .camera import Camera

# Of a vertex, with how many numbers each; see `Shape`.
_ATTRIBUTES = {"centre": 3, "u": 3, "v": 3, "reach": 4, "colour": 4}
# All in the object's space; `length_in_world` knows how its transform stretches a vector.
_VERTEX = """
float length_in_world(vec3 a)
{
  vec3 stretched = vec3(dot(vec3(metric.x, shear.xy), a),
                        dot(vec3(shear.x, metric.y, shear.z), a),
                        dot(vec3(shear.y, shear.z, metric.z), a));
  return max(sqrt(max(dot(a, stretched), 0.0)), 1e-30);
}

void main()
{
  vec3 a = u / length_in_world(u);
  vec3 b = v / length_in_world(v);
  /* Length of a pixel of the screen at this depth. */
  float pixel = size.y * (matrix * vec4(centre, 1.0)).w;
  vec3 place = centre + a * (reach.x * size.x + reach.z * pixel);
  place += b * (reach.y * size.x + reach.w * pixel);
  gl_Position = matrix * vec4(place, 1.0);
  vec3 towards = viewer.xyz - viewer.w * place;
  vec3 lifted = place + towards / length_in_world(towards) * (size.w + 2.0 * pixel);
  vec4 above = matrix * vec4(lifted, 1.0);
  gl_Position.z = above.z / above.w * gl_Position.w;
  tint = vec4(colour.rgb, colour.a * size.z);
}
"""
_FRAGMENT = """
void main()
{
  out_colour = tint;
}
"""


@functools.cache
def shader() -> gpu.types.GPUShader:
    """The shader, compiled the first time."""
    info = gpu.types.GPUShaderCreateInfo()
    # 128 bytes, which is what every graphics card has room for.
    info.push_constant("MAT4", "matrix")
    info.push_constant("VEC3", "metric")
    info.push_constant("VEC3", "shear")
    # Where the viewer is (w = 1) or the direction to it (w = 0).
    info.push_constant("VEC4", "viewer")
    # Length of a unit in the world, of a pixel at depth 1, opacity, and how far to lift.
    info.push_constant("VEC4", "size")
    for slot, (name, width) in enumerate(_ATTRIBUTES.items()):
        info.vertex_in(slot, f"VEC{width}", name)
    passed = gpu.types.GPUStageInterfaceInfo("umbilics_overlay")
    passed.smooth("VEC4", "tint")
    info.vertex_out(passed)
    info.fragment_out(0, "VEC4", "out_colour")
    info.vertex_source(_VERTEX)
    info.fragment_source(_FRAGMENT)
    return gpu.shader.create_from_info(info)


def place(camera: Camera, model: Matrix) -> gpu.types.GPUShader:
    """The shader, bound for what lies in the space of an object with this transform."""
    program = shader()
    program.bind()
    stretch = model.to_3x3()
    metric = stretch.transposed() @ stretch
    back = model.inverted_safe()
    viewer = Vector(camera.viewer[:3])
    if camera.viewer[3]:
        viewer = back @ viewer
    else:
        viewer = back.to_3x3() @ viewer
    program.uniform_float("matrix", camera.view_projection @ model)
    program.uniform_float("metric", (metric[0][0], metric[1][1], metric[2][2]))
    program.uniform_float("shear", (metric[0][1], metric[0][2], metric[1][2]))
    program.uniform_float("viewer", (*viewer, camera.viewer[3]))
    return program


def batch(shape: Shape) -> gpu.types.GPUBatch:
    """The shape on the GPU."""
    return batch_of(corners(shape), shape.triangles)


def corners(shape: Shape) -> gpu.types.GPUVertBuf:
    """The vertices of a shape on the GPU, for batches of some of its triangles."""
    layout = gpu.types.GPUVertFormat()
    for name, width in _ATTRIBUTES.items():
        layout.attr_add(id=name, comp_type="F32", len=width, fetch_mode="FLOAT")
    buffer = gpu.types.GPUVertBuf(layout, len(shape.centre))
    for name in _ATTRIBUTES:
        buffer.attr_fill(name, np.ascontiguousarray(getattr(shape, name), np.float32))
    return buffer


def batch_of(buffer: gpu.types.GPUVertBuf, triangles: np.ndarray) -> gpu.types.GPUBatch:
    """Triangles (t, 3) of what `corners` has given."""
    elements = np.ascontiguousarray(triangles, np.int32)
    indices = gpu.types.GPUIndexBuf(type="TRIS", seq=elements)
    return gpu.types.GPUBatch(type="TRIS", buf=buffer, elem=indices)


def forget() -> None:
    """Let go of the shader."""
    shader.cache_clear()
