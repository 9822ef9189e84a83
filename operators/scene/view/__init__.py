"""What is seen in a view: shapes, maps, shading, framing."""
