"""Quad meshes along the cross field: seamless map, layout of rectangles, whole numbers, grids."""
