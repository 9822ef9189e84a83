"""A surface cut into charts, opened to disks and unfolded to the plane."""
