"""Bad input: exit code 2, one paragraph that names the culprit and the remedy, nothing written."""

import os
import re

import pytest

from tests.commands import flat
from tests.tables import cases


def assert_one_paragraph(found, words, code=2):
    assert found.exit_code == code, found.stderr
    assert found.stdout == ""
    text = found.stderr.removesuffix("\n")
    assert text.startswith("error: ")
    assert "\n\n" not in text
    assert "Traceback" not in text
    lines = (line for line in text.splitlines() if len(line.split()) > 1 and " '/" not in line)
    assert max(map(len, lines)) <= 80
    said = flat(text)
    assert words in said
    assert re.search(r"[.)]$", said) or re.search(r"\n  \d+ \| .*\n +\^$", text)


@pytest.fixture(autouse=True)
def empty_folder(tmp_path, monkeypatch):
    """The working folder; nothing may run."""
    monkeypatch.setattr("wmr_ctrl.api.simulate", lambda *_, **__: pytest.fail("ran"))
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize(
    "arguments, words",
    cases("""
    rnu | no command is named 'rnu' (near: run
    run --law mbb | no law is named 'mbb' (near: mb
    run papersimulation | near: paper-simulation
    run prox | wmr-ctrl run far-start --law prox
    run --engine numpi | no engine is named 'numpi' (near: numpy
    page --out a.html --law mbb | no law is named 'mbb' (near: mb
    page --out a.html --scenario far | near: far-start
    page --out a.html far-start | is given by --scenario
    page --out a.png | must end in .html
    page --out none/a.html | none' does not exist
    run --sed 1 | --seed
    run --seed one | 'one' is not a whole number from 0 up
    run --seed -1 | '-1' is not a whole number from 0 up
    run --engine numpy --seed 1180591620717411303424 | is not a whole number from 0 up
    run --engine numpy --set robot.mass=1 | robot.mass is not a key in robot
    run --engine numpy --set gains.mb.rhoo=1 | near: rho
    run --engine numpy --set robot.m | is not KEY=VALUE
    run --engine numpy --set robot.m=heavy | robot.m = "heavy" must be a number
    run --engine numpy --set limits.v_u2[1]=1.6 | limits.v_u2[1] = 1.6 must be below
    run missing.toml | missing.toml
    reproduce --seeds 0 | 0 is not in the range
    compare a.npz | Missing argument 'RUN_B'
    compare a.npz b.npz | cannot read 'a.npz'
    compare a.txt b.txt | .npz or .csv
    compare --tolerance x a.npz b.npz | 'x' is not a valid float
    scenarios far | near: far-start
    scenarios --toml | need the NAME of a scenario
    scenarios --complete | need the NAME of a scenario
    scenarios far-start --toml --json | either --toml or --json
    check far-start --law nm | near: nn
    check | Missing argument 'SCENARIO'
    bench --json a.txt | must end in .json
    run --engine numpy --out a.txt | --out 'a.txt' must end in .npz or .csv
    run --engine numpy --plot a.npz | --plot 'a.npz' must end in .png
    run --engine numpy --animate a.avi | --animate 'a.avi' must end in .gif
    linearize paper-simulation --plot lin.png | Name the folder, such as 'lin'
    reproduce --out report.html | is the name of a file
    run --engine numpy --out a | must end in .npz or .csv
    run --engine numpy --out no/a.npz | Create the folder first
    bench --json no/a.json | Create the folder first
    """),
)
def test_bad_input_is_explained_in_one_paragraph(wmr, arguments, words, empty_folder):
    assert_one_paragraph(wmr(arguments), words)
    assert list(empty_folder.iterdir()) == []


@pytest.mark.parametrize("command", ["run", "check", "scenarios"])
@pytest.mark.parametrize(
    "content, words",
    cases("""
    ÿþ | not UTF-8
    [robot;m = 1 | is not valid TOML
    [robot];m = \x1b[31m1 | is not valid TOML
    [robbot];m = 1 | near: robot
    robot = [1] | must be a table
    extends = "papr-simulation" | near: paper-simulation
    [reference];kind = "waypoints";file = "points.csv" | points.csv
    """),
)
def test_bad_files_are_explained_in_one_paragraph(wmr, empty_folder, content, words, command):
    text = content.replace(";", "\n")
    (empty_folder / "bad.toml").write_text(text, "latin-1")

    found = wmr(f"{command} ./bad.toml")

    assert_one_paragraph(found, words)
    assert all(c.isprintable() or c == "\n" for c in found.stderr)


def test_foreign_file_is_no_run(wmr, empty_folder):
    (empty_folder / "a.npz").write_bytes(bytes(range(256)) * 4)

    assert_one_paragraph(wmr("compare a.npz a.npz"), "is not a run")


def test_results_folder_must_be_a_folder(wmr, empty_folder):
    (empty_folder / "taken").write_text("")

    assert_one_paragraph(wmr("reproduce --out taken"), "is a file. Name a folder.")
    assert_one_paragraph(wmr("reproduce --out taken/deep"), "is a file. Name a folder.")


@pytest.mark.skipif(os.name == "nt" or os.geteuid() == 0, reason="needs a user who can be refused")
def test_protected_folder_is_refused(wmr, empty_folder):
    protected = empty_folder / "protected"
    protected.mkdir(mode=0o500)

    assert_one_paragraph(wmr(f"reproduce --out {protected}/a"), "may not be written to")


def test_system_errors_name_the_file(wmr, monkeypatch):
    def full(*_args, **_options):
        raise OSError(28, "No space left on device", "a.npz")

    monkeypatch.setattr("wmr_ctrl.api.simulate", full)

    line = "run --engine numpy --set disturbance.std=0 --law mb --set changes=[]"
    assert_one_paragraph(wmr(line), "a.npz: No space left on device.")


def test_faults_ask_for_a_rerun_with_debug(wmr, monkeypatch):
    def broken(*_args, **_options):
        raise ZeroDivisionError("oh\ndear")

    monkeypatch.setattr("wmr_ctrl.api.law_table", broken)

    assert_one_paragraph(wmr("laws"), "ZeroDivisionError: oh dear. This should not", code=70)


@pytest.mark.parametrize("place", ["before", "after"])
def test_debug_shows_the_traceback_too(wmr, place):
    arguments = ("check", "far-start", "--law", "nm")
    found = wmr(*(("--debug", *arguments) if place == "before" else (*arguments, "--debug")))

    assert found.exit_code == 2
    assert found.stderr.startswith("Traceback")
    assert "\nerror: no law is named 'nm'" in found.stderr
