"""What an FMU says of itself: schemas, validation, units, structure, content."""

import math
import posixpath
import re
import zipfile
from pathlib import Path

import casadi as ca
import fmpy
import numpy as np
import pytest
from fmpy import read_model_description, simulate_fmu
from fmpy.validation import validate_fmu
from lxml import etree

from tests.export.fmi.cases import FMUS, SOME_FMUS
from wmr_ctrl.control.controller import asking_controller
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.signals import LARGEST, PLANT_STATE, TORQUE
from wmr_ctrl.export.fmi.fmu_files import export_fmu
from wmr_ctrl.export.fmi.model_description import Role, Variable, finite, input_rows, rate_rows
from wmr_ctrl.world.model.dynamics import plant
from wmr_ctrl.world.model.system import ports
from wmr_ctrl.world.scenario import load_scenario

SCHEMA = Path(fmpy.__file__).parent / "schema"
every_fmu = pytest.mark.parametrize("what, version", FMUS)
some_fmus = pytest.mark.parametrize("what, version", SOME_FMUS)


def parsed(path, name):
    with zipfile.ZipFile(path) as archive:
        return etree.fromstring(archive.read(name))


@pytest.mark.parametrize("what, version", [("plant", 2), ("closed-loop", 2), ("prox", 3)])
@pytest.mark.slow
def test_fmpy_finds_nothing_to_say(exported, what, version):
    assert validate_fmu(str(exported(what, version))) == []


@some_fmus
def test_xml_follows_the_official_schemas(exported, what, version):
    path = exported(what, version)
    files = {"modelDescription.xml": f"fmi{version}/fmi{version}ModelDescription.xsd"}
    if version == 3:
        files["sources/buildDescription.xml"] = "fmi3/fmi3BuildDescription.xsd"
    for name, schema in files.items():
        etree.XMLSchema(file=str(SCHEMA / schema)).assertValid(parsed(path, name))


@some_fmus
def test_every_quantity_is_documented_and_has_a_defined_unit(exported, what, version):
    path = exported(what, version)
    defined = {u.get("name") for u in parsed(path, "modelDescription.xml").iter("Unit")}
    for v in read_model_description(str(path)).modelVariables:
        assert v.description, v.name
        assert v.unit in defined or v.type in ("Integer", "Int64"), v.name
        if v.causality == "parameter":
            assert v.min is not None
            assert v.max is not None


@some_fmus
def test_capabilities_are_declared(exported, what, version):
    interface = parsed(exported(what, version), "modelDescription.xml").find("CoSimulation")
    wanted = {
        2: [
            "canGetAndSetFMUstate",
            "canSerializeFMUstate",
            "canHandleVariableCommunicationStepSize",
        ],
        3: [
            "canGetAndSetFMUState",
            "canSerializeFMUState",
            "canHandleVariableCommunicationStepSize",
            "providesIntermediateUpdate",
            "canReturnEarlyAfterIntermediateUpdate",
        ],
    }[version]
    if what != "closed-loop":
        wanted += {
            2: ["providesDirectionalDerivative"],
            3: ["providesDirectionalDerivatives", "providesAdjointDerivatives"],
        }[version]
    assert all(interface.get(name) == "true" for name in wanted)
    assert interface.get("needsExecutionTool") in (None, "false")


def test_structure_is_the_jacobians(exported):
    """Outputs and rates name exactly the inputs and states that their derivative is not zero by."""
    description = read_model_description(str(exported("plant", 3)))
    system = plant(load_scenario("paper-simulation"))
    knowns = [name for port in (*system.inputs, *system.state) for name in port.signal.elements]
    w = ca.vertcat(system.update, system.outputs[-1].expr)
    jacobian = ca.jacobian(w, ca.vertcat(system.u, system.x)).sparsity()
    listed = {
        u.variable.name: [v.name for v in u.dependencies]
        for u in (*description.derivatives, *description.outputs)
    }
    names = [*(f"der({p.signal.name})" for p in system.state), "psi"]
    for i, name in enumerate(names):
        assert listed[name] == [knowns[j] for j in range(len(knowns)) if jacobian.has_nz(i, j)]


@pytest.mark.parametrize("law", ["nn", "pid", "prox", "kanayama"])
@pytest.mark.slow_but("nn")
def test_structure_of_laws_is_the_jacobians(exported, law):
    description = read_model_description(str(exported(law, 2)))
    system = asking_controller(settle(load_scenario("paper-simulation"), law))
    inputs = [name for port in system.inputs for name in port.signal.elements]
    results = [*system.outputs, *system.diagnostics]
    rows = [name for item in results for name in item.signal.elements]
    jacobian = ca.jacobian(ca.vertcat(system.y, system.d), system.u).sparsity()
    listed = {u.variable.name: [v.name for v in u.dependencies] for u in description.outputs}
    assert listed == {
        name: [inputs[j] for j in range(len(inputs)) if jacobian.has_nz(i, j)]
        for i, name in enumerate(rows)
    }


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
    with zipfile.ZipFile(exported(what, version)) as archive:
        names = set(archive.namelist())
        assert "m = 65" in archive.read("extra/org.wmr-ctrl/scenario.toml").decode()
        assert {
            "documentation/index.html",
            "extra/org.wmr-ctrl/reference.csv",
            "sources/instance.c",
        } <= names
        assert not {n for n in names if n.endswith((".pdb", ".lib"))}
        if what != "closed-loop":
            assert archive.read("extra/org.wmr-ctrl/evaluate.casadi").isascii()


@pytest.mark.parametrize("what", ["plant", "nn", "closed-loop"])
def test_reference_result_is_reproduced(exported, what):
    path = exported(what, 2)
    with zipfile.ZipFile(path) as archive:
        text = archive.read("extra/org.wmr-ctrl/reference.csv").decode().splitlines()
    names = [name.strip('"') for name in text[0].split(",")]
    wanted = np.loadtxt(text[1:], delimiter=",")
    start = {"tau_right": 5.0, "tau_left": 4.5} if what == "plant" else {}
    found = simulate_fmu(
        str(path),
        stop_time=2.0,
        output_interval=0.01,
        step_size=0.01,
        start_values=start,
        output=names[1:],
    )
    assert np.array_equal(np.column_stack([found[n] for n in found.dtype.names]), wanted)


@every_fmu
def test_an_importer_can_check_itself_by_the_manifest(exported, what, version):
    """FMI-LS-REF names a result and the start values it was made with; both are there and agree."""
    path = exported(what, version)
    place = "extra/org.fmi-standard.fmi-ls-ref/"
    with zipfile.ZipFile(path) as archive:
        manifest = etree.fromstring(archive.read(f"{place}fmi-ls-manifest.xml"))
        named = {
            item.get("role"): posixpath.normpath(place + item.get("source"))
            for item in manifest.findall("Related")
        }
        assert set(named.values()) <= set(archive.namelist())
        rows = archive.read(named["result"]).decode().splitlines()
        starts = archive.read(named["parameter"]) if "parameter" in named else b"<none/>"
    assert manifest.tag == "fmiReferences"
    values = {
        item.getparent().get("name"): float(item.get("value"))
        for item in etree.fromstring(starts).iter("{*}Real")
    }
    assert bool(values) == (what == "plant")
    names = [name.strip('"') for name in rows[0].split(",")]
    found = simulate_fmu(
        str(path), stop_time=0.1, step_size=0.01, output_interval=0.01, start_values=values,
        output=names[1:], fmi_type="CoSimulation",
    )  # fmt: skip
    (told,) = (item.get("description") for item in manifest if item.get("role") == "result")
    seconds, step = map(float, re.findall(r"([\d.]+) s of .* in steps of ([\d.]+) s", told)[0])
    assert (float(rows[-1].split(",")[0]), float(rows[2].split(",")[0])) == (seconds, step)
    for row, line in zip(found, rows[1:12], strict=True):
        assert list(row) == [float(number) for number in line.split(",")]


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
