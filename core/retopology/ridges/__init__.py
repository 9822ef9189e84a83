"""Ridges and ravines: where the larger curvature is extremal along its own direction."""
