"""WheeledRobot.mo: a Modelica compiler accepts it, and its loops are the native ones."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest

from tests.architecture.tree import ROOT
from tests.tables import cases, changes
from wmr_ctrl.api import export_fmu, simulate
from wmr_ctrl.control.laws import LAWS
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.export.modelica import modelica_package
from wmr_ctrl.world.scenario import load_scenario

NOMINAL = "paper-simulation-nominal"
SHOWN = ("x", "y", "theta", "v1", "omega", "tau_right", "tau_left")
EXACT = 1e-7
"""Largest differences from the native loop: m, rad, m/s, rad/s."""
CHANGED = """
changes = [{t = 0.5, m = 65.0, mu = 0.15}, {t = 0.995, m = 55.0, I = 6.0}]
guard.enabled = false
disturbance.std = 0.0
clock.duration = 2.0
"""
WAYPOINTS = """
clock.duration = 1.0
reference.kind = "waypoints"
reference.points = [[0.0, 0.0], [1.0, 0.2], [2.0, 1.0], [2.5, 2.0]]
"""


def loop(law):
    return f"WheeledRobot.Examples.Loop_{law}"


def largest_differences(found, native):
    return [float(np.abs(found[name] - native[name]).max()) for name in SHOWN]


@pytest.mark.parametrize(
    "preset, law, stated",
    [(NOMINAL, "pid", "clock.duration = 10.0"), (NOMINAL, "kanayama", "clock.duration = 10.0"),
     ("far-start", "pid", CHANGED), (NOMINAL, "smc", WAYPOINTS)],
    ids=["pid", "kanayama", "changes", "waypoints"],
)  # fmt: skip
@pytest.mark.slow
def test_a_loop_in_modelica_is_the_native_loop(simulated, preset, law, stated):
    """The native loop takes Runge-Kutta steps of 0.1 ms; the bound of torques allows for gains."""
    own = changes(stated)
    text = modelica_package(load_scenario(preset, own))
    seconds = float(own["clock.duration"])
    found = simulated(text, loop(law), seconds)
    native = simulate(preset, law, overrides=own | {"clock.plant": 1e-4})
    worst = largest_differences(found, native)
    assert len(found["x"]) == native.rows == 100 * seconds
    assert max(worst[:5]) < EXACT * (1 if preset == NOMINAL else 1e3)
    assert max(worst) < 1e3 * EXACT  # gains of some 1e3 N m s/rad


@pytest.mark.slow
def test_the_disturbance_of_the_page_is_the_native_push(text, simulated):
    """A constant thrust, until the robot reverses."""
    page = (ROOT / "docs" / "modelica.md").read_text("utf-8")
    (model,) = re.findall(r"(?s)block Push.*?end Pushed;", page)
    found = simulated(f"{text}{model}", "Pushed", 1.0)
    own = {"clock.duration": 1.0, "clock.plant": 1e-4, "disturbance.push": [20.0, 0.0]}
    native = simulate(NOMINAL, "pid", overrides=own)
    forward = int(np.argmax(native["v1"] < 0)) or native.rows
    assert forward > 20
    assert np.abs(found["x"] - native["x"])[:forward].max() < 1e3 * EXACT


@pytest.mark.parametrize("name", ['a "quoted" one', '</html>"\nb\\'])
@pytest.mark.slow
def test_a_name_cannot_end_a_string(text, name):
    """Only the texts about the scenario differ."""
    named = modelica_package(replace(load_scenario(NOMINAL), name=name))
    ours, theirs = (re.sub(r'"(?:\\.|[^"\\])*"', '""', item) for item in (text, named))
    assert ours == theirs
    assert text.count("\n") == named.count("\n")


def test_what_is_sampled_has_fixed_start_values(text):
    held = re.findall(r"discrete Real \w+\[\d+\]\s*\(([^;]*)\);", text)
    assert len(held) >= 2 * len(LAWS) - 1
    assert all("start =" in item and "each fixed = true" in item for item in held)


def test_functions_that_modelica_lacks(text, simulated):
    """expm1 and log1p keep their digits near 0; hypot does not overflow; copysign signs."""
    model = """
model Probe
  Real a = WheeledRobot.Functions.expm1(1e-9 + time);
  Real b = WheeledRobot.Functions.log1p(1e-9 + time);
  Real c = WheeledRobot.Functions.hypot(3e200, 4e200 + time);
  Real d = WheeledRobot.Functions.copysign(2.0 + time, -1.0 - time);
  Real e = WheeledRobot.Functions.expm1(-50.0 - time);
  Real s(start = 0.0, fixed = true);
equation
  der(s) = 1.0;
end Probe;
"""
    found = simulated(text + model, "Probe", 0.01)
    wanted = (math.expm1(1e-9), math.log1p(1e-9), 5e200, -2.0, math.expm1(-50.0))
    assert [found[name][0] for name in "abcde"] == pytest.approx(wanted, rel=4e-16)


@pytest.mark.slow
def test_a_second_reader_takes_it(text):
    parser = pytest.importorskip("pymoca.parser", reason="NOT RUN: pymoca is not there")
    from pymoca import ast, tree

    syntax = parser.parse(text)
    for law in LAWS:
        flat = tree.flatten(syntax, ast.ComponentRef.from_string(loop(law)))
        assert len(flat.classes) > 0


def test_nothing_that_a_tried_compiler_overlooks(text):
    """Numbers begin with a digit, only functions compare Reals, and protected sections stay
    protected.
    """
    code = re.sub(r'"[^"]*"', '""', text)
    _functions, rest = code.split("  end Functions;")
    assert not re.search(r"(?<![\w\]])\.\d", code)
    assert not re.search(r"==|<>", rest)
    assert not re.search(r"\b(result|memory|t\d+)\b", rest.partition("package Imported")[2])
    assert re.search(r"when sample\(0\.0, clock_control\) then", rest)
    for block in re.findall(r"    block .*?    end \w+;", rest, flags=re.S):
        held = set(re.findall(r"discrete Real (\w+)", block))
        inside = "".join(re.findall(r"when.*?end when;", block, flags=re.S))
        assert held == set(re.findall(r"^\s+(\w+) = ", inside, flags=re.M))
    assert rest.count("annotation(\n    version") == 1
    assert rest.rstrip().endswith("end WheeledRobot;")
    assert re.search(r"\)\);\s+end WheeledRobot;\s*$", rest)  # the annotation stands last


def test_connected_ports_have_one_unit(text):
    """The tried compiler does not check this."""
    units = {}
    for part, body in re.findall(r"partial block (\w+) .*?\n(.*?)    end \1;", text, flags=re.S):
        units[part.lower()] = dict(re.findall(r'(\w+)\(unit = "([^"]+)"\)', body))
    joined = re.findall(r"connect\((reference|controller|plant)\.(\w+), (\w+)\.(\w+)\)", text)
    assert len(joined) == 2 * 14
    for one, name, other, same in joined:
        assert units[one][name] == units[other][same]


def test_a_law_is_computed_as_far_as_it_is_asked_for(text):
    """Roots and logarithms of the side that is not chosen are in branches, not evaluated."""
    body = re.search(r"function mb .*?end mb;", text, flags=re.S)[0]
    before = body.partition("\n      if ")[0]
    for call in ("log", "sqrt"):
        assert call in body
        assert call not in before


@pytest.mark.parametrize(
    "stated",
    cases("""
        actuator.lag = 0.02
        actuator.delay = 0.003
        disturbance.push = [1.0, 0.0]
        sensor.pose_noise = 0.01
    """),
)
def test_what_the_package_cannot_hold_is_refused_by_its_name(stated):
    with pytest.raises(ArgumentError, match="closed-loop FMU"):
        modelica_package(load_scenario(NOMINAL, changes(stated)))


@pytest.mark.slow
def test_noise_is_left_out_and_the_package_says_so(text):
    noisy = modelica_package(load_scenario("paper-simulation"))
    assert "scenario's own is left out" in noisy
    assert "left out" not in text
    assert "parameter Real changes_1_t" in noisy


def test_it_is_one_file_written_whole(tmp_path, text):
    (path,) = export_fmu("modelica", scenario=NOMINAL, out=tmp_path / "new")
    assert path.name == "WheeledRobot.mo"
    assert path.read_text("utf-8") == text
    assert [item.name for item in path.parent.iterdir()] == [path.name]
