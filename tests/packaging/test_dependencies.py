"""The compiler's wheel is required where no compiler works, and by wheels for any machine."""

import importlib.util
import shutil
import sys
import tomllib

import pytest

from tests.architecture.tree import ROOT
from wmr_ctrl.codegen import toolchain

pytest.importorskip("hatchling")


@pytest.fixture
def hook(monkeypatch):
    spec = importlib.util.spec_from_file_location("hatch_build", ROOT / "hatch_build.py")
    module = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, "hatch_build", module)
    monkeypatch.delenv("WMR_CTRL_CC", raising=False)
    spec.loader.exec_module(module)
    return module


def asked(hook):
    """Dependencies of a wheel of this tree beyond the list in pyproject.toml."""
    data = {"dependencies": []}
    hook.CompilerHook(str(ROOT), {}, None, None, "", "wheel").initialize("standard", data)
    return data["dependencies"]


def test_without_a_compiler_the_wheel_comes_with_it(hook, monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))

    assert asked(hook) == [hook.COMPILER]


@pytest.mark.skipif(shutil.which("cc") is None, reason="NOT RUN: no cc on PATH")
def test_with_a_compiler_it_does_not_but_for_what_is_built_for_any_machine(hook, monkeypatch):
    assert asked(hook) == []

    monkeypatch.setattr(hook, "built_here", lambda: False)
    assert asked(hook) == [hook.COMPILER]


def test_a_compiler_that_does_not_work_is_none(hook, monkeypatch, tmp_path):
    for name in ("cc", "gcc", "clang"):
        (tmp_path / name).write_text("#!/bin/sh\nexit 1\n")
        (tmp_path / name).chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path))
    assert hook.compiler() == ""

    monkeypatch.setenv("WMR_CTRL_CC", "no-such-compiler -O3")
    assert hook.compiler() == ""


def test_both_look_for_the_same_compilers_with_the_same_probe(hook):
    assert hook.NAMES == toolchain._ON_PATH
    assert hook.PROBE.read_text("utf-8") == toolchain._PROBE
    assert hook.VARIABLE == toolchain.VARIABLE


def test_the_extra_names_the_same_wheel(hook):
    table = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))

    assert table["project"]["optional-dependencies"]["compiler"] == [hook.COMPILER]
