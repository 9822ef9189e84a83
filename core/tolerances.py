"""The numbers that decide what counts as noise, as flat and as a region, each with its reason."""

from __future__ import annotations

# Regions ---------------------------------------------------------------------------------
# The gap of an umbilic point falls to zero and stays below the noise only in a disc about as
# wide as the point's own uncertainty; over a region it stays there for a whole area.

REGION_NOISE = 3.0
"""Gap over its standard error below which a vertex belongs to the core of a region: the length
of a plane vector of normal errors passes three times its root mean square once in 8000."""

REGION_NOISE_EDGE = 6.0
"""The same ratio up to which a region spreads from its core (hysteresis). The error of a fit
comes in part from the bias of the cubic, which neighbours share: on spheres of random points
2 vertices in 100 lie above 6."""

REGION_RATIO = 2.0
"""Most that the middle (by area) ratio may be in a region. It is about 1 where there is nothing
but noise, 2 on clean spheres of random points, and 0.7 times the limit, 4.2, in the disc around
an umbilic."""

REGION_SIZE = 3.0
"""Least area of a region, in discs of the radius that a shape operator was fitted over: smaller
ones are not told apart from the disc around an umbilic."""

REGION_BEND = 0.1
"""Largest gap in a region times the fitted radius. Across a crease the fit's error is as large
as the gap, about 1 / radius, without anything being spherical there."""

ROUND_OFF_GAP = 16.0
"""Gap, in units of eps / radius^2 (for coordinates of order 1), that round-off alone leaves."""

PLANAR_BEND = 0.01
"""Angle, in radians, that the normal of a region may turn over its radius if it is planar."""
