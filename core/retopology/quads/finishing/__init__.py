"""Quads in their places: on the surface, even, unfolded, mirrored, reported."""
