"""Methods S, I and C: where the direction field turns."""
