"""Evenly spaced lines are whole where they can be."""

import numpy as np
from surfaces import torus

import core


def test_no_stump_stays_where_a_longer_line_fits():
    """On a torus all lines are circles; what is left between them, they fill in long pieces. A
    line of which its neighbours of the same round leave little waits for another round."""
    mesh = torus()
    detection = core.detect(mesh.vertices, mesh.triangles)
    lines = core.Guide(mesh.vertices, mesh.triangles, detection).lines()
    step = np.linalg.norm(np.diff(lines.position, axis=0), axis=1)
    line = np.repeat(np.arange(len(lines)), np.diff(lines.start))
    inner = line[1:] == line[:-1]
    length = np.bincount(line[1:][inner], step[inner])
    assert length.min() > 0.3 * np.median(length)
