"""The frames that empties, glyphs and pictures of umbilics stand in."""

from types import SimpleNamespace

import numpy as np


def test_frames_are_orthonormal_whatever_the_separatrices_are(addon):
    """Seen in a fit's plane they are not quite perpendicular to the normal; or there is none."""
    random = np.random.default_rng(0)
    normal = random.standard_normal((9, 3))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    separatrix = random.standard_normal((9, 3, 3))
    separatrix /= np.linalg.norm(separatrix, axis=2, keepdims=True)
    separatrix[3:, 1:] = np.nan
    separatrix[6:] = np.nan
    position = random.standard_normal((9, 3))
    umbilics = SimpleNamespace(normal=normal, separatrix=separatrix, position=position)
    frames = addon.operators.drawing.frames.frames_of(umbilics)
    axes = frames[:, :3, :3]
    np.testing.assert_allclose(
        np.swapaxes(axes, 1, 2) @ axes, np.tile(np.eye(3), (9, 1, 1)), atol=1e-12
    )
    np.testing.assert_allclose(np.linalg.det(axes), 1.0)
    np.testing.assert_allclose(axes[:, :, 2], normal)
    np.testing.assert_array_equal(frames[:, :3, 3], position)
    np.testing.assert_array_equal(frames[:, 3], np.tile([0.0, 0.0, 0.0, 1.0], (9, 1)))
    # x lies in the plane of the normal and the separatrix, on its side.
    ray = separatrix[3:6, 0]
    across = np.cross(normal[3:6], ray)
    assert np.abs(np.einsum("kc,kc->k", axes[3:6, :, 0], across)).max() < 1e-12
    assert (np.einsum("kc,kc->k", axes[3:6, :, 0], ray) > 0.0).all()
    none = SimpleNamespace(normal=normal[:0], separatrix=separatrix[:0], position=position[:0])
    assert addon.operators.drawing.frames.frames_of(none).shape == (0, 4, 4)
