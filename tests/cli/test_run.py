"""`wmr-ctrl run`."""

import json
import re
from unittest.mock import Mock

import pytest

from tests.cli.conftest import SHORT
from tests.commands import flat
from tests.tables import cases
from wmr_ctrl import api
from wmr_ctrl.cli import options
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.report import animate, drawing
from wmr_ctrl.results import load_run, summary


def test_json_is_the_summary_of_the_saved_run(wmr, tmp_path):
    """The default scenario and law are the paper's."""
    found = wmr("run", *SHORT, "--json", "--seed", "3", "--out", tmp_path / "a.npz")
    document = json.loads(found.stdout)
    named = (document["scenario"], document["law"], document["seed"], document["engine"])

    assert document == summary(load_run(tmp_path / "a.npz"))
    assert named == ("paper-simulation", "nn", 3, "numpy")


def test_table_tells_outcome_and_limits(short_run):
    found = short_run("paper-simulation --law pid")

    assert found.exit_code == 0
    assert found.stdout.startswith("pid on paper-simulation, seed 0, numpy engine\n")
    assert "The velocity limit was broken" in found.stdout
    assert "limit 1 m/s: BROKEN" in found.stdout
    assert "limit 1.5 rad/s: kept" in found.stdout
    assert max(map(len, found.stdout.splitlines())) <= 80


@pytest.mark.parametrize(
    "start, said",
    [(1.0 + 1e-13, "limit 1 m/s: kept\n"), (2000.0, "limit 1.5 rad/s: kept until")],
)
def test_a_limit_is_broken_where_the_outcome_says_so_and_kept_as_long_as_it_ran(
    short_run, start, said
):
    other = f"--set initial.velocity={start!r},0 --set disturbance.std=0 --set guard.enabled=false"

    assert said in short_run(f"paper-simulation {other}").stdout


@pytest.mark.parametrize(
    "options, told",
    cases("""
    -v --law mb | within dbar 60 N, 15 N m
    -v --set disturbance.push=20,5 --set guard.dbar=0,0 --set robot.mu=0 | BEYOND dbar 0 N, 0 N m
    """),
)
def test_table_puts_the_least_disturbance_beside_its_bound(short_run, options, told):
    found = short_run(f"paper-simulation {options}")

    assert re.search(r"^disturbance, at least.* N, ", found.stdout, re.M)
    assert told in flat(found.stdout)
    assert max(map(len, found.stdout.splitlines())) <= 80


def test_warnings_precede_the_run_on_stderr_in_one_line(short_run):
    found = short_run("paper-experiment-literal --law mb --json")

    assert json.loads(found.stdout)["scenario"] == "paper-experiment-literal"
    told = flat(found.stderr)
    assert told.count("warning: ") == 1
    assert told.startswith("warning: 2 objections of theory (clock.control, ")
    command = "wmr-ctrl check paper-experiment-literal --set clock.duration=0.2 --law mb -v"
    assert command in told
    assert max(map(len, found.stderr.splitlines())) <= 80


def test_suffixes_are_those_of_plots_and_animations():
    assert options.PLOTS == drawing.PICTURES
    assert options.ANIMATIONS == animate.SUFFIXES


def test_several_laws_are_a_study(wmr):
    found = wmr("run far-start --law prox,mb")
    told = flat(found.stderr)

    assert found.exit_code == 2
    assert "'prox,mb' names 2 laws" in told
    assert 'laws = ["prox", "mb"] in PLAN.toml' in told


@pytest.mark.parametrize("option, guard", [("", False), ("--guard", True), ("--no-guard", False)])
@pytest.mark.slow_but("--guard-True")
def test_guard_is_switched_by_an_option(short_run, option, guard):
    document = json.loads(short_run(f"far-start --law mb --json {option}").stdout)

    assert (document["guard"] is not None) is guard


@pytest.mark.slow
def test_a_saved_run_is_shown_drawn_and_converted_without_a_simulation(wmr, short_run, tmp_path):
    first = short_run(f"paper-simulation --out {tmp_path}/run.npz --json")
    files = f"--plot {tmp_path}/run.png --animate {tmp_path}/run.html --out {tmp_path}/run.csv"
    again = wmr(f"show {tmp_path}/run.npz --json {files}")

    assert again.exit_code == 0, again.stderr
    assert again.stdout == first.stdout
    assert all((tmp_path / f"run.{kind}").stat().st_size for kind in ("png", "html", "csv"))


OWN_K = "note: gains.kinematics.k is stated, and law prox does not read it: here it has gains.prox."


@pytest.mark.parametrize("more", ["", "[gains.prox]\nkinematics = [6.0, 196.0, 5.6]\n"])
def test_a_file_with_the_shared_k_is_told_which_law_does_not_read_it(wmr, tmp_path, more):
    """Commands run, tune and study (also for a k of the plan) say so, unless the file states the
    law's own k as well.
    """
    path = tmp_path / "mine.toml"
    path.write_text(
        f'extends = "safe-simulation"\n[gains.kinematics]\nk = [5.0, 99.0, 3.0]\n{more}'
    )
    laws = 'laws = ["mb", "prox"]\nseeds = 1\nset = {clock.duration = 0.1}\n'
    other = 'scenario = "safe-simulation"\ngrid = {gains.kinematics.k = [[5, 99, 3]]}\n'
    for name, plan in (("0", 'scenario = "mine.toml"\n'), ("1", other)):
        (tmp_path / f"{name}.toml").write_text(plan + laws)
    asked = [
        f"run {path} --set clock.duration=0.1 --law prox",
        f"run {path} --set clock.duration=0.1 --law mb",
        f"tune {path} --set clock.duration=0.1 --law prox --out {tmp_path}/a.toml --trials 1 "
        "--set gains.prox.wo=0",
        *(f"study {tmp_path}/{k}.toml --out {tmp_path}/{k}" for k in (0, 1)),
    ]

    said = [OWN_K in flat(wmr(line).stderr) for line in asked]
    assert said == ([False] * 4 + [True] if more else [True, False, True, True, True])


def test_keys_without_effect_are_named_if_the_user_states_them(short_run, tmp_path):
    """Keys of presets and gains of other laws in a file are not named; the shared k is, if the law
    has its own.
    """
    path = tmp_path / "mine.toml"
    path.write_text('extends = "paper-simulation"\n[gyro]\nnoise = 0.1\n')

    gains = "--set gains.prox.rho=15,57.6 --set gains.pid.Kp=210,1.1"
    found = short_run(f"{path} --law pid --set encoder.window=2 {gains}")
    plain = short_run("paper-simulation --law pid")
    k = ("--set", "gains.kinematics.k=8,5,4")
    own, shared = (short_run("safe-simulation", "--law", law, *k) for law in ("prox", "mb"))

    assert "note: without effect here: encoder.window, gyro.noise, gains.prox.rho." in found.stderr
    assert OWN_K in flat(own.stderr)
    assert "without effect" not in plain.stderr + shared.stderr


@pytest.mark.parametrize(
    "command, idle",
    cases("""
    plant | gains.nn.eta, gains.mb.rho, gains.kinematics.k
    closed-loop --law mb | gains.nn.eta
    modelica | nothing
    filter | nothing
    """),
)
def test_outputs_name_the_keys_that_they_do_not_read(wmr, command, idle, monkeypatch):
    monkeypatch.setattr(api, "export_fmu", lambda *_, **__: ())
    stated = "--set gains.nn.eta=1 --set gains.mb.rho=15,57 --set gains.kinematics.k=8,5,4"
    found = wmr(f"export {command} {stated}")
    said = [line for line in found.stderr.splitlines() if "without effect" in line]

    assert said == ([] if idle == "nothing" else [f"note: without effect here: {idle}."])


@pytest.mark.parametrize("what", ["plant", "nn"])
def test_an_output_without_a_law_of_its_own_choice_refuses_one(wmr, what, monkeypatch):
    monkeypatch.setattr(api, "export_fmu", lambda *_, **__: ())
    found = wmr(f"export {what} --law mb")

    assert found.exit_code == 2
    assert f"{what} does not use it. Leave it out." in found.stderr


@pytest.mark.parametrize("law, idle", [("", "mb.rho"), ("--law mb", "nn.eta")])
def test_a_co_simulation_names_gains_of_other_laws_than_its_own(wmr, law, idle, monkeypatch):
    monkeypatch.setattr(api, "cosimulate", Mock(side_effect=ArgumentError("enough")))
    found = wmr(f"cosim {law} --set gains.nn.eta=1 --set gains.mb.rho=15,57")

    assert f"note: without effect here: gains.{idle}." in found.stderr


def test_export_says_why_a_reference_result_is_missing(wmr, tmp_path, monkeypatch):
    def refused(*_, **__):
        raise Exception("not on this platform.")

    monkeypatch.setattr("fmpy.simulate_fmu", refused)
    found = wmr(f"export reference --fmi 2 --out {tmp_path}")

    assert found.exit_code == 0, found.stderr
    said = flat(found.stderr)
    assert "has no reference result: FMPy could not run it here (not on this platform)." in said
