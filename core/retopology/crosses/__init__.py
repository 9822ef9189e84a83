"""The smooth cross field: how far it is smoothed, and which poles it holds."""
