"""What stands in mesh files, read without Blender."""
