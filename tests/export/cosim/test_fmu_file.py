"""A foreign plant in FMI 3.0, written in C: its steps, its messages, the units of its mass."""

import json
import re
import sys
from pathlib import Path

import numpy as np
import pytest
from fmpy import platform_tuple

from tests.commands import finished, flat
from tests.compilers import where
from tests.export.fmi.test_targets import HEADERS
from tests.tables import cases
from wmr_ctrl.api import simulate
from wmr_ctrl.cli.summary import summary_text
from wmr_ctrl.core.errors import ArgumentError, UnknownNameError, WmrError
from wmr_ctrl.export.cosim import cosimulate
from wmr_ctrl.export.cosim.fmu_file import FmuError
from wmr_ctrl.export.cosim.map_template import write_map_template
from wmr_ctrl.export.fmi.files import write_archive
from wmr_ctrl.world.scenario import load_scenario, override

SHORT = load_scenario("paper-simulation-nominal", {"clock.duration": 1.0})
LIGHTER = override(SHORT, {"changes": [{"t": 0.4, "m": 45.0}]})
SOURCE = Path(__file__).with_name("foreign3.c")
KINDS = {
    '"input" start="0"': "right left",
    '"output" initial="calculated"': "x y yaw v w",
    '"parameter" start="0" variability="tunable" unit="g"': "grams",
    '"parameter" start="0" variability="fixed"': "fixed mode",
}
"""Attributes and names of the FMU's real variables."""
FURTHER = """<Boolean name="enable" valueReference="20" causality="input" start="true"/>
<Int8 name="steps" valueReference="21" causality="input" start="1"/>
<Float32 name="share" valueReference="22" causality="input" start="1"/>
<Float64 name="twist" valueReference="23" causality="output"><Dimension start="2"/></Float64>
<Float64 name="push" valueReference="24" causality="input" start="0 0">
<Dimension start="2"/></Float64>
<String name="called" valueReference="25" causality="parameter" variability="fixed">
<Start value="none"/></String>"""
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
def packed(tmp_path_factory):
    """A function that packs the FMU, unchanged or altered; missing functions fail."""
    folder = tmp_path_factory.mktemp("foreign3")
    own = SOURCE.read_text("utf-8")
    types = (HEADERS / "fmi3FunctionTypes.h").read_text("utf-8")
    every = re.findall(r"typedef\s+(\w+)\s+(fmi3\w+)TYPE\s*\((.*?)\)\s*;", types, re.S)
    written = {*re.findall(r"fmi3\w+", own)} | {f"fmi3{verb}{kind}" for verb in ("Get", "Set")
               for kind in ("Boolean", "Int8", "Float32")}  # fmt: skip
    rest = [f"{of} {name}({given}) {{ return 0; }}" for of, name, given in every
            if name not in written]  # fmt: skip
    others, library = folder / "rest.c", folder / "foreign3.so"
    others.write_text("\n".join(['#include "fmi3Functions.h"', *rest]))
    flags = ["-shared", "-fPIC", "-w", f"-I{HEADERS}", "-o", library]
    finished([where("cc"), *flags, SOURCE, others, "-lm"])
    named = [(name, more) for more, names in KINDS.items() for name in names.split()]
    rows = [f'<Float64 name="{name}" valueReference="{i}" causality={more}/>'
            for i, (name, more) in enumerate(named)]  # fmt: skip
    order = [f'<{what} valueReference="{i}"/>' for what in ("Output", "InitialUnknown")
             for i in (2, 3, 4, 5, 6, 23)]  # fmt: skip
    text = f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="TheirThree" instantiationToken="three">
<CoSimulation modelIdentifier="foreign3" canHandleVariableCommunicationStepSize="true"/>
<UnitDefinitions><Unit name="g"><BaseUnit kg="1" factor="0.001"/></Unit></UnitDefinitions>
<ModelVariables><Float64 name="time" valueReference="99" causality="independent"/>
{"".join(rows)}{FURTHER}</ModelVariables>
<ModelStructure>{"".join(order)}</ModelStructure></fmiModelDescription>"""
    build = b"""<?xml version="1.0" encoding="UTF-8"?><fmiBuildDescription fmiVersion="3.0">
<BuildConfiguration modelIdentifier="foreign3"><SourceFileSet language="C99">
<SourceFile name="foreign3.c"/><SourceFile name="rest.c"/></SourceFileSet></BuildConfiguration>
</fmiBuildDescription>"""

    def pack(name="three", library_name="foreign3", *, sources=False, described=()):
        told = text
        for old, new in described:
            assert old in told
            told = told.replace(old, new)
        files = {"modelDescription.xml": told.encode()}
        if library_name:
            files[f"binaries/{platform_tuple}/{library_name}.so"] = library.read_bytes()
        if sources:
            files["sources/buildDescription.xml"] = build
            files |= {f"sources/{unit.name}": unit.read_bytes() for unit in (SOURCE, others)}
        return write_archive(folder / f"{name}.fmu", files)

    return pack


@pytest.fixture
def their_map(mapped):
    """A function: mode of the plant, and the row of its mass -> the map."""
    return lambda mode=0, mass='"grams"': mapped(MAP.format(mode=mode, mass=mass))


@pytest.fixture(scope="module")
def plant(packed):
    return packed()


def test_a_change_is_set_in_the_plants_own_unit(plant, their_map):
    """A mass in g was once silently set to 45."""
    run = cosimulate(LIGHTER, "pid", plant=plant, map_file=their_map(), fmi=3)
    ours, heavy = (simulate(case, "pid") for case in (LIGHTER, SHORT))
    assert run.outcome == ours.outcome
    assert np.abs(run["v1"] - ours["v1"]).max() < 2e-4 < np.abs(ours["v1"] - heavy["v1"]).max()
    assert "warned_plant" not in run.provenance


@pytest.mark.parametrize(
    "mass, words",
    cases(r"""
        "fixed" | fixed of .* cannot be set during a run .*fixed parameter
        "v" | v of .* \(it is a continuous output\)
        "gram" | is named 'gram' .near: grams
        { terms = { grams = 1.0, fixed = 1.0 } } | of one parameter
        { terms = { grams = 0.0 } } | coefficient other than 0
        { terms = { grams = 1.0 }, unit = "m" } | grams in m does not give kg
        "grams"; "robot.M" = "grams" | is named 'robot.M' .near: robot.m
    """),
)
def test_a_change_that_cannot_be_made_is_refused_before_it_runs(plant, their_map, mass, words):
    given = {"plant": plant, "map_file": their_map(mass=mass.replace(";", "\n"))}
    with pytest.raises((ArgumentError, UnknownNameError), match=words):
        cosimulate(LIGHTER, "pid", **given)


def test_a_time_that_lags_and_warnings_are_told_and_end_no_run(plant, their_map):
    """Status and flags do not show that the last successful time lags, so other importers continue,
    too.
    """
    lags, warns = "0.005 s behind the step's end", "beyond the range of the tyres"
    same = cosimulate(SHORT, "pid", plant=plant, map_file=their_map(0))
    for mode, what, text in ((1, "lagged", lags), (2, "warned", warns)):
        run = cosimulate(SHORT, "pid", plant=plant, map_file=their_map(mode))
        told, key = f"50 steps, first at t = 0.5 s: {text}", f"{what}_plant"
        assert np.array_equal(run["v1"], same["v1"])
        assert (run.provenance[key], key in same.provenance) == (told, False)
        assert f"plant {what} in {told}" in flat(summary_text(run))


def test_a_plant_that_takes_steps_of_one_size_is_not_stepped_by_others(plant, packed, their_map):
    """A change within a control period would cut one."""
    rigid = packed("rigid", described=[('StepSize="true"', 'StepSize="false"')])
    within = override(SHORT, {"changes": [{"t": 0.404, "m": 45.0}], "clock.duration": 0.5})
    with pytest.raises(ArgumentError, match=r"rigid\.fmu, which takes steps of one size, 0\.01 s"):
        cosimulate(within, "pid", plant=rigid, map_file=their_map())
    assert cosimulate(within, "pid", plant=plant, map_file=their_map()).outcome != "failed"


TYPED = """
[plant]
units = "SI"
inputs = { right = "torque_right", left = "torque_left", enable = true, steps = { offset = 2 } }
outputs = { x = "x", y = "y", psi = "yaw", v1 = "twist[1]", omega = "twist[2]" }
[plant.start]
"""


def test_rows_have_every_type_of_number_and_elements_of_arrays(plant, mapped):
    """An enable flag, an integer, single precision, and array elements that are read and
    written.
    """

    def run(start="", text=TYPED):
        return cosimulate(SHORT, "pid", plant=plant, map_file=mapped(text + start))

    same = run(text=MAP.format(mode=0, mass='"grams"'))["v1"]
    off = run("enable = false", TYPED.replace(", enable = true", ""))
    assert abs(run()["v1"] - same).max() < 1e-4
    assert abs(off["v1"] - SHORT.initial.velocity[0]).max() < 1e-9
    assert abs(run('called = "still"')["omega"]).max() < 1e-9
    for start in ("push = [1.0, 90.0]", '"push[2]" = 90.0'):
        assert (run(start)["v1"] - same)[30] > 0.1


@pytest.mark.parametrize(
    "old, new, words",
    cases(r"""
        offset = 2 | offset = 300 | setting steps: 300 does not fit into type Int8
        "twist[1]" | "twist" | twist is an array: name twist\[1\] to twist\[2\]
        "twist[1]" | "twist[0]" | twist\[0\] .* name twist\[1\]
        "twist[1]" | "v[1]" | v\[1\] of .*: v is one number
        "twist[1]" | "called" | called .* is of type String, which is no number
        [plant.start] | [plant.start] steps = 2.5 | it is of type Int8, and 2.5 is no whole
        [plant.start] | [plant.start] steps = "two" | setting steps to .*two
        [plant.start] | [plant.start] push = [1.0] | setting push to .* 2 elements
        enable = true | enable = [true] | must be a name, a constant, or a table
    """),
)
def test_what_no_variable_can_take_is_told(plant, mapped, old, new, words):
    text = TYPED.replace(old, new.replace("] ", "]\n"))
    try:
        said = cosimulate(SHORT, "pid", plant=plant, map_file=mapped(text)).explanation
    except WmrError as error:
        said = str(error)
    assert re.search(words, said), said


def test_what_an_fmu_prints_never_reaches_standard_output(plant, their_map):
    """Nor does C's buffer, which is written when the process ends."""
    words = "-m wmr_ctrl cosim paper-simulation-nominal --law pid --set clock.duration=0.6 --json"
    given = ["--plant", plant, "--map", their_map(3)]
    done = finished([sys.executable, *words.split(), *given])
    assert json.loads(done.stdout)["outcome"] != "failed"
    assert done.stderr.count("still driving") == 10


@pytest.mark.parametrize(
    "given, words",
    [
        ({"library_name": "other"}, r"foreign3\.so but other\.so there.* Rename it"),
        ({"described": [('n="3.0"', 'n="3.0-beta.3"')]}, r"it is of FMI 3\.0-beta\.3, and only"),
        ({"described": [('n="3.0"', 'n="1.0"')]}, r"it is of FMI 1\.0, and only 2\.0 and 3\.0"),
        ({"described": [('"three"', '"clocked"'), (FURTHER, FURTHER + "<Clock name='tick'"
          " valueReference='30' intervalVariability='triggered' causality='output'/>")]},
         r"It said: only with event mode\. It has clocks \(tick\)"),
        ({"library_name": "", "sources": True}, r"It has its sources: build them \(--compile\)"),
    ],
)  # fmt: skip
def test_a_file_that_cannot_be_used_is_told_why(packed, their_map, given, words):
    with pytest.raises(FmuError, match=words):
        cosimulate(SHORT, "pid", plant=packed("odd", **given), map_file=their_map())


def test_a_description_that_breaks_the_rules_is_told_and_read(plant, packed, mapped):
    """PythonFMU writes whole numbers as continuous variables, and importers accept them."""
    text = mapped(TYPED)
    odd = packed("rules", described=[('"steps"', '"steps" variability="continuous"')])
    run, same = (cosimulate(SHORT, "pid", plant=file, map_file=text) for file in (odd, plant))
    assert np.array_equal(run["v1"], same["v1"])
    told = run.provenance["invalid_plant"]
    assert re.search('"steps" .* is of type Int8 and must have variability', told)
    assert f"plant invalid in {told}" in flat(summary_text(run))


@pytest.mark.slow
def test_sources_are_built_where_the_library_is_missing(plant, packed, their_map):
    map_file = their_map()
    files = plant, packed("bare", "", sources=True)
    same, built = (
        cosimulate(SHORT, "pid", plant=file, map_file=map_file, compile_sources=file != plant)
        for file in files
    )
    assert np.abs(built["x"] - same["x"]).max() < 1e-9
    with pytest.raises(ArgumentError, match="Name a plant or a controller"):
        cosimulate(SHORT, "pid", compile_sources=True)


def test_a_template_lists_numbers_of_every_type(plant, tmp_path):
    text = write_map_template(tmp_path / "map.toml", plant, None).read_text("utf-8")
    for row in (
        "enable = true  # Boolean",
        '"push[2]" = ',
        "steps = ",
        'called = "none"  # String',
    ):
        assert f"\n# {row}" in text
    assert "twist[1]," in text
