"""Atomic writing: the whole new file or the old one, and no other files."""

import errno
import os
import stat
from pathlib import Path

import pytest

from tests.results.conftest import build
from wmr_ctrl.core.errors import ResultFileError
from wmr_ctrl.results import atomic_path, atomic_text, check_writable, write_all
from wmr_ctrl.results.files import atomic_write
from wmr_ctrl.results.formats import save_run


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def write_half(path, fault):
    with atomic_write(path) as file:
        file.write(b"half")
        raise fault


def test_only_the_written_file_is_left(tmp_path):
    with atomic_write(tmp_path / "a.bin") as file:
        file.write(b"new")
    with atomic_text(str(tmp_path / "a.txt")) as file:
        file.write("Größe\n")

    assert contents(tmp_path) == {"a.bin": b"new", "a.txt": "Größe\n".encode()}


@pytest.mark.parametrize("fault", [ValueError("mine"), KeyboardInterrupt()])
def test_an_error_while_writing_keeps_the_old_file(tmp_path, fault):
    path = tmp_path / "a.bin"
    path.write_bytes(b"old")
    with pytest.raises(type(fault)):
        write_half(path, fault)

    assert contents(tmp_path) == {"a.bin": b"old"}


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EACCES, errno.EROFS, errno.EIO])
def test_a_system_fault_becomes_one_paragraph_with_a_remedy(tmp_path, number):
    path = tmp_path / "a.bin"
    with pytest.raises(ResultFileError, match="Choose another path") as caught:
        write_half(path, OSError(number, os.strerror(number)))

    message = str(caught.value)
    assert os.strerror(number) in message
    assert "a.bin" in message
    assert "\n" not in message
    assert contents(tmp_path) == {}


def test_a_failing_last_step_leaves_nothing(tmp_path, monkeypatch):
    def denied(*_):
        raise PermissionError(errno.EACCES, "denied")

    monkeypatch.setattr(os, "replace", denied)
    with pytest.raises(ResultFileError, match="Choose another path"):
        save_run(build(), tmp_path / "run.npz")
    with pytest.raises(ResultFileError, match="Choose another path"):
        write_all({"a.c": "int a;"}, tmp_path / "new" / "package")

    assert contents(tmp_path) == {}
    assert not (tmp_path / "new").exists()


def test_a_writer_that_wants_a_path_gets_one_of_the_same_suffix(tmp_path):
    with atomic_path(tmp_path / "film.gif") as scratch:
        assert (scratch.parent, scratch.suffix) == (tmp_path, ".gif")
        scratch.write_bytes(b"gif")
    with pytest.raises(ResultFileError, match="No such file"), atomic_path(tmp_path / "b.gif"):
        pass

    assert contents(tmp_path) == {"film.gif": b"gif"}


@pytest.mark.parametrize("name", ["", "none/a.bin", "file/a.bin", "a\0b", "n" * 300 + ".bin"])
def test_places_that_cannot_be_written_are_refused_beforehand(tmp_path, name):
    (tmp_path / "file").write_bytes(b"")
    path = f"{tmp_path}/{name}"
    with pytest.raises(ResultFileError, match="cannot write") as caught, atomic_write(path):
        pytest.fail("the file was opened")
    with pytest.raises(ResultFileError):
        check_writable(path)

    with pytest.raises(ResultFileError, match="it is a folder"):
        check_writable(tmp_path)

    assert "\n" not in str(caught.value)
    assert contents(tmp_path) == {"file": b""}


@pytest.mark.skipif(not os.path.exists("/dev/null"), reason="no device to try it on")
def test_a_device_is_never_replaced_by_a_file():
    with pytest.raises(ResultFileError, match="not a regular file"), atomic_write("/dev/null"):
        pytest.fail("the device was opened")

    assert stat.S_ISCHR(os.stat("/dev/null").st_mode)


@pytest.mark.parametrize("kind", ["folder", "file"])
def test_a_write_protected_place_is_refused(tmp_path, monkeypatch, kind):
    path = tmp_path / "a.bin"
    path.write_bytes(b"old")
    protected = path if kind == "file" else tmp_path
    # The superuser may write everywhere, so the system's answer is played.
    monkeypatch.setattr(os, "access", lambda place, _: Path(place) != protected)
    with pytest.raises(ResultFileError, match=r"allow|may not be written"), atomic_write(path):
        pytest.fail("the file was opened")

    assert contents(tmp_path) == {"a.bin": b"old"}


def test_a_link_is_written_through(tmp_path):
    folder = tmp_path / "real"
    folder.mkdir()
    link = tmp_path / "link.bin"
    link.symlink_to(folder / "a.bin")
    with atomic_write(link) as file:
        file.write(b"new")

    assert link.is_symlink()
    assert contents(folder) == {"a.bin": b"new"}


def test_the_file_has_the_permissions_of_any_new_file(tmp_path):
    (tmp_path / "plain").write_bytes(b"")
    with atomic_write(tmp_path / "atomic") as file:
        file.write(b"")

    modes = {path.stat().st_mode for path in tmp_path.iterdir()}
    assert len(modes) == 1
