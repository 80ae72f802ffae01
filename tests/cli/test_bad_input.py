"""Bad input: exit code 2, one paragraph that names the culprit and the remedy, nothing written."""

import os
import re

import pytest

from tests.commands import flat

RUN = "run paper-simulation --engine numpy"

CASES = {
    "command": ("rnu", "no command is named 'rnu' (near: run"),
    "law": ("run --law mbb", "no law is named 'mbb' (near: mb"),
    "scenario": ("run papersimulation", "near: paper-simulation"),
    "law as a scenario": ("run prox", "wmr-ctrl run far-start --law prox"),
    "engine": ("run --engine numpi", "no engine is named 'numpi' (near: numpy"),
    "law of a page": ("page --out a.html --law mbb", "no law is named 'mbb' (near: mb"),
    "page's scenario": ("page --out a.html --scenario far", "near: far-start"),
    "page's argument": ("page --out a.html far-start", "is given by --scenario"),
    "page's suffix": ("page --out a.png", "must end in .html"),
    "page's folder": ("page --out none/a.html", "none' does not exist"),
    "option": ("run --sed 1", "--seed"),
    "option's value": ("run --seed one", "'one' is not a whole number from 0 up"),
    "negative seed": ("run --seed -1", "'-1' is not a whole number from 0 up"),
    "huge seed": (f"{RUN} --seed {2**70}", "is not a whole number from 0 up"),
    "key": (f"{RUN} --set robot.mass=1", "robot.mass is not a key in robot"),
    "gain": (f"{RUN} --set gains.mb.rhoo=1", "near: rho"),
    "assignment": (f"{RUN} --set robot.m", "is not KEY=VALUE"),
    "type": (f"{RUN} --set robot.m=heavy", 'robot.m = "heavy" must be a number'),
    "thresholds": (f"{RUN} --set limits.v_u2[1]=1.6", "limits.v_u2[1] = 1.6 must be below"),
    "missing file": ("run missing.toml", "missing.toml"),
    "no seeds": ("reproduce --seeds 0", "0 is not in the range"),
    "one run to compare": ("compare a.npz", "Missing argument 'RUN_B'"),
    "runs to compare": ("compare a.npz b.npz", "cannot read 'a.npz'"),
    "suffix to compare": ("compare a.txt b.txt", ".npz or .csv"),
    "tolerance": ("compare --tolerance x a.npz b.npz", "'x' is not a valid float"),
    "scenario to print": ("scenarios far", "near: far-start"),
    "nothing to print": ("scenarios --toml", "need the NAME of a scenario"),
    "nothing to complete": ("scenarios --complete", "need the NAME of a scenario"),
    "two forms": ("scenarios far-start --toml --json", "either --toml or --json"),
    "law to check": ("check far-start --law nm", "near: nn"),
    "nothing to check": ("check", "Missing argument 'SCENARIO'"),
    "suffix of measurements": ("bench --json a.txt", "must end in .json"),
    "suffix of the run": (f"{RUN} --out a.txt", "--out 'a.txt' must end in .npz or .csv"),
    "suffix of the plot": (f"{RUN} --plot a.npz", "--plot 'a.npz' must end in .png"),
    "suffix of the film": (f"{RUN} --animate a.avi", "--animate 'a.avi' must end in .gif"),
    "picture for a folder": (
        "linearize paper-simulation --plot lin.png",
        "Name the folder, such as 'lin'",
    ),
    "page for a folder": ("reproduce --out report.html", "is the name of a file"),
    "no suffix": (f"{RUN} --out a", "must end in .npz or .csv"),
    "folder of the run": (f"{RUN} --out no/a.npz", "Create the folder first"),
    "folder of the measurements": ("bench --json no/a.json", "Create the folder first"),
}


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
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("name", CASES)
def test_bad_input_is_explained_in_one_paragraph(wmr, name, empty_folder):
    arguments, words = CASES[name]

    assert_one_paragraph(wmr(arguments), words)
    assert list(empty_folder.iterdir()) == []


def random_bytes():
    return bytes(range(256)) * 4


FILES = {
    "random bytes": (random_bytes(), "not UTF-8"),
    "half a table": (b"[robot\nm = 1", "is not valid TOML"),
    "control characters": (b"[robot]\nm = \x1b[31m1", "is not valid TOML"),
    "an unknown section": (b"[robbot]\nm = 1", "near: robot"),
    "a list for a table": (b"robot = [1]", "must be a table"),
    "a missing base": (b'extends = "papr-simulation"', "near: paper-simulation"),
    "a missing list of points": (
        b'[reference]\nkind = "waypoints"\nfile = "points.csv"', "points.csv"
    ),
}  # fmt: skip


@pytest.mark.parametrize("command", ["run", "check", "scenarios"])
@pytest.mark.parametrize("name", FILES)
def test_bad_files_are_explained_in_one_paragraph(wmr, empty_folder, name, command):
    content, words = FILES[name]
    (empty_folder / "bad.toml").write_bytes(content)

    found = wmr(f"{command} ./bad.toml")

    assert_one_paragraph(found, words)
    assert all(c.isprintable() or c == "\n" for c in found.stderr)


def test_foreign_file_is_no_run(wmr, empty_folder):
    (empty_folder / "a.npz").write_bytes(random_bytes())

    assert_one_paragraph(wmr("compare a.npz a.npz"), "is not a run")


def test_outputs_are_checked_before_anything_runs(wmr, monkeypatch):
    def never(*_args, **_options):
        raise AssertionError("ran")

    monkeypatch.setattr("wmr_ctrl.api.simulate", never)

    assert_one_paragraph(wmr(f"{RUN} --out no/a.npz"), "Create the folder first")


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

    line = f"{RUN} --set disturbance.std=0 --law mb --set changes=[]"
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
