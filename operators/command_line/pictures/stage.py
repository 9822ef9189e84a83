"""A scene of its own to draw in, removed afterwards with all that was put into it."""

from __future__ import annotations

import errno
import os
import tempfile
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix

from ...base.errors import FileError
from ..files import by_blender
from ..files.guard import shown
from ..files.quiet import quiet

_BACKGROUND = (0.93, 0.935, 0.945)
# Room around the mesh, as a fraction of its extent.
_MARGIN = 1.16
# The last chunk of every PNG file: no data, its name, its check sum.
_PNG_END = b"\0\0\0\0IEND\xaeB`\x82"


@dataclass(frozen=True, init=False)
class View:
    """An orthographic view that holds all points.

    Attributes
    ----------
    frame:
        (3, 3) the image's right, up and backward directions, as columns.
    centre:
        (3,) the point in the middle of the image.
    width, height, depth:
        Extent of the image and of the points along the view.
    """

    frame: np.ndarray
    centre: np.ndarray
    width: float
    height: float
    depth: float

    def __init__(
        self, points: np.ndarray, up: str, turn: float, aspect: float, lift: float = 0.28
    ) -> None:
        """Look at (n, 3) points from the front, turned by `turn` degrees; up is "Y" or "Z".

        `lift` is how far the viewer stands above, as a fraction of the distance.
        """
        angle = np.radians(turn + 28.0)
        level = np.array([np.sin(angle), -np.cos(angle), 0.0])
        back = level + np.array([0.0, 0.0, lift])
        above = np.array([0.0, 0.0, 1.0])
        if up == "Y":
            # The same view of a mesh that lies on its back: (x, y, z) seen as (x, -z, y).
            back, above = (np.array([v[0], v[2], -v[1]]) for v in (back, above))
        back = back / np.linalg.norm(back)
        right = np.cross(above, back)
        right /= np.linalg.norm(right)
        frame = np.column_stack([right, np.cross(back, right), back])
        seen = points @ frame
        low, high = seen.min(axis=0), seen.max(axis=0)
        extent = np.maximum(high - low, 1e-6 * float((high - low).max()))
        width = _MARGIN * max(extent[0], extent[1] * aspect)
        values = {
            "frame": frame,
            "centre": frame @ (0.5 * (low + high)),
            "width": float(width),
            "height": float(width / aspect),
            "depth": float(extent[2]),
        }
        for name, value in values.items():
            object.__setattr__(self, name, value)

    def matrix(self, x: float, y: float, towards: float) -> Matrix:
        """A frame facing the viewer: x, y from the image's middle, `towards` the viewer."""
        matrix = np.eye(4)
        matrix[:3, :3] = self.frame
        matrix[:3, 3] = self.centre + self.frame @ (x, y, towards)
        return Matrix(matrix)


class Stage:
    """A Workbench scene with a camera; a context manager that leaves nothing behind."""

    def __init__(self, width: int, height: int) -> None:
        self._size = width, height
        self._objects: list[bpy.types.Object] = []

    def __enter__(self) -> Stage:
        self.scene = bpy.data.scenes.new("umbilics picture")
        self._world = bpy.data.worlds.new("umbilics picture")
        self._world.color = _BACKGROUND
        self.scene.world = self._world
        self._camera = bpy.data.objects.new(
            "umbilics picture", bpy.data.cameras.new("umbilics picture")
        )
        self._camera.data.type = "ORTHO"
        self.scene.collection.objects.link(self._camera)
        self.scene.camera = self._camera
        self._objects.append(self._camera)
        render = self.scene.render
        render.engine = "BLENDER_WORKBENCH"
        render.resolution_x, render.resolution_y = self._size
        render.resolution_percentage = 100
        render.image_settings.file_format = "PNG"
        render.image_settings.color_mode = "RGBA"
        # Dithering against bands is noise to a PNG: files four times as large.
        render.dither_intensity = 0.0
        self.scene.view_settings.view_transform = "Standard"
        self.scene.display.render_aa = "8"
        shading = self.scene.display.shading
        shading.light = "STUDIO"
        shading.color_type = "OBJECT"
        shading.show_cavity = True
        shading.cavity_type = "BOTH"
        shading.cavity_ridge_factor = 0.4
        shading.cavity_valley_factor = 0.8
        shading.show_object_outline = False
        shading.show_specular_highlight = False
        return self

    def __exit__(self, *_: object) -> None:
        self.drop(self._objects)
        bpy.data.scenes.remove(self.scene)
        bpy.data.worlds.remove(self._world)

    def add(self, data: bpy.types.ID, colour: tuple[float, ...]) -> bpy.types.Object:
        """Show a mesh or a text in a colour; the stage owns it from now on."""
        obj = bpy.data.objects.new("umbilics picture", data)
        obj.color = colour
        self.scene.collection.objects.link(obj)
        self._objects.append(obj)
        return obj

    def drop(self, objects: list[bpy.types.Object]) -> None:
        """Remove objects and their data."""
        data = [obj.data for obj in objects]
        gone = set(objects)
        self._objects = [obj for obj in self._objects if obj not in gone]
        bpy.data.batch_remove(gone)
        bpy.data.batch_remove(set(data))

    def look(self, view: View) -> None:
        """Point the camera."""
        distance = 2.0 * (view.depth + view.width)
        camera = self._camera.data
        camera.ortho_scale = max(view.width, view.height)
        camera.clip_start = 1e-3 * distance
        camera.clip_end = 2.0 * distance
        self._camera.matrix_world = view.matrix(0.0, 0.0, distance)

    def pixels(self) -> np.ndarray:
        """Draw; (height, width, 4) float32 pixels, bottom row first.

        Raises
        ------
        FileError
            The temporary folder is full.
        """
        width, height = self._size
        with tempfile.TemporaryDirectory() as folder:
            path = str(Path(folder) / "umbilics.png")
            self.scene.render.filepath = path
            with quiet():
                bpy.ops.render.render(write_still=True, scene=self.scene.name)
            if not by_blender.ends_with(Path(path), _PNG_END):
                reason = os.strerror(errno.ENOSPC)
                raise FileError(f"{shown(path)}: a view cannot be written ({reason}).")
            image = bpy.data.images.load(path)
            try:
                pixels = np.empty(height * width * 4, dtype=np.float32)
                image.pixels.foreach_get(pixels)
            finally:
                bpy.data.images.remove(image)
        return pixels.reshape(height, width, 4)


def save_pixels(path: Path, pixels: np.ndarray) -> None:
    """Write (height, width, 4) pixels, bottom row first, as a PNG file.

    Raises
    ------
    FileError
        The file cannot be written.
    """
    height, width = pixels.shape[:2]
    image = bpy.data.images.new("umbilics picture", width, height)
    # Only rendering to a file takes the compression; a scene says how.
    scene = bpy.data.scenes.new("umbilics picture")
    scene.view_settings.view_transform = "Standard"
    scene.render.dither_intensity = 0.0
    settings = scene.render.image_settings
    settings.file_format, settings.color_mode, settings.compression = "PNG", "RGB", 100
    image.pixels.foreach_set(np.ascontiguousarray(pixels, dtype=np.float32).ravel())
    try:
        by_blender.write(path, lambda place: image.save_render(place, scene=scene), _PNG_END)
    finally:
        bpy.data.images.remove(image)
        bpy.data.scenes.remove(scene)
