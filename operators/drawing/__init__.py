"""What the overlay draws, as arrays: extracted here without a GPU, drawn by `ui.overlay`.

`shapes` is what all is made of, `strokes` are the fields of directions, `umbilics` the glyphs, rays
and discs of the points.
"""
