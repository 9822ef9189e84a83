"""Other programs that find umbilics, run on the same meshes."""
