"""Cached C text equals the emitter's text, and an unusable cache folder is not an error."""

import os
import sys

import casadi as ca
import pytest

from tests.codegen.compiled import made
from tests.commands import finished
from wmr_ctrl.codegen import cache, source
from wmr_ctrl.codegen.dialect import LANES
from wmr_ctrl.codegen.emit import definition


def example():
    x = ca.SX.sym("x", 3)
    return made(ca.sin(x) * x, x=x)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("WMR_CTRL_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


def test_kept_text_is_the_emitters(folder):
    for _ in range(2):
        assert source.cached_definition(example()) == definition(example())
    assert source.cached_definition(example(), LANES) == definition(example(), LANES)
    assert len(list(folder.rglob("*.c"))) == 2


def test_half_a_text_is_written_anew(folder):
    source.cached_definition(example())
    (path,) = folder.rglob("*.c")
    path.write_text(path.read_text("utf-8")[:40], "utf-8")

    assert source.cached_definition(example()) == definition(example())


def test_a_folder_that_cannot_be_written_does_not_matter(tmp_path, monkeypatch):
    blocked = tmp_path / "file"
    blocked.write_text("", "utf-8")
    monkeypatch.setattr(cache, "cache_part", lambda name: blocked / name)

    assert source.cached_definition(example()) == definition(example())


SIMULATED = """
from wmr_ctrl.codegen import cache, source

def refuse(*given, **named):
    raise AssertionError("the work of the first process is done again")

if {again}:
    source.definition = refuse
    cache._build = refuse

from wmr_ctrl import simulate
run = simulate("paper-simulation", "nn")
print([values[-1].tobytes().hex() for values in run.columns.values()])
"""


@pytest.mark.slow
def test_a_second_process_writes_and_compiles_nothing(tmp_path):
    environment = {**os.environ, "WMR_CTRL_CACHE": str(tmp_path)}
    last = [
        finished([sys.executable, "-c", SIMULATED.format(again=again)], env=environment).stdout
        for again in (False, True)
    ]

    assert last[0] == last[1]
