"""Fields with exactly the singularities that are asked for."""
