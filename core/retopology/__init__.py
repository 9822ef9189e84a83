"""From umbilics to a plan for a quad mesh, and to the quads."""
