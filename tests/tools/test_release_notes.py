"""The notes of a release are its part of the changelog."""

from build_extension import manifest
from places import REPOSITORY
from release_notes import notes

LOG = "# Changelog\n\n## [0.2.0] - 2026-12-01\n\n- New.\n\n## 0.1.0\n\n- First.\n  More.\n"


def test_each_version_has_its_own_part():
    assert notes(LOG, "0.2.0") == "- New.\n"
    assert notes(LOG, "0.1.0") == "- First.\n  More.\n"
    assert notes(LOG, "0.3.0") == ""


def test_the_changelog_tells_of_the_version_in_the_manifest():
    changelog = (REPOSITORY / "CHANGELOG.md").read_text("utf-8")
    assert notes(changelog, manifest()["version"])
