"""Lines of curvature: tracing, even spacing, separatrices."""
