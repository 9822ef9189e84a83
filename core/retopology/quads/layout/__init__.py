"""Rectangles between tracks, whole numbers for their sides, grids in them."""
