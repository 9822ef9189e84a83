"""Umbilical points: where they are, what they are, which of them are real."""
