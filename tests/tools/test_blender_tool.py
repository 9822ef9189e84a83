"""tools/blender and tools/window: what they choose, and that they pass everything on."""

import os
import subprocess
from pathlib import Path

import pytest

TOOLS = Path(__file__).resolve().parents[2] / "tools"


def run(*command, **environment):
    kept = {k: v for k, v in os.environ.items() if k not in ("BLENDER", "UMBILICS_BLENDER")}
    return subprocess.run(
        [str(part) for part in command],
        env=kept | environment,
        input="standard input\n",
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.fixture
def fake(tmp_path):
    """Makes a program that says it is Blender of some version and repeats its arguments."""

    def make(version, name="blender"):
        program = tmp_path / name
        program.write_text(
            "#!/bin/sh\n"
            f'[ "$1" = --version ] && echo "Blender {version}" && exit\n'
            'for argument; do echo "[$argument]"; done\n'
            "cat\n"
            "exit 7\n"
        )
        program.chmod(0o755)
        return program

    return make


def test_the_blender_named_in_the_environment_is_taken(fake):
    done = run(TOOLS / "blender", "-b", "a b", "", BLENDER=str(fake("2.79", "old")))
    assert done.stdout == "[-b]\n[a b]\n[]\nstandard input\n"
    assert done.returncode == 7


def test_a_name_that_is_no_program_is_an_error_that_says_how_to_install_blender():
    done = run(TOOLS / "blender", "-b", BLENDER="/nowhere/blender")
    assert done.returncode == 1
    assert "/nowhere/blender" in done.stderr
    assert "blender.org/download" in done.stderr


@pytest.mark.parametrize("version", ["4.2.0", "4.5.15 LTS", "5.2.2 LTS", "10.0.0"])
def test_a_new_enough_blender_on_path_is_taken(fake, version):
    path = f"{fake(version).parent}:{os.environ['PATH']}"
    assert run(TOOLS / "blender", "x", PATH=path).stdout == "[x]\nstandard input\n"


def test_without_a_package_manager_it_says_how_to_install_blender(fake, tmp_path):
    # A PATH with the usual programs, an old Blender and no apt-get.
    old = fake("3.4.1")
    for program in ("bash", "cat", "cksum", "cut", "dirname", "flock", "head", "id", "mkdir"):
        (tmp_path / program).symlink_to(f"/usr/bin/{program}")
    for program in ("sed", "sort", "uname"):
        (tmp_path / program).symlink_to(f"/usr/bin/{program}")
    done = run(TOOLS / "blender", "-b", PATH=str(old.parent), XDG_CACHE_HOME=str(tmp_path))
    assert done.returncode == 1
    assert done.stdout == ""
    assert "3.4.1; 4.2 or later is needed" in done.stderr
    assert "not a Debian or Ubuntu system" in done.stderr
    assert "brew install --cask blender" in done.stderr


def test_an_unknown_version_is_an_error():
    done = run(TOOLS / "blender", UMBILICS_BLENDER="2.8")
    assert done.returncode == 1
    assert "it may be 5.2 or 4.3" in done.stderr


def real(*command):
    return subprocess.run(
        [str(part) for part in command], capture_output=True, text=True, check=False
    )


def test_a_real_blender_runs_in_the_folder_of_the_caller(tmp_path):
    script = "import os, sys; open('here', 'w').write(os.getcwd()); sys.exit(9)"
    done = subprocess.run(
        [TOOLS / "blender", "-b", "--factory-startup", "--python-expr", script],
        cwd=tmp_path,
        capture_output=True,
        check=False,
    )
    assert done.returncode == 9
    assert (tmp_path / "here").read_text() == str(tmp_path)


def test_a_window_can_be_photographed(tmp_path):
    picture = tmp_path / "window.png"
    script = tmp_path / "photograph.py"
    script.write_text(
        "import bpy, os, subprocess\n"
        "def photograph():\n"
        "    bpy.ops.wm.redraw_timer(type='DRAW_WIN_SWAP', iterations=1)\n"
        f"    subprocess.run(['import', '-window', 'root', {str(picture)!r}], check=True)\n"
        "    os._exit(0)\n"
        "bpy.app.timers.register(photograph, first_interval=1.0)\n"
    )
    done = real(TOOLS / "window", "--factory-startup", "--python", script)
    assert done.returncode == 0, done.stdout + done.stderr
    header = picture.read_bytes()[:24]
    assert (int.from_bytes(header[16:20]), int.from_bytes(header[20:24])) == (1600, 900)
    # An empty screen packs to next to nothing.
    assert picture.stat().st_size > 50_000
