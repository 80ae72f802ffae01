"""Maps of names and units of somebody else's FMUs: keys, units, hints, and what they refuse."""

import re

import numpy as np
import pytest

from tests.export.cosim.foreign import PLANT
from wmr_ctrl.core.errors import ArgumentError, ScenarioError, UnknownNameError
from wmr_ctrl.core.fields.named_units import NamedUnit, unit_of
from wmr_ctrl.export.cosim import cosimulate
from wmr_ctrl.export.cosim.fmu_file import FmuFile
from wmr_ctrl.export.cosim.mapping import PartMap, compiled, input_rows, load_map, output_rows
from wmr_ctrl.world.scenario import load_scenario, override

SHORT = load_scenario("paper-simulation-nominal", {"clock.duration": 3.0})


@pytest.mark.parametrize(
    "row",
    [
        'x = "v1"',
        "x = { terms = { theta = 1.0 } }",
        'v1 = { terms = { theta = 1.0 }, coefficient_unit = "m" }',
        'x = { terms = { x = 1.0 }, unit = "parsec" }',
    ],
)
@pytest.mark.slow_but('x = "v1"', 'x = { terms = { x = 1.0 }, unit = "parsec" }')
def test_units_that_do_not_fit_are_refused(exported, mapped, row):
    with pytest.raises(ArgumentError, match=r"plant\.outputs|parsec"):
        cosimulate(
            SHORT, "pid", plant=exported("plant", 2), map_file=mapped(f"[plant.outputs]\n{row}\n")
        )


@pytest.mark.parametrize(
    "unit, row", [("N.m", "tau_right"), ("rad/s", "omega"), ("m", "x"), ("rad", "theta")]
)
def test_the_hint_names_a_unit_of_the_right_dimension(unit, row):
    gives, takes = ("controller", "plant") if unit == "N.m" else ("plant", "controller")
    with pytest.raises(ArgumentError, match=re.escape(f'unit = "{unit}"')):
        output_rows(PartMap(outputs={row: "theirs"}), lambda _: None, gives)
    with pytest.raises(ArgumentError, match=re.escape(f'unit = "{unit}"')):
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
    """What a row states counts all the same."""
    file = FmuFile(foreign("TheirRobot", PLANT), "plant")
    text = UNSTATED.format(units='units = "SI"', omega='{ terms = { wheelL = 1.0 }, unit = "rpm" }')
    part = load_map(mapped(text))["plant"]
    rows = output_rows(part, file.unit, "plant")
    assert [row.terms[0][1] == 1.0 and not row.offset for row in rows] == [True] * 4 + [False]
    assert rows[-1].terms == (("wheelL", pytest.approx(np.pi / 30)),)
    with pytest.raises(ScenarioError, match=r'plant\.units = "mm" is not known'):
        load_map(mapped(text.replace('"SI"', '"mm"')))


def test_units_are_what_the_fmu_defines():
    """mN.m by a factor, degC by an offset too, under whatever name."""
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
    scenario = override(SHORT, {"changes": [{"t": 1.0, "m": 60.0}]})
    rows = "\n".join(f'{n} = "{n}"' for n in ("x", "y", "theta", "v1", "omega"))
    with pytest.raises(ArgumentError, match=r"changes robot\.m"):
        cosimulate(
            scenario,
            "pid",
            plant=exported("plant", 2),
            map_file=mapped(f"[plant.outputs]\n{rows}\n"),
        )


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


def test_a_row_of_no_source_is_a_constant_only_if_it_says_which():
    with pytest.raises(ArgumentError, match=r"plant\.inputs\.x: no terms"):
        input_rows(PartMap(inputs={"x": {"terms": {}}}), lambda _: "m", "plant")
    for constant in ({"terms": {}, "offset": 2.0}, {"offset": 2}, 2):
        (row,) = input_rows(PartMap(inputs={"x": constant}), lambda _: "m", "plant")
        assert (row.terms, row.offset) == ((), 2.0)


@pytest.mark.parametrize(
    "row, words",
    [
        ({"terms": {"theta": "far"}}, r'plant\.inputs\.x\.terms\.theta = "far" must be a number'),
        ({"terms": {}, "ofset": 1.0}, r"plant\.inputs\.x\.ofset is not .*near: offset"),
    ],
)
def test_entries_of_a_map_are_told_like_keys_of_a_scenario(row, words):
    with pytest.raises(ScenarioError, match=words):
        input_rows(PartMap(inputs={"x": row}), lambda _: "m", "plant")


@pytest.mark.parametrize(
    "read, part, row, words",
    [
        (input_rows, "plant", "tau_applied[1]", r"plant\.inputs\.theirs can have .* tau_right"),
        (input_rows, "controller", "torque_right", r"controller\.inputs\.theirs can have"),
        (output_rows, "plant", "x_d", r"plant\.outputs\.x_d can have"),
        (output_rows, "controller", "v1", r"controller\.outputs\.v1 can have"),
    ],
)
def test_a_quantity_that_a_part_does_not_have_is_refused(read, part, row, words):
    """It was without effect, or a KeyError in the first step."""
    given = {"inputs": {"theirs": row}} if read is input_rows else {"outputs": {row: "theirs"}}
    with pytest.raises(UnknownNameError, match=words):
        read(PartMap(**given), lambda _: "m", part)


@pytest.mark.parametrize(
    "part, both",
    [
        ("plant", ("theta", "psi")),
        ("plant", ("v1", "w_left")),
        ("controller", ("tau_left", "force[1]")),
    ],
)
def test_rows_of_which_one_has_no_effect_are_refused(part, both):
    with pytest.raises(ArgumentError, match=f"both {' and '.join(map(re.escape, both))}"):
        output_rows(PartMap(outputs=dict.fromkeys(both, "theirs")), lambda _: "m", part)


def test_a_part_of_a_map_without_its_file_is_refused(exported, mapped):
    with pytest.raises(ArgumentError, match=r"part \[controller\], and no controller FMU"):
        cosimulate(
            SHORT, "pid", plant=exported("plant", 2), map_file=mapped("[controller]\nstep = 0.01\n")
        )


def test_an_array_is_mapped_by_its_elements(exported):
    file = FmuFile(exported("nn", 3), "controller")
    with pytest.raises(ArgumentError, match=r"W_hat1 is an array: name W_hat1\[1\] to"):
        file.variable("W_hat1")
    assert file.number("W_hat1[3]")[1] == 2
