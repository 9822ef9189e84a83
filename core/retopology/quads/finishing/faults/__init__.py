"""Folded, skewed and crossing quads: found, and mended in their place."""
