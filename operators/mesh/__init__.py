"""The one boundary between NumPy arrays and Blender's mesh data."""
