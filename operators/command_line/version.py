"""The version of the extension, as its manifest has it."""

import tomllib
from pathlib import Path

_MANIFEST = Path(__file__).resolve().parents[2] / "blender_manifest.toml"
OURS: str = tomllib.loads(_MANIFEST.read_text("utf-8"))["version"]
