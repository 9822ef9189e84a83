"""Shape operators at the vertices, their scale and their noise."""
