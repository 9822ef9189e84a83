"""Fields and features of faces, as field libraries and remeshers read them."""
