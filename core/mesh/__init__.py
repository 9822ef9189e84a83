"""The surface: repair, half-edges, neighbourhoods, normals, creases, charts."""
