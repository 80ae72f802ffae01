"""One library from several units: optional units may fail, all others may not."""

import ctypes as ct
from dataclasses import replace

import pytest

from wmr_ctrl.codegen.toolchain import Unit, build_units, find_toolchain
from wmr_ctrl.core.errors import CompilerError

SOURCES = {
    "part.c": """
#ifdef BROKEN
#error this compiler cannot do that
#endif
int NAME(void) { return VALUE; }
""",
    "last.c": """
int first(void);
#ifdef WMR_HAS_second
int second(void);
#else
static int second(void) { return 0; }
#endif
__attribute__((visibility("default"))) int total(void) { return first() + second(); }
""",
}
FIRST = Unit("first", "part.c", ("-DNAME=first", "-DVALUE=40"))
SECOND = Unit("second", "part.c", ("-DNAME=second", "-DVALUE=2"), optional=True)
LAST = Unit("last", "last.c")


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    toolchain = find_toolchain()  # found with the usual cache, so that it need not be tried again
    monkeypatch.setenv("WMR_CTRL_CACHE", str(tmp_path))
    monkeypatch.setattr("tests.codegen.test_toolchain_objects.find_toolchain", lambda: toolchain)
    return tmp_path


def total(*units):
    path = build_units(SOURCES, units, LAST, find_toolchain(), name="sum")
    return int(ct.CDLL(str(path)).total())


def broken(unit):
    return replace(unit, flags=(*unit.flags, "-DBROKEN"))


def unknown(unit):
    return replace(unit, flags=(*unit.flags, "-march=no-such-processor"))


def test_units_have_flags_of_their_own_and_end_in_one_library(cache):
    assert total(FIRST, SECOND) == 42
    assert not list((cache / "kernels").rglob("*.o"))


def test_the_library_goes_without_an_optional_unit_whose_flags_are_unknown():
    assert total(FIRST, unknown(SECOND)) == 40


@pytest.mark.parametrize(
    "units", [(broken(FIRST), SECOND), (unknown(FIRST), SECOND), (FIRST, broken(SECOND))]
)
def test_any_other_failure_leaves_no_library(units, cache):
    with pytest.raises(CompilerError, match=r"cannot do that|no-such-processor"):
        total(*units)
    assert not list(cache.glob("kernels/*"))


def test_an_error_stops_the_compilers_that_still_run(tmp_path):
    """A unit that fails early neither waits for slow compilers nor leaves them running."""
    script, ended = tmp_path / "slow-cc", tmp_path / "ended"
    quick = 'case "$*" in *QUICK*) exit 1;; esac'
    script.write_text(f"#!/bin/sh\n{quick}\nsleep 20\ntouch {ended}\n")
    script.chmod(0o755)
    slow = replace(find_toolchain(), command=(str(script),))

    with pytest.raises(CompilerError):
        build_units(SOURCES, (replace(FIRST, flags=("-DQUICK",)), SECOND), LAST, slow, name="slow")
    assert not ended.exists()
