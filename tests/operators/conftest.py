"""Each test starts in an empty file."""

import pytest


@pytest.fixture(autouse=True)
def _empty_file(addon):
    from scene_building import empty_scene

    empty_scene()
