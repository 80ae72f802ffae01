"""What an FMU says of itself: schemas, validation, units, structure, content."""

import math
import posixpath
import re
import zipfile

import casadi as ca
import pytest
from fmpy import read_model_description, simulate_fmu
from fmpy.model_description import read_build_description
from fmpy.validation import validate_fmu
from lxml import etree

from tests.export.fmi.cases import FMUS, SOME_FMUS
from tests.export.fmi.test_fmi_derivatives import system_of
from wmr_ctrl.core.signals import LARGEST, PLANT_STATE, TORQUE
from wmr_ctrl.export.fmi.fmu_files import export_fmu
from wmr_ctrl.export.fmi.model_description import Role, Variable, finite, input_rows, rate_rows
from wmr_ctrl.world.model.system import ports

every_fmu = pytest.mark.parametrize("what, version", FMUS)
some_fmus = pytest.mark.parametrize("what, version", SOME_FMUS)


def read(path, name):
    with zipfile.ZipFile(path) as archive:
        return archive.read(name)


@every_fmu
def test_descriptions_follow_the_standards(exported, what, version):
    """Schemas, legal kinds of variables, start values, units and a complete structure, by FMPy."""
    path = str(exported(what, version))
    variables = read_model_description(path, validate_model_structure=True).modelVariables

    assert bool(read_build_description(path)) == (version == 3)
    assert len({v.valueReference for v in variables}) == len(variables)
    for v in variables:
        if v.min is not None:
            start = map(float, str(v.start).split())
            assert v.start is None or all(float(v.min) <= x <= float(v.max) for x in start), v.name


@pytest.mark.parametrize("what, version", [("plant", 2), ("closed-loop", 2), ("prox", 3)])
@pytest.mark.slow
def test_names_of_variables_follow_the_standards(exported, what, version):
    assert validate_fmu(str(exported(what, version))) == []


@every_fmu
def test_unknowns_stand_in_order_and_depend_on_what_is_known(exported, what, version):
    description = read_model_description(str(exported(what, version)))
    place = {v.name: i for i, v in enumerate(description.modelVariables)}
    outputs, rates = description.outputs, description.derivatives
    for group in (outputs, rates, description.initialUnknowns):
        order = [place[unknown.variable.name] for unknown in group]
        assert order == sorted(set(order))
        for unknown in group:
            for v in unknown.dependencies or []:
                state = v.initial == "exact" and v.variability == "continuous"
                known = v.initial == "exact" if group is description.initialUnknowns else state
                assert v.causality in ("input", "independent") or known, (unknown.variable, v.name)
    for rate in rates:
        state = rate.variable.derivative
        assert rate.variable.name == f"der({state.name})"
        assert state.variability == rate.variable.variability == "continuous"
    assert len(rates) == (5 if what == "plant" else 0)


@pytest.mark.parametrize("version", [2, 3])
def test_experiment_is_the_scenarios(exported, version):
    experiment = read_model_description(str(exported("plant", version))).defaultExperiment
    assert (float(experiment.stopTime), float(experiment.stepSize)) == (80.0, 0.01)


@some_fmus
def test_every_quantity_is_documented_and_has_a_defined_unit(exported, what, version):
    description = read_model_description(str(exported(what, version)))
    defined = {unit.name for unit in description.unitDefinitions}
    for v in description.modelVariables:
        assert v.description, v.name
        assert v.unit in defined or v.type in ("Integer", "Int64"), v.name
        if v.causality == "parameter":
            assert v.min is not None
            assert v.max is not None


CAPABILITIES = {
    2: (["canGetAndSetFMUstate", "canSerializeFMUstate"], ["providesDirectionalDerivative"]),
    3: (
        ["canGetAndSetFMUState", "canSerializeFMUState", "providesIntermediateUpdate",
         "canReturnEarlyAfterIntermediateUpdate"],
        ["providesDirectionalDerivatives", "providesAdjointDerivatives"],
    ),
}  # fmt: skip
"""By version: those of every FMU, and those of all but closed loops."""


@some_fmus
def test_capabilities_are_declared(exported, what, version):
    description = etree.fromstring(read(exported(what, version), "modelDescription.xml"))
    interface, (all_have, parts_have) = description.find("CoSimulation"), CAPABILITIES[version]
    wanted = [*all_have, *(parts_have if what != "closed-loop" else [])]
    for name in ("canHandleVariableCommunicationStepSize", *wanted):
        assert interface.get(name) == "true"
    assert interface.get("needsExecutionTool") in (None, "false")


@pytest.mark.parametrize(
    "what, version", [("plant", 3), ("nn", 2), ("pid", 2), ("prox", 2), ("kanayama", 2)]
)
@pytest.mark.slow_but("plant-3", "nn-2")
def test_structure_is_the_jacobians(exported, what, version):
    """Outputs and rates name exactly the inputs and states that their derivative is not zero by."""
    description = read_model_description(str(exported(what, version)))
    system = system_of(what)
    by = list(system.inputs)
    unknowns = {
        name: expression
        for item in (*system.outputs, *system.diagnostics)
        for name, expression in zip(item.signal.elements, ca.vertsplit(item.expr), strict=True)
    }
    if what == "plant":
        by += system.state
        rates = zip(system.state, ca.vertsplit(system.update), strict=True)
        unknowns = {f"der({p.signal.name})": rate for p, rate in rates} | {"psi": unknowns["psi"]}
    knowns = [name for port in by for name in port.signal.elements]
    jacobian = ca.jacobian(
        ca.vertcat(*unknowns.values()), ca.vertcat(*(port.sym for port in by))
    ).sparsity()
    listed = {
        u.variable.name: [v.name for v in u.dependencies]
        for u in (*description.derivatives, *description.outputs)
    }
    for i, name in enumerate(unknowns):
        assert listed[name] == [known for j, known in enumerate(knowns) if jacobian.has_nz(i, j)]
    assert what == "plant" or set(listed) == set(unknowns)


@pytest.mark.slow
def test_weights_are_arrays_in_fmi3_and_flat_where_asked(exported, tmp_path):
    arrays = {v.name: v for v in read_model_description(str(exported("nn", 3))).modelVariables}
    assert int(arrays["W_hat1"].dimensions[0].start) == 64
    (flat,) = export_fmu("nn", fmi=3, out=tmp_path, arrays=False)
    names = {v.name for v in read_model_description(str(flat)).modelVariables}
    assert {"W_hat1[1]", "W_hat2[64]"} <= names
    assert validate_fmu(str(flat)) == []


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
    named = {k: posixpath.normpath(place + v.get("source")) for k, v in related.items()}
    names, *rows = [line.split(",") for line in read(path, named["result"]).decode().splitlines()]
    starts = read(path, named["parameter"]) if "parameter" in named else b"<none/>"
    values = {
        item.getparent().get("name"): float(item.get("value"))
        for item in etree.fromstring(starts).iter("{*}Real")
    }
    assert manifest.tag == "fmiReferences"
    assert bool(values) == (what == "plant")
    found = simulate_fmu(
        str(path), stop_time=0.1, step_size=0.01, output_interval=0.01, start_values=values,
        output=[name.strip('"') for name in names[1:]], fmi_type="CoSimulation",
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
