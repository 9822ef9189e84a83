"""The two sides of a thin sheet are not near each other, however little lies between them."""

import dataclasses

import numpy as np
from surfaces import ellipsoid, grid_points

import core
from core import CurvatureField
from core.base.progress import Progress
from core.fields.planes import lay_out
from core.mesh.mending.repair import clean
from core.mesh.normals import vertex_normals
from core.retopology.crosses.dipoles import _around_pairs
from core.retopology.lines.bundles import joined_bundles
from core.retopology.lines.separatrices import discs, truncated
from core.retopology.lines.tracing import LIMIT, Traces


def sheet(thickness):
    """A square and its back, so far apart and with the normals of a sheet."""
    points, triangles = grid_points(40, 40, (-1.0, -1.0), (1.0, 1.0))
    front = np.column_stack([points, np.zeros(len(points))])
    back = front - (0.0, 0.0, thickness)
    return np.concatenate([front, back]), np.concatenate(
        [triangles, triangles[:, ::-1] + len(points)]
    )


def test_a_line_on_one_side_of_a_thin_sheet_is_not_near_one_on_the_other():
    """One line there and, as if it had come around the rim, back on the other side."""
    surface, _ = clean(*sheet(0.01))
    normal, _ = surface.face_normal_area
    middle = surface.vertices[surface.triangles].mean(axis=1)
    middle = middle * surface.unit + surface.origin
    row = np.abs(middle[:, 1] - 0.01) < 0.02
    front, back = (np.flatnonzero(row & (normal[:, 2] * side > 0.9)) for side in (1, -1))
    front, back = front[np.argsort(middle[front, 0])], back[np.argsort(-middle[back, 0])]
    planes = lay_out(surface, constant_lines(surface), Progress())
    for ways, cut in (((front, back), False), ((front, front[::-1]), True)):
        triangle = np.concatenate(ways)
        places = middle[triangle]
        step = np.linalg.norm(np.diff(places, axis=0), axis=1)
        traces = Traces(
            start=np.array([0, len(triangle)]),
            triangle=triangle,
            z=planes.corner[triangle].mean(axis=1),
            travelled=np.concatenate([[0.0], np.cumsum(step)]) / surface.unit,
            end=np.array([LIMIT], np.int8),
            obstacle=np.array([-1]),
            direction=np.ones(1, complex),
        )
        found = truncated(surface, planes, traces, 0.05 / surface.unit)
        assert (len(found.triangle) < len(triangle)) == cut


def test_an_umbilic_stops_lines_on_its_own_side_of_a_thin_sheet():
    vertices, triangles = sheet(0.01)
    mesh = ellipsoid(subdivisions=2)
    any_one = core.detect(mesh.vertices, mesh.triangles).umbilics.select(np.array([0]))
    middle = vertices[triangles].mean(axis=1)
    row = np.argmin(np.linalg.norm(middle - (0.1, 0.1, 0.0), axis=1))
    umbilic = dataclasses.replace(
        any_one,
        position=middle[[row]],
        normal=np.array([[0.0, 0.0, 1.0]]),
        triangle=np.array([row]),
        barycentric=np.full((1, 3), 1.0 / 3.0),
    )
    surface, _ = clean(vertices, triangles)
    stopped = surface.source_triangle[discs(surface, umbilic) == 0]
    assert row in stopped and len(stopped) > 10
    assert (middle[stopped, 2] > -0.005).all()


def test_opposite_poles_on_two_sides_of_a_thin_sheet_are_not_taken_together():
    vertices, triangles = sheet(0.01)
    # Not quite parallel, as no sheet is.
    vertices[len(vertices) // 2 :, 2] -= 0.05 * (vertices[len(vertices) // 2 :, 0] + 1.0)
    surface, _ = clean(vertices, triangles)
    upright, _ = surface.face_normal_area
    middle = surface.vertices[surface.triangles].mean(axis=1) * surface.unit + surface.origin
    front, back = (
        np.flatnonzero(upright[:, 2] * side > 0.9)[
            np.linalg.norm(middle[upright[:, 2] * side > 0.9, :2] - place, axis=1).argmin()
        ]
        for side, place in ((1, (0.0, 0.0)), (-1, (0.2, 0.0)))
    )
    beside = np.argsort(np.linalg.norm(middle - middle[front] - (0.2, 0.0, 0.0), axis=1))
    beside = next(row for row in beside if upright[row, 2] > 0.9)
    normal = vertex_normals(surface)
    for other, near in ((back, False), (beside, True)):
        index = np.zeros(len(surface.triangles))
        index[[front, other]] = 0.25, -0.25
        chosen = _around_pairs(surface, index, normal, 0.5, 1.0)
        assert chosen.any() == near
        # Nor is anything of the other side forgotten between two of this one.
        assert not chosen[surface.triangles[back]].any()


def test_lines_on_two_sides_of_a_thin_sheet_do_not_join():
    x = np.linspace(0.0, 1.0, 101)
    points = np.concatenate([np.c_[x, 0 * x, 0 * x], np.c_[x, 0 * x, 0 * x - 0.01]])
    line, ends = np.repeat([0, 1], 101), (np.array([0, 1]), np.array([2, 3]))
    for side, alone in ((1.0, False), (-1.0, True)):
        normal = np.repeat([[0.0, 0.0, 1.0], [0.0, 0.0, side]], 101, axis=0)
        joined = joined_bundles(points, normal, line, np.zeros(2), *ends, 0.05, 0.2)
        assert np.array_equal(joined.row, np.arange(202)) == alone


def constant_lines(surface):
    """Directions along x."""
    along = np.tile([1.0, 0.0, 0.0], (len(surface.vertices), 1))
    normal = vertex_normals(surface)
    return CurvatureField(
        np.ones(len(along)),
        np.zeros(len(along)),
        along,
        np.cross(normal, along),
        normal,
        np.zeros(len(along)),
    ).lines
