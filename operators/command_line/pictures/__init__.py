"""Pictures of meshes and their umbilics."""
