"""What plans, lines and quads look like in the scene."""
