"""Injective seamless maps of a cut surface to the plane."""
