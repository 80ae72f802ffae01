"""Somebody else's plant by FMI 3.0, written in C: what it says of its steps, units of its mass."""

from __future__ import annotations

import json
import re
import subprocess
import zipfile
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from fmpy import platform_tuple

from tests.fmi.test_portable import HEADERS, tool
from wmr_ctrl.api import simulate
from wmr_ctrl.cli import root
from wmr_ctrl.core.errors import ArgumentError, UnknownNameError
from wmr_ctrl.export.cosim import cosimulate
from wmr_ctrl.world.scenario import load_scenario, override

SHORT = override(load_scenario("paper-simulation-nominal"), {"clock.duration": 1.0})
LIGHTER = override(SHORT, {"changes": [{"t": 0.4, "m": 45.0}]})
SOURCE = Path(__file__).with_name("foreign3.c")
NAMES = ("right", "left", "x", "y", "yaw", "v", "w", "grams", "fixed", "mode")
KINDS = ("input",) * 2 + ("output",) * 5 + ("parameter",) * 3
MAP = """
[plant]
units = "SI"
inputs = {{ right = "torque_right", left = "torque_left" }}
outputs = {{ x = "x", y = "y", psi = "yaw", v1 = "v", omega = "w" }}
start = {{ mode = {mode}.0 }}
[plant.parameters]
"robot.m" = {mass}
"""


@pytest.fixture(scope="module")
def plant(tmp_path_factory):
    """The FMU; functions of the standard that it does not write itself fail."""
    folder = tmp_path_factory.mktemp("foreign3")
    own = SOURCE.read_text(encoding="utf-8")
    types = (HEADERS / "fmi3FunctionTypes.h").read_text(encoding="utf-8")
    every = re.findall(r"typedef\s+(\w+)\s+(fmi3\w+)TYPE\s*\((.*?)\)\s*;", types, re.S)
    rest = [f"{of} {name}({given}) {{ return 0; }}" for of, name, given in every if name not in own]
    (folder / "rest.c").write_text("\n".join(['#include "fmi3Functions.h"', *rest]))
    library = folder / "foreign3.so"
    flags = ["-shared", "-fPIC", "-w", f"-I{HEADERS}", "-o", str(library)]
    subprocess.run([tool("cc"), *flags, str(SOURCE), str(folder / "rest.c"), "-lm"], check=True)
    rows = []
    for i, (name, kind) in enumerate(zip(NAMES, KINDS, strict=True)):
        more = 'initial="calculated"' if kind == "output" else 'start="0"'
        if kind == "parameter":
            more += f' variability="{"tunable" if name == "grams" else "fixed"}"'
        unit = ' unit="g"' if name == "grams" else ""
        more += f' valueReference="{i}" causality="{kind}"{unit}'
        rows.append(f'<Float64 name="{name}" {more}/>')
    order = [f'<{what} valueReference="{i}"/>' for what in ("Output", "InitialUnknown")
             for i, kind in enumerate(KINDS) if kind == "output"]  # fmt: skip
    text = f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="TheirThree" instantiationToken="three">
<CoSimulation modelIdentifier="foreign3" canHandleVariableCommunicationStepSize="true"/>
<UnitDefinitions><Unit name="g"><BaseUnit kg="1" factor="0.001"/></Unit></UnitDefinitions>
<ModelVariables><Float64 name="time" valueReference="99" causality="independent"/>
{"".join(rows)}</ModelVariables>
<ModelStructure>{"".join(order)}</ModelStructure></fmiModelDescription>"""
    with zipfile.ZipFile(folder / "three.fmu", "w") as archive:
        archive.writestr("modelDescription.xml", text)
        archive.write(library, f"binaries/{platform_tuple}/foreign3.so")
    return folder / "three.fmu"


def test_a_change_is_set_in_the_plants_own_unit(plant, mapped):
    """A mass in g was set to 45 of them, in silence."""
    text = MAP.format(mode=0, mass='"grams"')
    run = cosimulate(LIGHTER, "pid", plant=plant, map_file=mapped(text), fmi=3)
    ours, heavy = (simulate(case, "pid") for case in (LIGHTER, SHORT))
    assert run.outcome == ours.outcome
    assert np.abs(run["v1"] - ours["v1"]).max() < 2e-4 < np.abs(ours["v1"] - heavy["v1"]).max()
    assert "warned_plant" not in run.provenance


@pytest.mark.parametrize(
    ("mass", "error", "words"),
    [
        ('"fixed"', ArgumentError, "fixed of .* cannot be set during a run .*fixed parameter"),
        ('"v"', ArgumentError, r"v of .* \(it is a continuous output\)"),
        ('"gram"', UnknownNameError, "is named 'gram' .near: grams"),
        ("{ terms = { grams = 1.0, fixed = 1.0 } }", ArgumentError, "of one parameter"),
        ("{ terms = { grams = 0.0 } }", ArgumentError, "coefficient other than 0"),
        ('{ terms = { grams = 1.0 }, unit = "m" }', ArgumentError, "grams in m does not give kg"),
        ('"grams"\n"robot.M" = "grams"', UnknownNameError, "is named 'robot.M' .near: robot.m"),
        ('"grams"\n[controller.parameters]\n"gains" = "k"', ArgumentError, "has no effect"),
    ],
)
def test_a_change_that_cannot_be_made_is_refused_before_the_run(plant, mapped, mass, error, words):
    given = {"plant": plant, "map_file": mapped(MAP.format(mode=0, mass=mass))}
    if "controller" in mass:
        given["controller"] = plant
    with pytest.raises(error, match=words):
        cosimulate(LIGHTER, None if "controller" in mass else "pid", **given)


def test_a_step_that_did_not_reach_its_end_is_no_step(plant, mapped):
    """Its status was OK and no flag was set; only the time that it told said so."""
    text = MAP.format(mode=1, mass='"grams"')
    run = cosimulate(SHORT, "pid", plant=plant, map_file=mapped(text))
    assert run.outcome == "failed"
    assert "failed at t = 0.5 s in doStep to 0.51 s, of which it reached 0.505" in run.explanation


def test_a_plants_warnings_are_told(plant, mapped):
    text = MAP.format(mode=2, mass='"grams"')
    command = ["cosim", "paper-simulation-nominal", "--law", "pid", "--plant", str(plant)]
    command += ["--map", str(mapped(text)), "--set", "clock.duration=1"]
    said = "50 steps, first at t = 0.5 s: beyond the range of the tyres"
    done = CliRunner().invoke(root, command)
    assert f"plant warned in {said}" in " ".join(done.stdout.split())
    told = json.loads(CliRunner().invoke(root, [*command, "--json"]).stdout)
    assert told["provenance"]["warned_plant"] == said


def test_a_plant_that_takes_steps_of_one_size_is_not_stepped_by_others(plant, mapped, tmp_path):
    """A change within a control period would cut one."""
    rigid = tmp_path / "rigid.fmu"
    with zipfile.ZipFile(plant) as old, zipfile.ZipFile(rigid, "w") as new:
        for name in old.namelist():
            content = old.read(name)
            if name == "modelDescription.xml":
                content = content.replace(b'StepSize="true"', b'StepSize="false"')
            new.writestr(name, content)
    text = mapped(MAP.format(mode=0, mass='"grams"'))
    within = override(SHORT, {"changes": [{"t": 0.404, "m": 45.0}], "clock.duration": 0.5})
    with pytest.raises(ArgumentError, match=r"rigid\.fmu, which takes steps of one size, 0\.01 s"):
        cosimulate(within, "pid", plant=rigid, map_file=text)
    assert cosimulate(within, "pid", plant=plant, map_file=text).outcome != "failed"
