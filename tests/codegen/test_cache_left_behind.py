"""What a killed process leaves in the cache, and a cache that can only be read."""

import os
import subprocess
import sys

import pytest
from filelock import FileLock

from wmr_ctrl.codegen.cache import VARIABLE, build_cached

SOURCES = {"a.c": "int a(void) { return 1; }\n"}
KILLED = """
import os, pathlib, signal
from wmr_ctrl.codegen.cache import build_cached
def compile_in(folder):
    os.kill(os.getpid(), signal.SIGKILL)
build_cached({"b.c": "int b;"}, compile_in)
"""

posix = pytest.mark.skipif(os.name == "nt", reason="Windows tells nothing of dead processes here")


def library_in(folder, source="a.c"):
    from wmr_ctrl.codegen.compiler import compile_library
    from wmr_ctrl.codegen.toolchain import find_toolchain

    return compile_library(find_toolchain(), [folder / source], folder / "a.so")


@pytest.fixture
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv(VARIABLE, str(tmp_path))
    return tmp_path / "kernels"


@posix
def test_the_next_build_removes_what_a_killed_process_left(cache):
    done = subprocess.run([sys.executable, "-c", KILLED], env=dict(os.environ), check=False)
    assert done.returncode == -9
    assert len(list(cache.glob("building-*"))) == 1

    build_cached(SOURCES, library_in)

    assert list(cache.glob("building-*")) == []


def test_a_process_that_lives_keeps_its_folder(cache):
    folder = cache / "building-key-x"
    folder.mkdir(parents=True)
    locks = cache.parent / "locks"
    locks.mkdir()

    with FileLock(locks / "key"):
        build_cached(SOURCES, library_in)
        assert folder.exists()

    build_cached({"b.c": SOURCES["a.c"]}, lambda place: library_in(place, "b.c"))
    assert not folder.exists()


def test_a_cache_that_can_only_be_read_is_used(cache, monkeypatch, tmp_path):
    built = build_cached(SOURCES, library_in)
    monkeypatch.setattr(
        "wmr_ctrl.codegen.cache.cache_part", lambda name: tmp_path / "elsewhere" / name
    )

    assert build_cached(SOURCES, lambda folder: pytest.fail("compiled again")) == built
