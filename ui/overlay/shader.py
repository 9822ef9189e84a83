"""The one shader of the overlay, made when something is drawn for the first time.

It moves each vertex from its place along two directions on the surface, by lengths of the world
and by pixels, and lifts it a little towards the viewer, so that strokes lie on a curved surface
without sinking in.
"""

from __future__ import annotations

import gpu
import numpy as np
from gpu_extras.batch import batch_for_shader

from ...operators.drawables import Shape

_VERTEX = """
void main()
{
  vec3 place = (model * vec4(centre, 1.0)).xyz;
  vec3 a = mat3(model) * u;
  vec3 b = mat3(model) * v;
  a /= max(length(a), 1e-30);
  b /= max(length(b), 1e-30);
  vec4 clip = view_projection * vec4(place, 1.0);
  /* Length of a pixel of the screen at this depth. */
  float pixel = size.y * clip.w;
  place += a * (reach.x * size.x + reach.z * pixel) + b * (reach.y * size.x + reach.w * pixel);
  gl_Position = view_projection * vec4(place, 1.0);
  vec3 towards = viewer.xyz - viewer.w * place;
  vec3 lifted = place + towards / max(length(towards), 1e-30) * (size.w + 2.0 * pixel);
  vec4 above = view_projection * vec4(lifted, 1.0);
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

_shader: gpu.types.GPUShader | None = None


def shader() -> gpu.types.GPUShader:
    """The shader, compiled the first time."""
    global _shader
    if _shader is None:
        info = gpu.types.GPUShaderCreateInfo()
        for name, kind in (("view_projection", "MAT4"), ("model", "MAT4")):
            info.push_constant(kind, name)
        # Where the viewer is (w = 1) or looks from (w = 0); then the length of a unit in the
        # world, of a pixel at depth 1, the opacity and how far to lift.
        info.push_constant("VEC4", "viewer")
        info.push_constant("VEC4", "size")
        for slot, (name, kind) in enumerate(
            (
                ("centre", "VEC3"),
                ("u", "VEC3"),
                ("v", "VEC3"),
                ("reach", "VEC4"),
                ("colour", "VEC4"),
            )
        ):
            info.vertex_in(slot, kind, name)
        passed = gpu.types.GPUStageInterfaceInfo("umbilics_overlay")
        passed.smooth("VEC4", "tint")
        info.vertex_out(passed)
        info.fragment_out(0, "VEC4", "out_colour")
        info.vertex_source(_VERTEX)
        info.fragment_source(_FRAGMENT)
        _shader = gpu.shader.create_from_info(info)
    return _shader


def batch(shape: Shape) -> gpu.types.GPUBatch:
    """The shape on the GPU."""
    values = {name: getattr(shape, name) for name in ("centre", "u", "v", "reach", "colour")}
    values = {name: np.ascontiguousarray(array, np.float32) for name, array in values.items()}
    triangles = np.ascontiguousarray(shape.triangles, np.int32)
    return batch_for_shader(shader(), "TRIS", values, indices=triangles)


def forget() -> None:
    """Let go of the shader."""
    global _shader
    _shader = None
