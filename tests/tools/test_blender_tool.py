"""tools/blender and tools/window: what they choose, and that they pass everything on."""

import os
import shutil
import subprocess
import tempfile
import threading
from pathlib import Path

import places
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


@pytest.fixture
def root(tmp_path):
    """Enters a root file system whose only program lists what its last argument names."""
    if os.geteuid() or not shutil.which("unshare"):
        pytest.skip("only root enters one without a range of user numbers")
    if subprocess.run(["unshare", "--mount", "true"], check=False, capture_output=True).returncode:
        pytest.skip("this machine does not let root mount in a space of its own")
    root = tmp_path / "root"
    for folder in ("usr", "proc", "dev", "sys", "var", "run"):
        (root / folder).mkdir(parents=True)
    for name in ("bin", "lib", "lib64"):
        (root / name).symlink_to(f"usr/{name}")

    def enter(*command):
        # The machine's own programs stand in for those of the root.
        script = 'mount --bind /usr "$1/usr" && shift && exec bash "$@"'
        start = ["unshare", "--mount", "--propagation", "private", "bash", "-c", script, "bash"]
        start += [root, TOOLS / "enter_debian_root.sh", root]
        return subprocess.run([*start, *command], capture_output=True, text=True, check=False)

    return enter


@pytest.mark.parametrize("place", ["/var/tmp", "/run", "/tmp", "/var/lib"])
@pytest.mark.parametrize("form", ["{}", "--json={}", "-o={}"])
def test_what_the_arguments_name_is_the_machines_own_wherever_it_lies(root, place, form):
    """A result in /var/tmp ended inside the root, and a mesh there was not found."""
    with tempfile.TemporaryDirectory(dir=place) as folder:
        (Path(folder) / "mesh.obj").write_text("v 0 0 0\n")
        made = Path(folder) / "not yet" / "made.json"
        write = 'mkdir -p "${1%/*}" && echo made > "$1" && cat "$2"'
        done = root("sh", "-c", write, "sh", made, Path(folder) / "mesh.obj", form.format(made))
        assert (done.stdout, done.returncode) == ("v 0 0 0\n", 0), done.stderr
        assert made.read_text() == "made\n"


def test_folders_that_the_root_needs_stay_its_own(root):
    done = root("ls", "/var", "--color=never", "--", "/run", "/usr")
    assert done.returncode == 0, done.stderr
    assert done.stdout.partition("/var:")[2].strip() in ("", "cache")


def test_arguments_that_name_nothing_are_passed_on(root):
    words = ["", "--options=", "x" * 5000, "a\nb", "$HOME *"]
    done = root("sh", "-c", 'printf "%s|" "$@"', "sh", *words)
    assert (done.stdout, done.stderr) == ("|".join([*words, ""]), "")


@pytest.mark.parametrize("version", ["4.2.0", "4.5.15 LTS", "5.2.2 LTS", "10.0.0"])
def test_a_new_enough_blender_on_path_is_taken(fake, version):
    path = f"{fake(version).parent}:{os.environ['PATH']}"
    assert run(TOOLS / "blender", "x", PATH=path).stdout == "[x]\nstandard input\n"


def test_a_program_on_path_that_calls_it_is_not_asked_for_ever(fake, tmp_path, machine):
    """As a wrapper called blender does; each asked the next one for its version."""
    environment = machine(id="echo 0", env="exit 0", mmdebstrap="exit 100")
    wrapper = tmp_path / "blender"
    calls, tool = tmp_path / "calls", TOOLS / "blender"
    wrapper.write_text(f'#!/bin/bash\necho >> {calls}\nexec bash {tool} "$@"\n')
    wrapper.chmod(0o755)
    done = run("/usr/bin/timeout", "20", wrapper, "-b", **environment)
    assert done.returncode == 1
    assert "No Blender could be set up" in done.stderr
    assert len(calls.read_text()) == 2


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


@pytest.fixture
def machine(tmp_path):
    """A PATH of a Debian machine without Blender, with programs that do as they are told."""

    def make(**programs):
        usual = ("bash", "cat", "cksum", "cut", "dirname", "flock", "grep", "head", "mkdir", "rm")
        usual += ("sed", "sort", "tail", "uname", "mktemp", "mv", "du")
        for program in usual:
            (tmp_path / program).symlink_to(f"/usr/bin/{program}")
        told = {"apt-get": "exit 0", "apt-config": "exit 0", "dpkg": "exit 0", "unshare": "exit 0"}
        for name, does in (told | programs).items():
            (tmp_path / name).write_text(f"#!/bin/bash\n{does}\n")
            (tmp_path / name).chmod(0o755)
        return {"PATH": str(tmp_path), "XDG_CACHE_HOME": str(tmp_path / "cache")}

    return make


NOBODY = "case $1 in -u) echo 54321 ;; *) echo nobody-of-the-tests ;; esac"


def test_without_root_and_a_range_of_users_it_says_how_to_get_one(machine):
    done = run(TOOLS / "blender", "-b", **machine(id=NOBODY, mmdebstrap="exit 0"))
    assert done.returncode == 1
    assert "sudo usermod --add-subuids" in done.stderr
    assert "nobody-of-the-tests" in done.stderr
    assert "brew install" in done.stderr


def test_where_namespaces_are_forbidden_it_says_so(machine):
    done = run(TOOLS / "blender", "-b", **machine(id="echo 0", unshare="exit 1"))
    assert done.returncode == 1
    assert "namespaces are not allowed" in done.stderr


def test_without_a_network_it_says_so(machine):
    failing = "echo 'E: Temporary failure resolving deb.debian.org'; exit 100"
    done = run(TOOLS / "blender", "-b", **machine(id="echo 0", mmdebstrap=failing))
    assert done.returncode == 1
    assert "could not be reached" in done.stderr
    assert "install Blender by hand" in done.stderr


def test_packages_of_python_that_cannot_be_fetched_are_explained(capfd):
    said = "ERROR: Could not find a version: Max retries exceeded (NewConnectionError: refused)"
    with pytest.raises(SystemExit):
        places.run_quietly(["sh", "-c", f"echo '{said}'; exit 1"], "install things")
    assert "needs the network" in capfd.readouterr().err
    with pytest.raises(SystemExit):
        places.run_quietly(["sh", "-c", "echo 'no such package'; exit 1"], "install things")
    assert "network" not in capfd.readouterr().err


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


def test_who_waits_for_another_run_says_so(tmp_path, monkeypatch):
    lock, said, held = tmp_path / "blender.lock", threading.Event(), threading.Event()
    monkeypatch.setattr(places, "say", lambda words: said.set())

    def wait():
        with places.locked(lock):
            held.set()

    with places.locked(lock, shared=True):
        with places.locked(lock, shared=True):
            assert not said.is_set()
        other = threading.Thread(target=wait)
        other.start()
        assert said.wait(60.0) and not held.is_set()
    other.join()
    assert held.is_set()
