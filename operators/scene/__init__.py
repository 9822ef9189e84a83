"""What results look like in the scene, and how it is left as it was found."""
