"""Variables of every FMU as importers see them: those of variables.txt, one line of a kind each.

After an intended change: `python -m tests.export.fmi.test_fmi_variables`.
"""

import zipfile
from dataclasses import replace
from functools import cache
from itertools import count, groupby, product
from operator import itemgetter
from pathlib import Path

import pytest
from lxml import etree

from tests.tables import cases
from wmr_ctrl.core.fields.named_units import per_second, unit_of
from wmr_ctrl.export.fmi.files import Sources, write_archive
from wmr_ctrl.export.fmi.fmu_files import model_of
from wmr_ctrl.export.fmi.model_description import Role, orders
from wmr_ctrl.export.fmi.xml import _structure, _unknown, description
from wmr_ctrl.world.scenario import load_scenario

LISTED = Path(__file__).with_name("variables.txt")
WHAT = ("plant", "reference", "guard", "filter", "closed-loop", "mb", "nn")
DRIVES = {"clock.plant": 0.002, "actuator.jitter": 0.002, "actuator.lag": 0.02}
FILTER = {"filter.kind": "clip", "filter.gain": [0.9, 1.1], "filter.d": [0.05, 0.05]}
SHOWN = ("causality", "variability", "initial", "unit", "displayUnit", "nominal", "derivative")


@cache
def model(what):
    stated = FILTER if what == "filter" else DRIVES
    return model_of(what, "mb", load_scenario("paper-simulation", stated))


@cache
def xml(what, version):
    text = description(model(what), Sources({}, "token"), version, "wmr_ctrl 0")
    return etree.fromstring(text.encode())


def heads(what, version):
    """Attributes of each variable by its name; of a rate, the name of its state."""
    rows = [
        {key: value for node in item.iter("*") for key, value in node.attrib.items()}
        for item in xml(what, version).find("ModelVariables").iterchildren("*")
    ]
    references = map(str, count(1)) if version == 2 else [own["valueReference"] for own in rows]
    names = dict(zip(references, (own["name"] for own in rows), strict=False))
    for own in rows:
        own["derivative"] = names.get(own.get("derivative"))
    return {own["name"]: " ".join(own[key] for key in SHOWN if own.get(key)) for own in rows}


def listed():
    """A line for neighbours of one kind: their attributes, then their names."""
    for what in WHAT:
        yield what
        for head, names in groupby(heads(what, 2).items(), key=itemgetter(1)):
            yield f"  {head}: {' '.join(name for name, _ in names)}"


def test_variables_are_those_that_are_listed():
    assert list(listed()) == LISTED.read_text("utf-8").splitlines()


@pytest.mark.parametrize("what", WHAT)
def test_both_versions_say_the_same_of_each_variable(what):
    two, three = heads(what, 2), heads(what, 3)

    assert three == {name: two.get(name) or two[f"{name}[1]"] for name in three}


def test_an_array_is_described_as_a_whole():
    whole = [v for v in xml("nn", 3).find("ModelVariables") if v.find("Dimension") is not None]

    assert len(whole) == 2
    assert not [v.get("description") for v in whole if ", element" in v.get("description", "")]
    assert all(v.get("description") for v in whole)


@pytest.mark.parametrize("what, step", [("plant", 0.002), ("mb", 0.01), ("closed-loop", 0.01)])
def test_the_plant_steps_inside_and_all_else_by_the_period(what, step):
    assert float(xml(what, 3).find("CoSimulation").get("fixedInternalStepSize")) == step


def test_outputs_depend_on_what_moves_and_at_the_start_on_parameters_as_well():
    plant = model("plant")
    name_of = {str(i): v.name for i, v in enumerate(plant.variables)}
    on = {
        section: {name_of[i] for row in unknowns for i in dict(row)["dependencies"].split()}
        for section, unknowns in _structure(plant, 3, True)
    }
    every = {
        name_of[str(i)]
        for row, v in enumerate(plant.variables)
        if v.role is Role.CALCULATED
        for i, _ in plant.dependencies[row]
    }

    assert {"robot.m", "robot.mu", "tau_left", "v1"} < every
    assert on["InitialUnknown"] == every
    assert on["ContinuousStateDerivative"] == {
        name for name in every if not name.startswith(("robot", "clock"))
    }


@pytest.mark.parametrize("constant", [*product((True, False), repeat=2)])
def test_on_an_array_an_output_depends_linearly_if_on_each_element(constant):
    law = model("nn")
    head = next(i for i, v in enumerate(law.variables) if v.array)
    row = max(law.dependencies)
    own = {row: tuple((head + k, linear) for k, linear in enumerate(constant))}
    found = dict(_unknown(replace(law, dependencies=own), row, 3, True, True))
    kind = "constant" if constant == (True, True) else "dependent"

    assert (found["dependencies"], found["dependenciesKind"]) == (str(head), kind)


def test_initialisation_keeps_limits_apart_and_masses_in_order():
    law = model("mb")
    names = [v.name for v in law.variables]
    limits = {(f"limits.v_u2[{k}]", f"limits.v_u1[{k}]", True) for k in (1, 2)}
    masses = {(f"guard.M_min[{k}]", f"guard.M_max[{k}]", False) for k in (1, 2)}

    assert {(names[i], names[k], apart) for i, k, apart in orders(law)} == limits | masses


@pytest.mark.parametrize(
    "unit, rate",
    cases("""
        m | m/s
        m/s | m/s2
        rad/s2 | rad/s3
        kg.m2/s | kg.m2/s2
        N/m | N/m/s
        m/s/kg | m/s/kg/s
        m/ms | m/ms/s
        1 | 1/s
    """),
)
def test_rate_of_a_unit_is_that_unit_over_seconds(unit, rate):
    state, found = unit_of(unit), unit_of(per_second(unit))
    powers = {key: state.exponents.get(key, 0) - (key == "s") for key in ("kg", "m", "s", "rad")}

    assert (found.name, found.factor, per_second("")) == (rate, state.factor, "")
    assert found.exponents == {key: power for key, power in powers.items() if power}


def test_an_archive_has_no_time_and_its_binaries_may_be_run(tmp_path):
    path = write_archive(tmp_path / "a.fmu", {"binaries/x.so": b"", "modelDescription.xml": b""})
    with zipfile.ZipFile(path) as archive:
        found = {item.filename: (item.date_time, item.external_attr) for item in archive.filelist}
    epoch = (1980, 1, 1, 0, 0, 0)

    assert found == {
        "binaries/x.so": (epoch, 0o755 << 16),
        "modelDescription.xml": (epoch, 0o644 << 16),
    }


if __name__ == "__main__":
    LISTED.write_text("\n".join(listed()) + "\n", "utf-8")
