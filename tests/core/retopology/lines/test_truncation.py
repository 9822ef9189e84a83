"""Lines that wind for ever are cut, at a feature if they cross one."""

import numpy as np
import pytest
from exact_fields import field_on_plane, flat_surface

from core.base.progress import Progress
from core.fields.planes import barycentric_of, lay_out
from core.retopology.lines.polylines import points_of
from core.retopology.lines.tracing import FEATURE, LIMIT, MET, Obstacles, Starts, trace
from core.retopology.lines.truncation import Barriers, ended_on_features, truncated


@pytest.fixture(scope="module")
def winding():
    """A square whose lines are spirals that go clockwise from the x axis, the planes of its
    triangles, one of the lines, and where the triangles are."""
    surface, place = flat_surface(cells=81)
    angle = np.angle(place) + 0.5 * np.pi + 0.03
    planes = lay_out(surface, field_on_plane(np.exp(2j * angle)).lines, Progress())
    middle = surface.vertices[surface.triangles].mean(axis=1) * surface.unit + surface.origin
    triangle = np.linalg.norm(middle - (0.5, 0.0, 0.0), axis=1).argmin(keepdims=True)
    z = planes.corner[triangle].mean(axis=1)
    ahead, limit = np.sqrt(planes.deviator(triangle, z)), np.array([9.0]) / surface.unit
    starts = Starts.plain(triangle, z, ahead, np.zeros(1), limit)
    spiral = trace(surface, planes, starts, Obstacles.none(surface), Progress())
    return surface, planes, spiral, middle


def test_a_line_without_end_is_cut_where_it_winds(winding):
    """A turn of radius r lies 2 pi r tan(0.03) inside."""
    surface, planes, spiral, _ = winding
    assert spiral.end == LIMIT
    wide = truncated(surface, planes, spiral, 0.15 / surface.unit)
    assert 0.75 < wide.travelled[-1] * surface.unit / (2 * np.pi * 0.5) < 1.1
    narrow = truncated(surface, planes, spiral, 0.01 / surface.unit)
    assert len(narrow.travelled) == len(spiral.travelled) and narrow.end == LIMIT


def test_a_winding_line_ends_on_the_last_feature_that_it_crosses(winding):
    surface, planes, spiral, middle = winding
    wide = truncated(surface, planes, spiral, 0.15 / surface.unit)
    none = np.zeros((0, 3))
    assert wide.end == MET

    def ended(*rays, hard=()):
        """Where the line ends with pieces of crests along rays at the angles given."""
        tail, head, rows = [none], [none], [np.zeros(0, np.int64)]
        for ray in rays:
            way = np.array([np.cos(ray), np.sin(ray), 0.0])
            along = middle @ way
            near = np.linalg.norm(middle - along[:, None] * way, axis=1) < 0.02
            near &= along > 0
            rows.append(np.flatnonzero(near))
            for ends, shift in ((tail, -0.05), (head, 0.05)):
                ends.append(((along[near, None] + shift) * way - surface.origin) / surface.unit)
        barriers = Barriers(
            np.array(hard, np.int64), np.concatenate(rows), np.vstack(tail), np.vstack(head)
        )
        found = ended_on_features(surface, planes, wide, barriers)
        last = points_of(surface, planes, found.triangle[-1:], found.z[-1:])[0]
        return found, last * surface.unit + surface.origin

    same, _ = ended()
    assert same.end == MET and len(same.z) == len(wide.z)
    for rays, expected in (((5.0,), 5.0), ((5.0, 4.0), 4.0), ((4.0, 5.0), 4.0)):
        found, last = ended(*rays)
        assert found.end == FEATURE
        assert np.arctan2(last[1], last[0]) % (2 * np.pi) == pytest.approx(expected, abs=1e-6)
        assert 0.4 < np.hypot(last[0], last[1]) < 0.65
    # A hard edge is crossed where the line's point lies on it.
    at = len(wide.z) // 2
    corner = barycentric_of(planes, wide.triangle[[at]], wide.z[[at]])[0].argmin()
    found, last = ended(hard=[3 * wide.triangle[at] + (corner + 1) % 3])
    assert found.end == FEATURE and found.travelled[-1] == wide.travelled[at]
