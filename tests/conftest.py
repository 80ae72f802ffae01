"""Settings for all tests: a separate build cache, no windows, repeatable random examples.

Libraries are compiled at the level -O0, which takes a quarter of the time of -O3; slower runs cost
less than that.  The bits are the same: tests/bits compares builds at -O2 and -O3, for every law.
If tcc is installed it compiles FMUs, and loops of the folders that are not about compiled code.
"""

import gc
import os
import shutil
import sys
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from platform import machine

import pytest
from hypothesis import HealthCheck, settings

TESTS = Path(__file__).parent
COMPILED = tuple(
    f"tests/{folder}/"
    for folder in ("arithmetic", "bits", "board", "codegen", "control/filter",
                   "export/simulink", "packaging")
)  # fmt: skip
"""Folders whose tests are about what a user's own compiler makes."""
QUICK = (
    str(TESTS / "quick")
    if sys.platform == "linux" and machine() == "x86_64" and shutil.which("tcc")
    else ""
)
"""Folder of a `cc` that has tcc compile what is not optimised; "" where there is none."""

os.environ.setdefault("MPLBACKEND", "Agg")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # more wait busily for each other, on all cores
settings.register_profile(
    "project",
    max_examples=30,
    deadline=None,
    derandomize=True,
    print_blob=True,
    suppress_health_check=[HealthCheck.too_slow],  # how busy the machine is, is no one's fault
)
settings.load_profile("project")


def pytest_configure(config):
    """Keep compiled kernels in pytest's own cache folder, so that HOME stays untouched.

    Garbage is collected rarely: tests and graphs consist of many objects that persist.  Bytecode is
    kept, since hundreds of processes import the same modules.  Child processes keep freed memory,
    since a solver requests 16 MB a thousand times.
    """
    gc.set_threshold(50_000, 20, 50)
    sys.dont_write_bytecode = False
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    os.environ.setdefault("WMR_CTRL_OPTIMIZE", "0")
    os.environ.setdefault("MALLOC_TRIM_THRESHOLD_", str(2**29))
    os.environ.setdefault("MALLOC_MMAP_THRESHOLD_", str(2**25))
    compile_quickly()
    cache = getattr(config, "cache", None)
    if cache is not None:
        os.environ.setdefault("WMR_CTRL_CACHE", str(cache.mkdir("wmr_ctrl")))


def compile_quickly():
    """Have FMUs and loops compiled by the fastest compiler; zig first has to build a C library."""
    if compiler := shutil.which("cc"):
        os.environ.setdefault("WMR_CTRL_FMU_CC", "tcc" if QUICK else "cc")
        os.environ.setdefault("WMR_TESTS_CC", compiler)


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item):
    """In the folders about compiled code, use the user's compiler from PATH."""
    if QUICK:
        others = [part for part in os.environ["PATH"].split(os.pathsep) if part != QUICK]
        quick = [] if item.nodeid.startswith(COMPILED) else [QUICK]
        os.environ["PATH"] = os.pathsep.join([*quick, *others])


@pytest.fixture(scope="session", autouse=True)
def one_set_of_instructions():
    """Loops for lanes are compiled for one set of vector instructions, in a third of the time.

    Its value is the function that lists all of them.
    """
    from wmr_ctrl.codegen import build

    every = build.vector_sets
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(build, "vector_sets", lambda: (build.BASELINE,))
        yield every


@pytest.fixture
def every_set_of_instructions(one_set_of_instructions, monkeypatch):
    """For tests of vectors: compile loops for lanes as users have them."""
    from wmr_ctrl.codegen import build

    monkeypatch.setattr(build, "vector_sets", one_set_of_instructions)
    monkeypatch.setattr(build, "_PROGRAMS", {})  # those of other tests have one set


def pytest_collection_modifyitems(items):
    """Mark all cases of a ``slow_but`` test slow, except the cases that the mark names."""
    for item in items:
        case = item.nodeid.partition("[")[2].removesuffix("]")
        for mark in item.iter_markers("slow_but"):
            if case not in mark.args:
                item.add_marker(pytest.mark.slow)


def pytest_collection(session):
    """If several processes collect all tests, let only one of them compile each module.

    Its bytecode, with pytest's changes, is kept, so each process begins with its own modules and
    finds those of the others.  A module that cannot be imported fails where it is collected.
    """
    count, name = (os.environ.get(f"PYTEST_XDIST_{key}", "") for key in ("WORKER_COUNT", "WORKER"))
    if not count or session.config.args != ["tests"]:
        return
    for module in sorted(TESTS.rglob("test_*.py"))[int(name.removeprefix("gw")) :: int(count)]:
        with suppress(Exception, pytest.skip.Exception):
            import_module(".".join(module.relative_to(TESTS.parent).with_suffix("").parts))


def pytest_collection_finish():
    """Exclude imported modules and collected tests from garbage collection."""
    gc.freeze()
