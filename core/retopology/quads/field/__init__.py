"""Crosses in the triangles, and moving their poles."""
