"""Description of an FMU: schemas, validation, units, structure, content."""

import csv
import math
import posixpath
import re
import zipfile

import casadi as ca
import pytest
from fmpy import read_model_description, simulate_fmu
from fmpy.model_description import read_build_description
from lxml import etree

from tests.export.fmi.cases import FMUS
from tests.export.fmi.test_fmi_derivatives import system_of
from wmr_ctrl.core.signals import LARGEST, PLANT_STATE, TORQUE
from wmr_ctrl.export.fmi.fmu_files import export_fmu
from wmr_ctrl.export.fmi.model_description import Role, Variable, finite, input_rows, rate_rows
from wmr_ctrl.world.model.system import ports

every_fmu = pytest.mark.parametrize("what, version", FMUS)


def read(path, name):
    with zipfile.ZipFile(path) as archive:
        return archive.read(name)


@every_fmu
def test_descriptions_follow_the_standards(exported, what, version):
    """Schemas, legal kinds of variables, start values, units and a complete structure, by FMPy."""
    path = str(exported(what, version))
    description = read_model_description(path, validate_model_structure=True)
    variables, experiment = description.modelVariables, description.defaultExperiment
    defined = {unit.name for unit in description.unitDefinitions}

    assert bool(read_build_description(path)) == (version == 3)
    assert len({v.valueReference for v in variables}) == len(variables)
    assert (float(experiment.stopTime), float(experiment.stepSize)) == (80.0, 0.01)
    for v in variables:
        assert v.description, v.name
        assert v.unit in defined or v.type in ("Integer", "Int64"), v.name
        assert v.causality != "parameter" or None not in (v.min, v.max)
        if v.min is not None:
            start = map(float, str(v.start).split())
            assert v.start is None or all(float(v.min) <= x <= float(v.max) for x in start), v.name


@every_fmu
def test_unknowns_stand_in_order_and_depend_on_what_is_known(exported, what, version):
    description = read_model_description(str(exported(what, version)))
    place = {v.name: i for i, v in enumerate(description.modelVariables)}
    outputs, rates = description.outputs, description.derivatives
    for group in (outputs, rates, description.initialUnknowns):
        order = [place[unknown.variable.name] for unknown in group]
        assert order == sorted(set(order))
        for v in {v for unknown in group for v in unknown.dependencies or []}:
            state = v.initial == "exact" and v.variability == "continuous"
            known = v.initial == "exact" if group is description.initialUnknowns else state
            assert v.causality in ("input", "independent") or known, v.name
    for rate in rates:
        state = rate.variable.derivative
        assert rate.variable.name == f"der({state.name})"
        assert state.variability == rate.variable.variability == "continuous"
    assert len(rates) == (5 if what == "plant" else 0)


CAPABLE = "canGetAndSetFMU{0}tate canSerializeFMU{0}tate canHandleVariableCommunicationStepSize"
EARLY = " canReturnEarlyAfterIntermediateUpdate mightReturnEarlyFromDoStep"
CAPABILITIES = {
    2: (
        CAPABLE.format("s") + " canNotUseMemoryManagementFunctions",
        " providesDirectionalDerivative",
    ),
    3: (
        CAPABLE.format("S") + EARLY + " providesIntermediateUpdate",
        " providesAdjointDerivatives providesDirectionalDerivatives",
    ),
}
"""Capabilities by FMI version: of every FMU, and of all but closed loops."""


@every_fmu
def test_capabilities_are_declared(exported, what, version):
    description = etree.fromstring(read(exported(what, version), "modelDescription.xml"))
    told = description.find("CoSimulation").attrib
    every, derivatives = CAPABILITIES[version]
    wanted = every + derivatives * (what != "closed-loop")
    assert {name for name, value in told.items() if value == "true"} == {*wanted.split()}


@pytest.mark.parametrize(
    "what, version", [("plant", 3), ("nn", 2), ("pid", 2), ("prox", 2), ("kanayama", 2)]
)
@pytest.mark.slow_but("plant-3", "nn-2")
def test_structure_is_the_jacobians(exported, what, version):
    """Outputs and rates name exactly the inputs and states with a nonzero derivative."""
    description = read_model_description(str(exported(what, version)))
    system, is_plant = system_of(what), what == "plant"
    by = [*system.inputs, *(system.state if is_plant else ())]
    results = [*system.outputs, *system.diagnostics]
    shown = {
        name: expr
        for item in results
        for name, expr in zip(item.signal.elements, ca.vertsplit(item.expr), strict=True)
    }
    if is_plant:
        names = [f"der({port.signal.name})" for port in system.state]
        rates = zip(names, ca.vertsplit(system.update), strict=True)
        shown = dict(rates) | {"psi": shown["psi"]}
    knowns = [name for port in by for name in port.signal.elements]
    slope = ca.jacobian(ca.vertcat(*shown.values()), ca.vertcat(*(port.sym for port in by)))
    wanted = {
        name: [known for j, known in enumerate(knowns) if slope.sparsity().has_nz(i, j)]
        for i, name in enumerate(shown)
    }
    unknowns = (*description.derivatives, *description.outputs)
    listed = {u.variable.name: [v.name for v in u.dependencies] for u in unknowns}
    assert wanted.items() <= listed.items()
    assert is_plant or wanted == listed


@every_fmu
def test_provenance_travels_along(exported, what, version):
    path = exported(what, version)
    with zipfile.ZipFile(path) as archive:
        names = set(archive.namelist())
    assert b"m = 65" in read(path, "extra/org.wmr-ctrl/scenario.toml")
    assert {"documentation/index.html", "sources/instance.c"} <= names
    assert not {n for n in names if n.endswith((".pdb", ".lib"))}
    if what != "closed-loop":
        assert read(path, "extra/org.wmr-ctrl/evaluate.casadi").isascii()


@every_fmu
def test_an_importer_can_check_itself_by_the_manifest(exported, what, version):
    """FMI-LS-REF names a result and the start values it was made with; both are there and agree."""
    path, place = exported(what, version), "extra/org.fmi-standard.fmi-ls-ref/"
    manifest = etree.fromstring(read(path, f"{place}fmi-ls-manifest.xml"))
    related = {item.get("role"): item for item in manifest.findall("Related")}
    files = {
        role: read(path, posixpath.normpath(place + item.get("source")))
        for role, item in related.items()
    }
    names, *rows = csv.reader(files["result"].decode().splitlines())
    reals = etree.fromstring(files.get("parameter", b"<none/>")).iter("{*}Real")
    values = {item.getparent().get("name"): float(item.get("value")) for item in reals}
    assert (manifest.tag, bool(values)) == ("fmiReferences", what == "plant")
    found = simulate_fmu(
        str(path), stop_time=0.1, step_size=0.01, output_interval=0.01, start_values=values,
        output=names[1:], fmi_type="CoSimulation",
    )  # fmt: skip
    assert [list(row) for row in found] == [list(map(float, row)) for row in rows[:11]]
    told = related["result"].get("description")
    times = re.search(r"([\d.]+) s of .* in steps of ([\d.]+) s", told).groups()
    assert [float(rows[k][0]) for k in (-1, 1)] == [*map(float, times)]


def test_export_depends_on_content_alone(tmp_path):
    (first,) = export_fmu("plant", fmi=2, out=tmp_path / "a")
    (second,) = export_fmu("plant", fmi=2, out=tmp_path / "b")
    assert first.read_bytes() == second.read_bytes()


def test_infinity_is_the_largest_number_and_keeps_its_sign():
    assert [finite(x) for x in (math.inf, -math.inf, 2)] == [LARGEST, -LARGEST, 2.0]


def test_inputs_begin_as_stated_and_rates_are_per_second():
    rows = list(input_rows(ports(TORQUE), {"tau_left": 3.0}))
    assert [(item.name, item.start) for item in rows] == [("tau_right", 0.0), ("tau_left", 3.0)]

    state = Variable("v1", "m/s", PLANT_STATE[3].meaning, Role.START)
    (rate,) = rate_rows([state])
    assert (rate.name, rate.unit, rate.rate_of) == ("der(v1)", "m/s2", "v1")
    assert state.known
    assert not rate.known
