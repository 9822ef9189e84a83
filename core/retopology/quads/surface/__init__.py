"""The surface that is mapped: pieces, features, sizes."""
