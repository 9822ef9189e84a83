"""Guides to lines of curvature of a few surfaces, made once, and how much lines turn."""

from functools import cache

import numpy as np
from surfaces import cylinder, ellipsoid, noisy, random_ellipsoid, torus

import core

MESHES = {
    "ellipsoid": ellipsoid(subdivisions=5),
    "fine ellipsoid": ellipsoid(subdivisions=6),
    "random ellipsoid": random_ellipsoid(20000),
    "torus": torus(),
    "cylinder": cylinder(),
}


def guided(mesh):
    detection = core.detect(mesh.vertices, mesh.triangles)
    return core.Guide(mesh.vertices, mesh.triangles, detection)


@cache
def guide_of(name):
    return guided(MESHES[name])


@cache
def lines_of(name):
    return guide_of(name).lines()


@cache
def rough_guide():
    """Of a noisy ellipsoid. Normals alone feel the noise; jets would choose a larger scale."""
    mesh = noisy(MESHES["ellipsoid"], 0.05)
    settings = core.Settings(curvature="normals", normal_smoothing=3)
    detection = core.detect(mesh.vertices, mesh.triangles, settings)
    return core.Guide(mesh.vertices, mesh.triangles, detection)


def turning(lines, step):
    """Degrees that lines turn per step of their length."""
    turned = steps = 0.0
    for number in range(len(lines)):
        points = lines.points(number)
        chord = np.linalg.norm(np.diff(points, axis=0), axis=1)
        arc = np.concatenate([[0.0], np.cumsum(chord)])
        at = np.arange(0.0, arc[-1], step)
        even = np.stack([np.interp(at, arc, axis) for axis in points.T], axis=1)
        ahead = np.diff(even, axis=0)
        ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
        cosine = np.einsum("ij,ij->i", ahead[1:], ahead[:-1])
        turned += np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0))).sum()
        steps += len(cosine)
    return turned / steps
