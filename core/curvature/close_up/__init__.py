"""Fits of higher degree where the field turns, blended into the others."""
