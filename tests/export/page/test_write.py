"""Impossible pages are refused before anything is compiled."""

import pytest

import wmr_ctrl
from wmr_ctrl.core.errors import ArgumentError, CompilerError, ResultFileError, UnknownNameError
from wmr_ctrl.export.page import module
from wmr_ctrl.export.page.write import LARGEST_SEED


def test_unknown_law_and_scenario(tmp_path):
    out = tmp_path / "robot.html"
    with pytest.raises(UnknownNameError, match="no law is named 'mbb'"):
        wmr_ctrl.write_page(out, laws=["mbb"])
    with pytest.raises(UnknownNameError, match="scenario"):
        wmr_ctrl.write_page(out, "moon")
    with pytest.raises(ArgumentError, match="seed"):
        wmr_ctrl.write_page(out, seed=-1)
    with pytest.raises(ArgumentError, match="2\\^53"):
        wmr_ctrl.write_page(out, seed=LARGEST_SEED)
    assert list(tmp_path.iterdir()) == []


def test_a_place_that_cannot_be_written_to(tmp_path):
    with pytest.raises(ResultFileError, match="does not exist"):
        wmr_ctrl.write_page(tmp_path / "nowhere" / "robot.html")
    with pytest.raises(ResultFileError, match="folder"):
        wmr_ctrl.write_page(tmp_path)


def test_without_zig_it_says_what_to_install_before_anything_is_worked_out(monkeypatch, tmp_path):
    shares = []
    monkeypatch.setattr(module, "zig_command", tuple)
    with pytest.raises(CompilerError, match=r"wmr_ctrl.compiler"):
        wmr_ctrl.write_page(tmp_path / "robot.html", progress=shares.append)
    assert shares == []
    with pytest.raises(CompilerError, match=r"wmr_ctrl.compiler"):
        module.build_module([], module.Room(1, 0), print)
