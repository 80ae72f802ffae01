import ctypes
import os
import sys
import textwrap
import time
from importlib.util import find_spec
from pathlib import Path

import pytest

from tests.compilers import where
from wmr_ctrl.codegen import cache as build_cache
from wmr_ctrl.codegen import compiler, toolchain
from wmr_ctrl.codegen.compiler import Toolchain, compile_library, default_flags, library_suffix
from wmr_ctrl.codegen.toolchain import build_library, find_toolchain
from wmr_ctrl.core.errors import CompilerError

posix = pytest.mark.skipif(os.name != "posix", reason="the stand-ins for compilers are scripts")
needs_zig = pytest.mark.skipif(find_spec("ziglang") is None, reason="the wheel ziglang is missing")

EXPORT = """
#if defined(_WIN32)
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif
"""
SOURCES = {
    "square.c": '#include "inner/export.h"\nEXPORT double square(double x) { return x * x; }\n',
    "inner/export.h": EXPORT,
}


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    """An empty cache and no named compiler, so that every test searches for one itself."""
    monkeypatch.setenv("WMR_CTRL_CACHE", str(tmp_path / "cache"))
    monkeypatch.delenv("WMR_CTRL_CC", raising=False)
    forget()
    yield tmp_path / "cache"
    forget()


ALL = os.environ.get("WMR_CTRL_CACHE")
"""The cache that all tests share: zig compiles its own parts at first (10 s)."""


@pytest.fixture(scope="session")
def zig_cache(tmp_path_factory):
    return Path(ALL) if ALL else tmp_path_factory.mktemp("zig")


@pytest.fixture
def fake(tmp_path):
    """Return a function that writes a stand-in for a compiler, a Python script, and its path."""

    def write(body, name="cc"):
        path = tmp_path / "bin" / name
        path.parent.mkdir(exist_ok=True)
        head = f"#!{sys.executable}\nimport os, signal, sys, time\n"
        version = "if '--version' in sys.argv: print('fake 1.0'); sys.exit(0)\n"
        out = "out = sys.argv[sys.argv.index('-o') + 1]\n"
        path.write_text(head + version + out + textwrap.dedent(body))
        path.chmod(0o755)
        return path

    return write


def forget():
    build_cache._usable.cache_clear()
    toolchain._find.cache_clear()


def of(path):
    return Toolchain((str(path),), path.name, "fake 1.0", default_flags((str(path),)))


def hide_compilers(monkeypatch, *, zig):
    monkeypatch.setenv("PATH", "")
    if zig:
        monkeypatch.setattr(toolchain, "zig_command", lambda: ())


def square(library):
    function = ctypes.CDLL(str(library)).square
    function.restype = ctypes.c_double
    return function(ctypes.c_double(3.0))


# -- a compiler that works ----------------------------------------------------------------------


def test_finds_a_compiler_and_builds_once(cache):
    library = build_library(SOURCES, name="square")

    assert library.name == f"square{library_suffix()}"
    assert library.is_relative_to(cache)
    assert square(library) == 9.0
    assert sys.float_info.min / 2.0 > 0.0  # it leaves small numbers alone
    assert build_library(SOURCES, name="square") == library
    assert len(list(cache.glob("kernels/*/stamp.json"))) == 2  # the trial's and ours
    assert build_library(SOURCES, name="square", flags=("-DA=1",)) != library


def test_this_processor_alone_is_part_of_the_key():
    portable, native = find_toolchain(("-O1",)), find_toolchain(native=True)

    assert portable.flags[-1] == "-O1"
    assert portable.flags != native.flags
    assert compiler._processor() in native.key
    assert compiler._processor() not in portable.key


@posix
def test_named_compiler_may_have_arguments(fake, monkeypatch):
    call = f"os.execv({where('cc')!r}, ['cc', *sys.argv[2:]])"
    path = fake(f"assert sys.argv[1] == 'front'\n{call}", "wrap")
    monkeypatch.setenv("WMR_CTRL_CC", f"'{path}' front")

    found = find_toolchain()

    assert found.command == (str(path), "front")
    assert square(build_library(SOURCES, found)) == 9.0


@needs_zig
@pytest.mark.slow
def test_zig_is_used_where_path_has_no_compiler(zig_cache, tmp_path, monkeypatch):
    """It can also be named explicitly."""
    hide_compilers(monkeypatch, zig=False)
    monkeypatch.setenv("WMR_CTRL_CACHE", str(zig_cache))
    monkeypatch.setenv("HOME", str(tmp_path / "nowhere"))

    found = find_toolchain()

    assert found.name == "zig cc"
    assert found.version.startswith("zig ")
    assert square(build_library(SOURCES, found)) == 9.0
    assert not (tmp_path / "nowhere").exists()
    assert (zig_cache / "zig").is_dir()
    monkeypatch.setenv("WMR_CTRL_CC", "zig cc")
    assert find_toolchain().name == "zig cc"


@pytest.mark.parametrize("found", [None, "/bin/zig"])
def test_zig_that_is_named_is_that_of_path_if_there_is_one(monkeypatch, found):
    monkeypatch.setattr(toolchain, "zig_command", lambda: ("python", "-m", "ziglang"))
    monkeypatch.setattr(toolchain, "_working", lambda command: command)
    monkeypatch.setattr("shutil.which", lambda _: found)

    wheel = "python -m ziglang" if found is None else "zig"
    assert " ".join(toolchain._named("zig cc -O1")) == f"{wheel} cc -O1"


# -- no compiler, or one that does not work -----------------------------------------------------


def test_no_compiler_at_all_says_what_to_install(monkeypatch):
    hide_compilers(monkeypatch, zig=True)

    with pytest.raises(CompilerError) as caught:
        find_toolchain()

    for remedy in ("pip install 'wmr_ctrl[compiler]'", "apt install gcc", "--engine numpy"):
        assert remedy in str(caught.value)


def test_named_compiler_that_is_missing_is_not_replaced_by_another(monkeypatch):
    monkeypatch.setenv("WMR_CTRL_CC", "no-such-compiler -v")

    with pytest.raises(CompilerError, match=r"WMR_CTRL_CC.*no-such-compiler.*pip install 'wmr_ctr"):
        find_toolchain()


@posix
@pytest.mark.parametrize(
    "body, said",
    [
        ("print('x.c:1: error: broken on purpose'); sys.exit(1)", "broken on purpose"),
        ("open(out, 'w').write('no library')", "cannot be loaded"),
        ("pass", "wrote no library"),
        ("os.kill(os.getpid(), signal.SIGKILL)", "was killed by SIGKILL"),
    ],
)
def test_broken_compilers_on_path_are_told(fake, monkeypatch, body, said):
    path = fake(body)
    hide_compilers(monkeypatch, zig=True)
    monkeypatch.setenv("PATH", str(path.parent))

    with pytest.raises(CompilerError, match=said) as caught:
        find_toolchain()

    assert "fake 1.0" in str(caught.value) or said == "cannot be loaded"
    assert "pip install 'wmr_ctrl[compiler]'" in str(caught.value)


@posix
def test_next_compiler_is_tried_after_a_broken_one(fake, monkeypatch):
    works = where("gcc", "cc")
    path = fake("sys.exit(1)")
    other = path.with_name("gcc")
    other.write_text(f"#!/bin/sh\nPATH='{os.environ['PATH']}' exec {works} \"$@\"\n")
    other.chmod(0o755)
    monkeypatch.setenv("PATH", str(path.parent))

    assert find_toolchain().name == "gcc"


# -- a compiler that fails on our sources -------------------------------------------------------


@posix
@pytest.mark.parametrize(
    "body, said",
    [
        (
            "open(out, 'w').write('half'); print('a.c:3: error: no'); sys.exit(1)",
            "a.c:3: error: no",
        ),
        ("open(out, 'w').write('half'); os.kill(os.getpid(), signal.SIGSEGV)", "SIGSEGV"),
        ("open(out, 'w').write('half'); time.sleep(60)", "did not finish within 1 s"),
        ("print('fine')", "wrote no library"),
    ],
)
def test_failing_compiler_leaves_no_library(fake, cache, body, said):
    broken = of(fake(body))
    start = time.monotonic()

    with pytest.raises(CompilerError, match=said) as caught:
        build_library(SOURCES, broken, timeout=1.0)

    assert time.monotonic() - start < 20.0
    assert "--engine numpy" in str(caught.value)
    assert list((cache / "kernels").iterdir()) == []


@posix
def test_what_a_hanging_compiler_started_is_killed_too(fake, tmp_path):
    child = tmp_path / "child"
    path = fake(f"""
        pid = os.fork()
        if pid:
            open({str(child)!r}, "w").write(str(pid))
        time.sleep(60)
    """)

    with pytest.raises(CompilerError, match="did not finish"):
        compile_library(of(path), [], tmp_path / "lib.so", timeout=1.0)

    assert ended(int(child.read_text()))


def ended(pid):
    """True if a process is gone, or is a zombie."""
    for _ in range(100):
        try:
            os.kill(pid, 0)
            state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
        except OSError:
            return True
        if state == "Z":
            return True
        time.sleep(0.02)
    return False


def test_wrong_source_names_line_command_and_remedy(tmp_path):
    with pytest.raises(CompilerError) as caught:
        build_library({"wrong.c": "int f(void) { return undeclared_thing; }"})

    for part in ("undeclared_thing", "wrong.c", "-ffp-contract=off", "WMR_CTRL_CC"):
        assert part in str(caught.value)
    with pytest.raises(CompilerError, match="missing"):
        compile_library(of(tmp_path / "missing"), [], tmp_path / "lib.so")


@pytest.mark.parametrize("asked, level", [("", "-O3"), ("1", "-O1"), (" 0 ", "-O0")])
def test_the_level_is_what_the_environment_asks_for(asked, level, monkeypatch):
    monkeypatch.setenv("WMR_CTRL_OPTIMIZE", asked)
    flags = [flag for flag in find_toolchain(native=True).flags if flag.startswith("-O")]

    assert flags[-1] == level


@pytest.mark.parametrize("asked", ["4", "fast", "-O2", "1.0"])
def test_a_level_that_no_compiler_has_is_named(asked, monkeypatch):
    monkeypatch.setenv("WMR_CTRL_OPTIMIZE", asked)
    with pytest.raises(CompilerError, match=r"WMR_CTRL_OPTIMIZE.*takes 0, 1, 2 or 3"):
        find_toolchain()
