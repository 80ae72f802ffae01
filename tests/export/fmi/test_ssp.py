"""The SSP package in both forms, read and run by tools that are not ours."""

import json
import sys
import xml.etree.ElementTree as ET
import zipfile

import numpy as np
import pytest
from click.testing import CliRunner
from fmpy.ssp.simulation import simulate_ssp
from fmpy.ssp.ssd import read_ssd

from tests.commands import finished
from wmr_ctrl.cli.root import root
from wmr_ctrl.export.cosim.mapping import MapRow
from wmr_ctrl.export.fmi.ssp import INNER, ORDER, SET, Component, _structure, export_ssp
from wmr_ctrl.world.scenario import load_scenario, override

SHORT = load_scenario("paper-simulation-nominal", {"clock.duration": 3.0})
STATE = ("x", "y", "theta", "v1", "omega")
SHOWN = [("plant", name) for name in STATE] + [
    ("controller", "tau_right"),
    ("controller", "margin"),
]
NAMES = {
    "ssd": "http://ssp-standard.org/SSP1/SystemStructureDescription",
    "ssc": "http://ssp-standard.org/SSP1/SystemStructureCommon",
    "oms": "https://raw.githubusercontent.com/OpenModelica/OMSimulator/master/schema/oms.xsd",
    "osp": "http://opensimulationplatform.com/SSP/OSPAnnotations",
}
LIBCOSIM = """
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimObserver import CosimObserver
execution = CosimExecution.from_ssp_file(ssp_path=plan["package"])
seen = CosimObserver.create_last_value()
execution.add_observer(observer=seen)
places = {item.name.decode(): item.index for item in execution.slave_infos()}
refs = {name: {item.name.decode(): item.reference for item in execution.slave_variables(place)}
        for name, place in places.items()}
for _ in range(plan["steps"]):
    assert execution.step(step_count=1)
    show([seen.last_real_values(slave_index=places[part], variable_references=[refs[part][name]])[0]
          for part, name in plan["shown"]])
"""
ECOS = """
from ecospy import EcosSimulation
with EcosSimulation(step_size=plan["h"], ssp_path=plan["package"]) as simulation:
    simulation.init(parameter_set=plan["set"])
    for _ in range(plan["steps"]):
        simulation.step()
        show([simulation.get_real(f"{part}::{name}") for part, name in plan["shown"]])
    simulation.terminate()
"""
COMMON = """
import json, sys
plan = json.loads(sys.stdin.read())
def show(row): print("ROW", *map(float.hex, row))
"""


@pytest.fixture
def flat(tmp_path):
    """A function: law -> its flat package on 3 s of the paper's circle."""

    def export(law, scenario=SHORT):
        return export_ssp(law=law, scenario=scenario, flat=True, out=tmp_path)[0]

    return export


def described(path):
    """The system's structure."""
    with zipfile.ZipFile(path) as archive:
        return ET.fromstring(archive.read("SystemStructure.ssd"))


@pytest.mark.slow
def test_a_flat_package_runs_alike_in_parallel_masters(flat):
    """These masters pass values before the first step, unlike FMPy; libcosim receives no step
    size.
    """
    path, rows = str(flat("nn")), []
    plan = {"package": path, "steps": 300, "h": 0.01, "set": SET, "shown": SHOWN}
    for module, script in (("libcosimpy", LIBCOSIM), ("ecospy", ECOS)):
        try:
            __import__(module)
        except (ImportError, OSError) as error:  # a library that it is linked with may be missing
            pytest.skip(f"NOT RUN: {module}: {error}")
        # Another process, since they write to stdout.
        done = finished([sys.executable, "-c", COMMON + script], input=json.dumps(plan))
        rows.append([line.split()[1:] for line in done.stdout.splitlines() if "ROW" in line])
    x = [float.fromhex(row[0]) for row in rows[0]]
    near = simulate_ssp(path, stop_time=2.995, step_size=0.01)["plant.x"]

    assert rows[0] == rows[1]
    assert np.abs(np.subtract(x[:-1], near[1:])).max() < 1e-2 < np.ptp(x)


def test_a_flat_package_names_parts_and_nothing_else(flat):
    path = flat("mb")
    assert read_ssd(str(path), validate=True) is not None
    system = described(path).find("ssd:System", NAMES)
    connections = system.findall(".//ssd:Connection", NAMES)
    assert tuple(part.get("name") for part in system.iterfind(".//ssd:Component", NAMES)) == ORDER
    assert len(connections) == 14
    assert all(set(INNER) <= set(line.attrib) for line in connections)
    assert system.find("ssd:Connectors", NAMES) is None


def test_a_connection_converts_by_the_row_that_gives_and_then_by_the_row_that_takes():
    """Their px becomes our x = 0.5 px + 2, which is passed on as pos = 10 x + 5; a renaming
    converts nothing.
    """
    rows = MapRow("x", (("px", 0.5),), 2.0), MapRow("theta", (("th", 1.0),))
    taken = MapRow("pos", (("x", 10.0),), 5.0), MapRow("angle", (("theta", 1.0),))
    parts = {
        "controller": Component("ctl", b"", [], list(taken), [], []),
        "plant": Component("bot", b"", [], [], list(rows), []),
    }
    found = {}
    for line in ET.fromstring(_structure(parts, SHORT, False)).findall(".//{*}Connection"):
        change = line.find("{*}LinearTransformation")
        ends = (line.get("startElement"), line.get("startConnector"), line.get("endConnector"))
        numbers = () if change is None else (change.get("factor"), change.get("offset"))
        found[ends] = tuple(map(float, numbers))

    assert found == {
        ("plant", "px", "pos"): (5.0, 25.0), ("plant", "th", "angle"): (),
        ("plant", "px", "x"): (0.5, 2.0), ("plant", "th", "theta"): (),
    }  # fmt: skip


@pytest.mark.parametrize("row", ["theta", "psi"])
def test_an_export_says_where_a_connection_converts(exported, mapped, tmp_path, row):
    """FMPy reads conversions but does not apply them."""
    outputs = ", ".join(f'{row if name == "theta" else name} = "{name}"' for name in STATE)
    inputs = 'tau_right = "tau_right", tau_left = "tau_left"'
    file = mapped(f"[plant]\ninputs = {{ {inputs} }}\noutputs = {{ {outputs} }}\n")
    words = f"export ssp --law pid --scenario paper-simulation-nominal --out {tmp_path / 'package'}"
    given = ("--plant", str(exported("plant", 2)), "--map", str(file))
    done = CliRunner().invoke(root, [*words.split(), *given], env={"COLUMNS": "999"})

    assert done.exit_code == 0
    assert ("wmr.ssp: connections convert units" in done.stderr) == (row == "psi")


def test_a_package_tells_its_step_size(flat):
    """OMSimulator receives a weakly coupled system with a fixed step, libcosim a master."""
    path = flat("pid", override(SHORT, {"clock.control": 0.02}))
    assert read_ssd(str(path), validate=True) is not None
    about = described(path)
    system = about.find("ssd:System/ssd:Annotations/ssc:Annotation", NAMES)
    solver = system.find("oms:Annotations/oms:SimulationInformation", NAMES)
    master = solver.find("oms:FixedStepMaster", NAMES)
    experiment = about.find("ssd:DefaultExperiment", NAMES)
    algorithm = experiment.find(".//osp:FixedStepAlgorithm", NAMES)

    assert (system.attrib["type"], experiment.attrib["stopTime"]) == ("org.openmodelica", "3.0")
    assert (solver.attrib["method"], master.attrib["description"]) == ("oms_ma", "oms-ma")
    sizes = solver.get("fixedStepSize"), master.get("stepSize"), algorithm.get("baseStepSize")
    assert [*map(float, sizes)] == [0.02] * 3
