"""Maps of names and units of foreign FMUs: keys, units, hints and refusals."""

import re

import numpy as np
import pytest

from tests.export.cosim.foreign import PLANT
from tests.tables import cases
from wmr_ctrl.core.errors import ArgumentError, ScenarioError, UnknownNameError
from wmr_ctrl.core.fields.named_units import NamedUnit, unit_of
from wmr_ctrl.export.cosim import cosimulate
from wmr_ctrl.export.cosim.fmu_file import FmuFile
from wmr_ctrl.export.cosim.mapping import PartMap, compiled, input_rows, load_map, output_rows
from wmr_ctrl.world.scenario import load_scenario, override

SHORT = load_scenario("paper-simulation-nominal", {"clock.duration": 3.0})


@pytest.mark.parametrize(
    "row",
    cases("""
        x = "v1"
        x = { terms = { x = 1.0 }, unit = "parsec" }
        x = { terms = { theta = 1.0 } } | slow
        v1 = { terms = { theta = 1.0 }, coefficient_unit = "m" } | slow
    """),
)
def test_units_that_do_not_fit_are_refused(exported, mapped, row):
    file = mapped(f"[plant.outputs]\n{row}\n")
    with pytest.raises(ArgumentError, match=r"plant\.outputs|parsec"):
        cosimulate(SHORT, "pid", plant=exported("plant", 2), map_file=file)


@pytest.mark.parametrize(
    "unit, row", [("N.m", "tau_right"), ("rad/s", "omega"), ("m", "x"), ("rad", "theta")]
)
def test_the_hint_names_a_unit_of_the_right_dimension(unit, row):
    gives, takes = ("controller", "plant") if unit == "N.m" else ("plant", "controller")
    hint = re.escape(f'unit = "{unit}"')
    with pytest.raises(ArgumentError, match=hint):
        output_rows(PartMap(outputs={row: "theirs"}), lambda _: None, gives)
    with pytest.raises(ArgumentError, match=hint):
        input_rows(PartMap(inputs={"theirs": row}), lambda _: "furlong", takes)


UNSTATED = """
[plant]
{units}
[plant.inputs]
motorR = "torque_right"
motorL = "torque_left"
[plant.outputs]
x = "px"
y = "py"
theta = "heading"
v1 = "wheelR"
omega = {omega}
"""
"""PythonFMU's FMUs state no units."""


def test_units_that_are_not_stated_are_asked_for_by_the_row(foreign, mapped):
    plant = foreign("TheirRobot", PLANT)
    row = re.escape('motorR = { terms = { torque_right = 1.0 }, unit = "N.m" }')
    with pytest.raises(ArgumentError, match=rf"such as: {row}; .*units = \"SI\" in \[plant\]"):
        cosimulate(SHORT, "pid", plant=plant, map_file=mapped(UNSTATED.format(units="", omega="1")))


def test_units_may_be_those_of_the_si(foreign, mapped):
    """The unit of a row takes precedence over SI units of the part."""
    file = FmuFile(foreign("TheirRobot", PLANT), "plant")
    text = UNSTATED.format(units='units = "SI"', omega='{ terms = { wheelL = 1.0 }, unit = "rpm" }')
    part = load_map(mapped(text))["plant"]
    rows = output_rows(part, file.unit, "plant")
    assert [row.offset for row in rows] == [0.0] * 5
    assert [row.terms[0][1] for row in rows] == [1.0] * 4 + [pytest.approx(np.pi / 30)]
    with pytest.raises(ScenarioError, match=r'plant\.units = "mm" is not known'):
        load_map(mapped(text.replace('"SI"', '"mm"')))


def test_units_are_what_the_fmu_defines():
    """mN.m by a factor, degC also by an offset, for any name of the unit."""
    milli = NamedUnit("milli", 1e-3, unit_of("N.m").exponents)
    theirs = {"torque": milli, "angle": NamedUnit("turned", np.pi / 180, {"rad": 1}, 0.5)}
    part = PartMap(
        inputs={"torque": "tau_applied[1]", "angle": "theta"}, outputs={"theta": "angle"}
    )
    inward, back = input_rows(part, theirs.get, "controller")
    (outward,) = output_rows(part, theirs.get, "plant")
    assert inward.terms == (("tau_applied[1]", pytest.approx(1000.0)),)
    assert compiled([outward], ["angle"])([90.0]) == [pytest.approx(np.pi / 2 + 0.5)]
    assert compiled([back], ["theta"])([np.pi / 2 + 0.5]) == [pytest.approx(90.0)]


def test_a_change_that_the_map_cannot_make_is_refused(exported, mapped):
    rows = "\n".join(f'{n} = "{n}"' for n in ("x", "y", "theta", "v1", "omega"))
    given = {"plant": exported("plant", 2), "map_file": mapped(f"[plant.outputs]\n{rows}\n")}
    with pytest.raises(ArgumentError, match=r"changes robot\.m"):
        cosimulate(override(SHORT, {"changes": [{"t": 1.0, "m": 60.0}]}), "pid", **given)


@pytest.mark.parametrize(
    "text, words",
    [
        ("[plant]\nstep = -1\n", r"plant\.step = -1 must be above 0"),
        ("[plant]\ninputs = 3\n", r"written as \[plant\.inputs\]"),
        ("plant = 3\n", r"written as \[plant\]"),
    ],
)
def test_keys_of_a_map_are_told_like_those_of_a_scenario(mapped, text, words):
    with pytest.raises(ScenarioError, match=rf"{words}.* \(In .*\.toml\.\)"):
        load_map(mapped(text))


def taken(row):
    """Value in m of the input x that a row gives."""
    return input_rows(PartMap(inputs={"x": row}), lambda _: "m", "plant")[0]


def test_a_row_of_no_source_is_a_constant_only_if_it_says_which():
    with pytest.raises(ArgumentError, match=r"plant\.inputs\.x: no terms"):
        taken({"terms": {}})
    for constant in ({"terms": {}, "offset": 2.0}, {"offset": 2}, 2):
        assert (taken(constant).terms, taken(constant).offset) == ((), 2.0)


def test_entries_of_a_map_are_told_like_keys_of_a_scenario():
    with pytest.raises(ScenarioError, match=r'inputs\.x\.terms\.theta = "far" must be a number'):
        taken({"terms": {"theta": "far"}})
    with pytest.raises(ScenarioError, match=r"plant\.inputs\.x\.ofset is not .*near: offset"):
        taken({"terms": {}, "ofset": 1.0})


@pytest.mark.parametrize(
    "part, takes, gives", [("plant", "tau_applied[1]", "x_d"), ("controller", "torque_right", "v1")]
)
def test_a_quantity_that_a_part_does_not_have_is_refused(part, takes, gives):
    """Such a row once had no effect, or raised a KeyError in the first step."""
    with pytest.raises(UnknownNameError, match=rf"{part}\.inputs\.theirs can have"):
        input_rows(PartMap(inputs={"theirs": takes}), lambda _: "m", part)
    with pytest.raises(UnknownNameError, match=rf"{part}\.outputs\.{gives} can have"):
        output_rows(PartMap(outputs={gives: "theirs"}), lambda _: "m", part)


@pytest.mark.parametrize(
    "part, one, other",
    cases("plant | theta | psi\nplant | v1 | w_left\ncontroller | tau_left | force[1]"),
)
def test_rows_of_which_one_has_no_effect_are_refused(part, one, other):
    with pytest.raises(ArgumentError, match=re.escape(f"both {one} and {other}")):
        output_rows(PartMap(outputs={one: "theirs", other: "theirs"}), lambda _: "m", part)


def test_a_part_of_a_map_without_its_file_or_effect_is_refused(exported, mapped):
    given = {"plant": exported("plant", 2), "map_file": mapped("[controller]\nstep = 0.01\n")}
    with pytest.raises(ArgumentError, match=r"part \[controller\], and no controller FMU"):
        cosimulate(SHORT, "pid", **given)
    with pytest.raises(ArgumentError, match=r"\[controller\.parameters\] .* has no effect"):
        load_map(mapped('[controller.parameters]\ngains = "k"\n'))


def test_an_array_is_mapped_by_its_elements(exported):
    file = FmuFile(exported("nn", 3), "controller")
    with pytest.raises(ArgumentError, match=r"W_hat1 is an array: name W_hat1\[1\] to"):
        file.variable("W_hat1")
    assert file.number("W_hat1[3]")[1] == 2
