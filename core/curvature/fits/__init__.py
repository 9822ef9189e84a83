"""Height functions fitted to the samples around each vertex, and their shape operators."""
