"""Files that appear whole or not at all."""

import os
import stat
import sys
from concurrent.futures import ThreadPoolExecutor

import pytest

import core


def test_a_block_that_fails_leaves_what_was_there(tmp_path):
    path = tmp_path / "f.txt"
    path.write_text("before")
    with pytest.raises(KeyError), core.whole_file(path) as partial:
        partial.write_text("half")
        raise KeyError
    assert path.read_text() == "before"
    assert list(tmp_path.iterdir()) == [path]
    with pytest.raises(FileNotFoundError), core.whole_file(tmp_path / "none"):
        pass
    assert list(tmp_path.iterdir()) == [path]


def test_nobody_sees_it_before_it_is_whole(tmp_path):
    path = tmp_path / "new" / "f.txt"
    with core.whole_file(path) as partial:
        partial.write_text("all of it")
        assert not path.exists()
        assert partial.suffix == ".txt"
    assert path.read_text() == "all of it"


@pytest.mark.skipif(sys.platform == "win32", reason="links and modes as Unix has them")
def test_a_link_leads_to_the_file_and_the_mode_stays(tmp_path):
    path, link = tmp_path / "f.txt", tmp_path / "link"
    path.write_text("before")
    path.chmod(0o640)
    link.symlink_to(path)
    with core.whole_file(link) as partial:
        partial.write_text("after")
    assert link.is_symlink() and path.read_text() == "after"
    assert stat.S_IMODE(path.stat().st_mode) == 0o640


@pytest.fixture
def protected(tmp_path, monkeypatch):
    """A file that may not be written, as for a user who is not root, in a folder that may."""
    path = tmp_path / "f.txt"
    path.write_text("before")
    path.chmod(0o444)
    access = os.access
    monkeypatch.setattr(os, "access", lambda p, mode: access(p, mode) and path != p)
    return path


@pytest.mark.parametrize("through_link", [False, True])
def test_a_protected_file_is_not_replaced(protected, through_link):
    path = protected.with_name("link") if through_link else protected
    if through_link:
        path.symlink_to(protected)
    with pytest.raises(PermissionError) as caught, core.whole_file(path) as partial:
        partial.write_text("after")
    assert caught.value.filename == str(path)
    assert protected.read_text() == "before"
    assert {one.name for one in protected.parent.iterdir()} == {"f.txt", path.name}


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes with names here")
def test_a_pipe_or_device_stays_one_and_gets_the_whole(tmp_path):
    """Whoever writes it reads it again, to see whether it is whole: a pipe would have him wait for
    ever, a device may have no end. Or another file takes its place, as Blender's own are saved."""
    path, data = tmp_path / "pipe", bytes(1 << 17)
    os.mkfifo(path)
    with ThreadPoolExecutor() as pool:
        read = pool.submit(path.read_bytes)
        with core.whole_file(path) as place:
            place.with_name("saved").write_bytes(data)
            os.replace(place.with_name("saved"), place)
            assert place.read_bytes() == data
        assert read.result() == data
    with core.whole_file(os.devnull) as place:
        place.write_bytes(data)
    assert path.is_fifo() and not os.path.isfile(os.devnull)
    if os.path.exists("/dev/full"):
        full = "/dev/full"
        with pytest.raises(OSError, match="No space") as caught, core.whole_file(full) as place:
            place.write_bytes(data)
        assert caught.value.filename == full


@pytest.mark.skipif(sys.platform == "win32", reason="streams as Unix names them")
def test_what_is_open_already_gets_it_at_its_end(tmp_path):
    """As `--report /dev/stdout >> log`: what stands in the log stays there."""
    path, link = tmp_path / "log.csv", tmp_path / "stdout"
    with open(path, "w") as file:
        file.write("before\n")
        file.flush()
        number = file.fileno()
        link.symlink_to(f"/dev/fd/{number}")
        for name in (f"/dev/fd/{number}", link):
            with core.whole_file(name) as partial:
                partial.write_text("all of it\n")
        with pytest.raises(KeyError), core.whole_file(link) as partial:
            partial.write_text("half")
            raise KeyError
        file.write("after\n")
    assert path.read_text() == "before\nall of it\nall of it\nafter\n"
    assert {one.name for one in tmp_path.iterdir()} == {"log.csv", "stdout"}


def test_an_error_names_the_file_and_not_the_unfinished_one(tmp_path):
    path = tmp_path / "f.txt"
    with pytest.raises(OSError, match="No space") as caught, core.whole_file(path):
        raise OSError(28, "No space left on device")
    assert caught.value.filename == str(path)
    with pytest.raises(FileNotFoundError) as caught, core.whole_file(path):
        pass
    assert caught.value.filename == str(path)


def test_a_folder_in_its_place_is_an_error(tmp_path):
    (tmp_path / "d").mkdir()
    with pytest.raises(IsADirectoryError), core.whole_file(tmp_path / "d") as partial:
        partial.write_text("x")
    assert [path.name for path in tmp_path.iterdir()] == ["d"]


def test_a_name_as_long_as_any_can_be(tmp_path):
    path = tmp_path / ("x" * 251 + ".txt")
    with core.whole_file(path) as partial:
        partial.write_text("x")
    assert path.read_text() == "x"
