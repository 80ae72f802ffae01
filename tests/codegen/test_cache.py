import errno
import os
import subprocess
import sys
import textwrap
import time
import types
from pathlib import Path

import pytest
from filelock import FileLock

from wmr_ctrl.codegen import cache
from wmr_ctrl.codegen.cache import build_cached, cache_dir, content_key
from wmr_ctrl.codegen.toolchain import find_toolchain
from wmr_ctrl.core.errors import CacheError, CompilerError

rights = pytest.mark.skipif(os.name == "nt", reason="rights and signals of POSIX")
SOURCES = {"a.c": "int a;", "inner/b.h": b"int b;"}


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("WMR_CTRL_CACHE", str(tmp_path / "cache"))
    cache._usable.cache_clear()
    cache._checked.clear()
    yield tmp_path / "cache"
    cache._usable.cache_clear()


class Compiler:
    """Writes a library from the sources and counts how often it was asked to."""

    def __init__(self):
        self.calls = 0

    def __call__(self, folder):
        self.calls += 1
        out = folder / "lib.so"
        out.write_bytes((folder / "a.c").read_bytes() + (folder / "inner/b.h").read_bytes())
        return out


def no_locks(*_, **__):
    raise OSError(errno.ENOLCK, "No locks available")


def leftovers(folder):
    return [path.name for path in (folder / "kernels").glob("building-*")]


def test_builds_once_and_keeps_the_sources_beside_the_library(folder):
    compiler = Compiler()

    first = build_cached(SOURCES, compiler)
    second = build_cached(SOURCES, compiler)

    assert first == second
    assert first.read_bytes() == b"int a;int b;"
    assert (first.parent / "inner/b.h").read_bytes() == b"int b;"
    assert compiler.calls == 1
    assert leftovers(folder) == []


def test_key_depends_on_names_texts_and_compiler_each_apart():
    given = (
        (SOURCES, ()), (SOURCES, ("gcc 12",)), ({**SOURCES, "a.c": "int A;"}, ()),
        ({"a.c": "int a;", "inner/c.h": b"int b;"}, ()),
        ({"a.c": "int a;int b;", "inner/b.h": b""}, ()),
        ({}, ("ab", "c")), ({}, ("a", "bc")), ({}, ("a", "b")), ({"a": "b"}, ()),
    )  # fmt: skip
    assert len({content_key(*each) for each in given}) == len(given)


def test_compiler_that_fails_leaves_nothing(folder):
    def fails(build):
        (build / "lib.so").write_bytes(b"half")
        raise CompilerError("it broke")

    with pytest.raises(CompilerError, match="it broke"):
        build_cached(SOURCES, fails)

    assert list((folder / "kernels").iterdir()) == []
    assert build_cached(SOURCES, Compiler()).exists()


STAMPS = [("stamp.json", stamp) for stamp in (b"", b"\xff\x00", b"[]", b"{}", b'{"library": 3}')]


@pytest.mark.parametrize(
    "part, damage", [("lib.so", None), ("lib.so", b"int a;int B;"), ("lib.so", b""), *STAMPS]
)
def test_an_entry_with_a_damaged_or_missing_part_is_built_anew(folder, part, damage):
    compiler = Compiler()
    library = build_cached(SOURCES, compiler)
    if damage is None:
        library.unlink()
    else:
        (library.parent / part).write_bytes(damage)
        cache._checked.clear()  # as in a new process

    assert build_cached(SOURCES, compiler) == library
    assert library.read_bytes() == b"int a;int b;"
    assert compiler.calls == 2
    assert leftovers(folder) == []


@pytest.mark.parametrize("locks, builders", [(True, 1), (False, 2)])
def test_processes_that_want_one_entry_at_once_all_get_it(folder, tmp_path, locks, builders):
    """The first builds and the others wait; without locks they all build, and one copy stays."""
    script = textwrap.dedent(f"""
        import sys, time
        from pathlib import Path
        from wmr_ctrl.codegen import cache
        from wmr_ctrl.codegen.cache import build_cached
        if not {locks}:
            def no_locks(*_, **__):
                raise OSError("no locks here")
            cache.FileLock = no_locks

        me, meeting, wanted = sys.argv[1], Path(sys.argv[2]), {builders}

        def compile_in(folder):
            (meeting / me).touch()
            until = time.monotonic() + 20
            while len(list(meeting.iterdir())) < wanted and time.monotonic() < until:
                time.sleep(0.01)
            time.sleep(0.2)
            (folder / "lib.so").write_text("made by " + me)
            return folder / "lib.so"

        library = build_cached({{"a.c": "int a;"}}, compile_in)
        print(library, library.read_text(), sep="|")
    """)
    meeting = tmp_path / "meeting"
    meeting.mkdir()
    started = [
        subprocess.Popen(
            [sys.executable, "-c", script, name, str(meeting)], stdout=subprocess.PIPE, text=True
        )
        for name in ("one", "two")
    ]
    said = [process.communicate(timeout=60)[0].strip() for process in started]

    assert [process.returncode for process in started] == [0, 0]
    assert len(list(meeting.iterdir())) == builders
    assert said[0] == said[1]
    assert leftovers(folder) == []
    assert len(list(folder.glob("kernels/*/stamp.json"))) == 1


def test_a_folder_that_another_process_makes_meanwhile_is_used(folder, monkeypatch):
    make = Path.mkdir

    def after_the_other(path, *given, **named):
        os.makedirs(path, exist_ok=True)
        make(path, *given, **named)

    monkeypatch.setattr(Path, "mkdir", after_the_other)

    assert cache_dir() == folder


KILLED = """
import os, signal
from wmr_ctrl.codegen.cache import build_cached
build_cached({"b.c": "int b;"}, lambda folder: os.kill(os.getpid(), signal.SIGKILL))
"""


@rights
def test_the_next_build_removes_what_a_killed_process_left(folder):
    died = subprocess.run([sys.executable, "-c", KILLED], check=False, timeout=60)
    assert died.returncode == -9
    assert len(leftovers(folder)) == 1

    build_cached(SOURCES, Compiler())
    assert leftovers(folder) == []


def test_a_process_that_lives_keeps_its_folder(folder):
    place, locks = folder / "kernels/building-key-x", folder / "locks"
    place.mkdir(parents=True)
    locks.mkdir()
    with FileLock(locks / "key"):
        build_cached(SOURCES, Compiler())
        assert place.exists()

    build_cached({**SOURCES, "a.c": "int c;"}, Compiler())
    assert not place.exists()


def test_a_cache_that_can_only_be_read_is_used(monkeypatch, tmp_path):
    built = build_cached(SOURCES, Compiler())
    monkeypatch.setattr(cache, "cache_part", lambda name: tmp_path / "elsewhere" / name)

    assert build_cached(SOURCES, lambda _: pytest.fail("compiled again")) == built


def test_full_disk_is_one_clear_error(folder, monkeypatch):
    def full(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", full)

    with pytest.raises(CompilerError, match=r"No space left on device.*WMR_CTRL_CACHE"):
        build_cached(SOURCES, Compiler())

    assert leftovers(folder) == []


def test_without_locks_leftovers_go_after_a_day(folder, monkeypatch):
    monkeypatch.setattr(cache, "FileLock", no_locks)
    old, fresh = folder / "kernels/building-old", folder / "kernels/building-fresh"
    old.mkdir(parents=True)
    fresh.mkdir()
    os.utime(old, (time.time() - 2 * 86400,) * 2)

    build_cached(SOURCES, Compiler())

    assert leftovers(folder) == ["building-fresh"]


def test_unwritable_folder_is_replaced_with_a_warning(tmp_path, monkeypatch, caplog):
    (tmp_path / "file").write_text("in place of a folder")
    monkeypatch.setenv("WMR_CTRL_CACHE", str(tmp_path / "file"))
    monkeypatch.setattr(cache.tempfile, "tempdir", str(tmp_path))

    chosen = cache_dir()

    assert chosen.parent == tmp_path
    assert build_cached(SOURCES, Compiler()).is_relative_to(chosen)
    assert cache_dir() == chosen
    (warned,) = caplog.messages  # one per process
    assert "WMR_CTRL_CACHE" in warned
    assert str(chosen) in warned


def test_read_only_folder_is_replaced(tmp_path, monkeypatch, folder):
    real = cache.tempfile.mkdtemp

    def mkdtemp(*args, **keywords):
        if keywords.get("dir") == folder:
            raise OSError(errno.EROFS, "Read-only file system")
        return real(*args, **keywords)

    monkeypatch.setattr(cache.tempfile, "mkdtemp", mkdtemp)
    monkeypatch.setattr(cache.tempfile, "tempdir", str(tmp_path))

    assert cache_dir() != folder


@rights
@pytest.mark.parametrize("part", ["", "kernels", ".."])
@pytest.mark.parametrize("built_before", [True, False])
def test_a_cache_that_everybody_may_write_is_refused(folder, part, built_before):
    """Or a folder around it.  Folders such as /tmp, in which only owners can rename files, are
    accepted.
    """
    if built_before:
        build_cached(SOURCES, Compiler())
        cache._usable.cache_clear()
    place, compiler = folder / part, Compiler()
    place.mkdir(parents=True, exist_ok=True)
    place.chmod(0o777 if part == ".." else 0o1777)

    with pytest.raises(CacheError, match=r"writable for everybody.*chmod o-w"):
        build_cached(SOURCES, compiler)
    assert compiler.calls == 0
    place.chmod(0o1777 if part == ".." else 0o755)
    build_cached(SOURCES, compiler)


@rights
def test_nothing_that_is_loaded_may_be_written_by_everybody_whatever_the_mask(folder):
    before = os.umask(0)
    try:
        build_cached(SOURCES, Compiler()).chmod(0o777)
        library = build_cached(SOURCES, compiler := Compiler())
    finally:
        os.umask(before)
    found = [library, *library.parents]

    assert compiler.calls == 1
    assert not any(path.stat().st_mode & 0o002 for path in found[: found.index(folder) + 1])


def test_what_is_built_on_a_full_disk_is_not_kept(folder, monkeypatch):
    """A compiler without disk space may report success; loading its file would end Python."""
    free = types.SimpleNamespace(free=cache.SPARE - 1)
    monkeypatch.setattr(cache.shutil, "disk_usage", lambda place: free)

    with pytest.raises(CacheError, match="No space left"):
        build_cached(SOURCES, Compiler())
    assert leftovers(folder) == []
    free.free += 1
    assert build_cached(SOURCES, Compiler()).is_file()


@pytest.mark.parametrize("said", ["No space left on device", "error: NoSpaceLeft"])
def test_a_full_disk_is_never_blamed_on_the_compiler(folder, tmp_path, monkeypatch, said):
    script = tmp_path / "cc"
    script.write_text(f"#!/bin/sh\necho 'cc: {said}' >&2\nexit 1\n")
    script.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("WMR_CTRL_CC", raising=False)

    with pytest.raises(CacheError, match=r"(?s)^(?!.*Install).*space.*WMR_CTRL_CACHE"):
        find_toolchain()


def test_a_folder_that_this_user_may_not_look_into_is_none(folder, monkeypatch):
    """Under sudo, HOME may be a folder that raises PermissionError: a substitute is used
    instead.
    """
    plain = Path.stat

    def stat(path, **options):
        if path == folder or folder in path.parents:
            raise PermissionError(errno.EACCES, "Permission denied", str(path))
        return plain(path, **options)

    monkeypatch.setattr(Path, "stat", stat)

    assert not cache.is_shared(folder)
    cache.refuse_shared(folder / "kernels")
