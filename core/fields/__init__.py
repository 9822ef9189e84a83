"""Direction fields on a surface: frames, transport, winding, planes of the triangles."""
