"""The terms of the extensions site, as far as a test can hold them; docs/extensions_site.md."""

import ast
import re
import struct
import tomllib
from importlib import metadata
from pathlib import Path

import build_extension
import pytest
import scipy_wheels

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "extensions_site.md").read_text("utf-8")
MANIFEST = tomllib.loads((ROOT / "blender_manifest.toml").read_text("utf-8"))
# Modules that reach into the network.
NETWORK = {"socket", "ssl", "urllib.request", "http", "requests", "ftplib", "smtplib", "asyncio"}


def section(title):
    return re.search(rf"^## {title}\n(.*?)(?=^## |\Z)", PAGE, re.DOTALL | re.MULTILINE)[1]


# What the description calls each operator; the kind of what it does where several do the same.
CALLED = {
    "Add Arrows": "arrows",
    "Add Pole": "poles of a quad mesh, by hand",
    "Align to Other": "another scan",
    "Align to X": "aligned",
    "Apply Filters to Umbilics": "filters",
    "Cancel Detection": "esc",
    "Check Topology": "check topology",
    "Clear Umbilics": "",
    "Clear Umbilics in File": "",
    "Compare Methods": "compared",
    "Copy Umbilic Coordinates": "copied",
    "Delete Umbilic": "deleted",
    "Detect Umbilics": "umbilic",
    "Draw Guides": "grease pencil",
    "Explain": "explained",
    "Export Guidance": "files for",
    "Find Mirror Plane": "mirror plane",
    "Find Rotation Axis": "rotation axis",
    "Frame Umbilic": "framed",
    "Hide Curvature Map": "maps",
    "Lines of Curvature": "lines of curvature",
    "Mark Edges": "marked edges",
    "Mend and Detect": "mends",
    "New Retopology Mesh": "new retopology mesh",
    "Pick Umbilic": "clicked",
    "Pin Umbilic": "pinned",
    "Plan Poles": "plan of the poles",
    "Preview Layout": "preview of its layout",
    "Remesh to Quads": "remesh to quads",
    "Restore Deleted Umbilics": "restored",
    "Ridges": "ridges",
    "Separatrices": "separatrices",
    "Show Angles": "check topology",
    "Show Curvature Map": "maps",
    "Write Guidance Files": "files for",
}


def test_the_description_names_what_the_add_on_does():
    text = " ".join(section("Description").lower().split())
    sources = [file.read_text("utf-8") for file in sorted((ROOT / "operators").glob("*.py"))]
    labels = {label for source in sources for label in re.findall(r'bl_label = "(.*)"', source)}
    assert labels == CALLED.keys()
    does = ("attributes", "geometry nodes", "cross field", "edit mode", "linked", "command line")
    assert [word for word in (*CALLED.values(), *does) if word not in text] == []


def test_the_description_names_the_files_that_are_read_and_written():
    text = section("Description").lower()
    kinds = ROOT / "operators" / "command_line" / "files" / "file_kinds.py"
    read = set(re.findall(r'^    "\.(\w+)": \(', kinds.read_text(), re.MULTILINE))
    assert {"obj", "usda", "blend"} <= read
    names = {"glb": "gltf", "abc": "alembic", "blend": ".blend"}
    names |= dict.fromkeys(("usd", "usda", "usdc", "usdz"), "usd")
    assert [kind for kind in sorted(read) if names.get(kind, kind) not in text] == []
    for written in ("json", "csv", "pictures", ".blend", "ply", "usd", "quadwild", "directional"):
        assert written in text


def test_the_permission_is_said_for_command_line_and_panel():
    (reason,) = MANIFEST["permissions"].values()
    assert f'"{reason}"' in section("Permission")
    assert "panel" in section("Permission") and "command line" in section("Permission")
    assert len(reason) <= 64 and reason[-1].isalnum()


def test_there_is_a_website():
    assert MANIFEST["website"].startswith("https://")


def test_holders_of_what_is_bundled_are_in_the_manifest():
    """Those that SciPy's own licence file names for SciPy and for each library of its wheels."""
    files = metadata.files("scipy") or []
    text = next(file for file in files if file.name == "LICENSE.txt").read_text()
    holders = " ".join(MANIFEST["copyright"])
    for entry in MANIFEST["copyright"]:
        assert re.match(r"\d{4}(-\d{4})? \S", entry), entry
    assert "Enthought" in text and "Enthought" in holders and "SciPy Developers" in holders
    bundled = set(re.findall(r"^Name: (.+)$", text, re.MULTILINE))
    if not bundled:
        pytest.skip("this SciPy is not the one of the wheels: nothing is bundled with it")
    assert [name for name in sorted(bundled) if name.strip() not in holders] == []


def test_nothing_that_ships_can_reach_the_network():
    for file in build_extension.files_to_ship():
        if file.suffix != ".py":
            continue
        for node in ast.walk(ast.parse((ROOT / file).read_text("utf-8"))):
            names = []
            if isinstance(node, ast.Import):
                names = [alias.name for alias in node.names]
            elif isinstance(node, ast.ImportFrom) and not node.level:
                names = [node.module]
                names += [f"{node.module}.{alias.name}" for alias in node.names]
            assert not NETWORK & {*names, *(name.split(".")[0] for name in names)}, file


def test_the_images_are_there_in_the_sizes_that_are_asked_for():
    named = re.findall(r"`(docs/[\w/.-]+\.png)`", section("Images"))
    assert len(named) >= 4
    for name in named:
        width, height = struct.unpack(">II", (ROOT / name).read_bytes()[16:24])
        assert (width, height) == (256, 256) if "icon" in name else width >= 1280, name


def test_every_test_that_the_checklist_names_is_there():
    names = re.findall(r"`(tests/[\w/]+\.py)`", section("Checklist"))
    assert len(names) >= 5
    assert [name for name in names if not (ROOT / name).is_file()] == []


FACTS = {"version": [5, 2, 2], "scipy": False, "platform": "linux-x64", "python": "3.13"}


def test_the_zip_for_a_blender_is_one_that_it_takes():
    assert build_extension.platform_for(FACTS) == "linux-x64"
    # Debian's: its Python is too new for the wheels, and has SciPy.
    assert build_extension.platform_for(FACTS | {"scipy": True, "python": "3.14"}) is None
    for facts in ({"python": "3.14"}, {"platform": "windows-arm64", "python": "3.11"}):
        with pytest.raises(SystemExit):
            build_extension.platform_for(FACTS | facts)


def test_building_without_options_makes_the_zip_for_the_blender_here(monkeypatch, tmp_path, capsys):
    def build(output, platform):
        path = output / f"umbilics-{platform}.zip"
        path.write_bytes(b"")
        return path

    monkeypatch.setattr(build_extension, "build", build)
    for facts, named in ((FACTS, "linux-x64"), (FACTS | {"scipy": True}, "None")):
        monkeypatch.setattr(build_extension.isolated_blender, "describe", lambda facts=facts: facts)
        monkeypatch.setattr("sys.argv", ["build", "--output", str(tmp_path)])
        build_extension.main()
        assert (tmp_path / f"umbilics-{named}.zip").exists()
        last = capsys.readouterr().err.strip().splitlines()[-1]
        assert last.endswith(f"umbilics-{named}.zip")
    assert all((tmp_path / f"umbilics-{name}.zip").exists() for name in scipy_wheels.TAGS)
