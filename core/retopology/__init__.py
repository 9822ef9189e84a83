"""From a detection to a plan for a quad mesh, and to the quads themselves."""
