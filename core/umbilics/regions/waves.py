"""Waves of a few edges that the mesh resolves, and the scale that looks past them.

A coarse mesh that a Subdivision Surface modifier rounds is smooth from edge to edge and uneven from
face to face of its cage: nothing there is noise to a fit of two rings, every wave has umbilics of
its own, and all of them are certain. They are the surface's; whoever wants those of the form
beneath has to say so by a scale that spans the waves.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from ..result import Umbilics

# Fewer vertices than this to an umbilic, where there are many, are waves. Chosen on a random
# harmonic surface that Blender's voxel and smooth remeshers made coarse and two levels of
# subdivision fine again (35 to 37; three levels 112; without a modifier 1,600 and more); five more
# surfaces (random fields, metaballs) had 36 to 77. Of 30 meshes that people have made Spot has the
# fewest, 130.
_VERTICES = 120
_MANY = 100
# Radius of a fit that spans the waves, in distances from an umbilic to the next. Of 3, 4 and 5 it
# is the one that left fewest umbilics beside the true ones on the first; on the five others it
# leaves 4 to 6 of 638 to 1,607, the true ones being 4 to 12.
_SPAN = 4.0


def words_on_waves(candidates: Umbilics, vertices: int) -> tuple[str, ...]:
    """What to say of a surface of so many vertices that has waves of a few edges; () of others."""
    place = candidates.position[candidates.certain & candidates.resolved]
    if len(place) < _MANY or vertices >= _VERTICES * len(place):
        return ()
    next_one = cKDTree(place).query(place, k=2)[0][:, 1]
    length = f"{_SPAN * np.median(next_one):.2g}"
    return (
        f"The surface has waves of a few edges, as a coarse mesh has that a Subdivision Surface "
        f"modifier rounds, and {len(place)} umbilics on them. For those of the form beneath, set "
        f"Scale to a Length of about {length}.",
    )
