"""Progress: lines now and then where there is no terminal, a bar where there is one."""

import sys
import threading

import pytest

from wmr_ctrl import api
from wmr_ctrl.cli import console as module
from wmr_ctrl.cli.console import Progress


@pytest.fixture
def clock(monkeypatch):
    """A clock that goes on by hand."""
    now = [0.0]
    monkeypatch.setattr(module.time, "monotonic", lambda: now[0])
    monkeypatch.setattr(module.Silence, "since", 0.0)
    return now


def test_long_jobs_say_now_and_then_how_long_they_still_take(capsys, clock):
    with Progress("run") as progress:
        for i in range(1, 41):
            clock[0] = float(i)
            progress(i / 40)

    out, err = capsys.readouterr()
    assert out == ""
    assert len(err.splitlines()) == 13  # every three seconds
    assert err.splitlines()[:3] == ["run: 8 %", "run: 15 %", "run: 22 %, about 31 s left"]


def test_terminal_gets_a_bar_that_goes_away(capsys, monkeypatch):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    monkeypatch.setenv("TERM", "xterm")

    def half(progress):
        progress(0.5)
        raise ValueError("inside")

    with pytest.raises(ValueError, match="inside"), Progress("run") as progress:
        half(progress)

    out, err = capsys.readouterr()
    assert out == ""
    assert "run" in err


def test_export_is_not_silent_while_it_compiles(wmr, monkeypatch, tmp_path):
    said = threading.Event()
    monkeypatch.setattr(module, "FIRST", 0.0)
    monkeypatch.setattr(module, "TICK", 0.001)
    monkeypatch.setattr(module.click, "echo", lambda text, err: (lines.append(text), said.set()))
    monkeypatch.setattr(api, "export_fmu", lambda what, **_given: [said.wait(60) and what])
    lines = []
    result = wmr(f"export nn --out {tmp_path}")

    assert result.exit_code == 0
    assert lines[0].startswith("export nn: ")


def test_what_passes_before_the_job_counts_as_silence(capsys, clock):
    clock[0] = 2.0  # imports
    with Progress("run") as progress:
        progress(0.1)
        clock[0] = 2.8
        progress(0.5)

    assert capsys.readouterr().err == "run: 50 %, about 1 s left\n"
