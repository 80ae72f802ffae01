"""The SSP package in both forms, read and run by tools that are not ours."""

from __future__ import annotations

import importlib
import json
import sys
import xml.etree.ElementTree as ET
import zipfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from fmpy import read_model_description
from fmpy.ssp.simulation import simulate_ssp
from fmpy.ssp.ssd import read_ssd

from tests.commands import finished
from tests.export.fmi.together import step_together
from wmr_ctrl.cli.root import root
from wmr_ctrl.export.cosim.mapping import MapRow
from wmr_ctrl.export.fmi.ssp import INNER, ORDER, SET, Component, _structure, export_ssp
from wmr_ctrl.world.scenario import Scenario, load_scenario, override

SHORT = load_scenario("paper-simulation-nominal", {"clock.duration": 3.0})
SHOWN = (("plant", ("x", "y", "theta", "v1", "omega")), ("controller", ("tau_right", "margin")))
STATE = SHOWN[0][1]
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
for _ in range(plan["steps"]):
    assert execution.step(step_count=1)
    show([value for part, _, refs in plan["shown"] for value in
          seen.last_real_values(slave_index=places[part], variable_references=refs)])
"""
ECOS = """
from ecospy import EcosSimulation
with EcosSimulation(step_size=plan["h"], ssp_path=plan["package"]) as simulation:
    simulation.init(parameter_set=plan["set"])
    for _ in range(plan["steps"]):
        simulation.step()
        show([simulation.get_real(f"{part}::{name}")
              for part, names, _ in plan["shown"] for name in names])
    simulation.terminate()
"""
COMMON = """
import json, sys
plan = json.loads(sys.stdin.read())
def show(row): print("ROW", *map(float.hex, row))
"""


@dataclass(frozen=True)
class Package:
    """A flat package, unpacked: its file, parts, wires and what is shown, by references."""

    path: Path
    folder: Path
    scenario: Scenario

    @property
    def description(self):
        with zipfile.ZipFile(self.path) as archive:
            return ET.fromstring(archive.read("SystemStructure.ssd"))

    def parts(self):
        with zipfile.ZipFile(self.path) as archive:
            archive.extractall(self.folder)
        listed = self.description.iterfind(".//ssd:Component", NAMES)
        return {item.attrib["name"]: self.folder / item.attrib["source"] for item in listed}

    def references(self):
        described = {n: read_model_description(str(path)) for n, path in self.parts().items()}
        return {
            name: {v.name: v.valueReference for v in description.modelVariables}
            for name, description in described.items()
        }

    def wires(self):
        refs = self.references()
        ends = [[line.attrib[key] for key in INNER] for line in self.connections()]
        return [(giver, refs[giver][out], taker, refs[taker][into])
                for giver, out, taker, into in ends]  # fmt: skip

    def connections(self):
        return self.description.findall(".//ssd:Connection", NAMES)

    def shown(self):
        refs = self.references()
        return [(part, names, [refs[part][name] for name in names]) for part, names in SHOWN]

    def by_fmpys_slaves(self):
        shown = [(part, refs) for part, _, refs in self.shown()]
        steps = (self.scenario.clock.samples, self.scenario.clock.control)
        folder = self.folder / "unpacked"
        return step_together(self.parts(), self.wires(), shown, steps, folder)

    def by(self, script):
        """Rows that a script prints in a separate process: these libraries write to stdout."""
        clock = self.scenario.clock
        plan = {"package": str(self.path), "steps": clock.samples, "h": clock.control, "set": SET,
                "shown": self.shown()}  # fmt: skip
        done = finished([sys.executable, "-c", COMMON + script], input=json.dumps(plan))
        rows = [line.split()[1:] for line in done.stdout.splitlines() if line.startswith("ROW")]
        return np.array([[float.fromhex(word) for word in row] for row in rows])


@pytest.fixture
def flat(tmp_path):
    """A function: law -> its flat package on 3 s of the paper's circle."""

    def export(law, **options):
        (path,) = export_ssp(law=law, scenario=SHORT, flat=True, out=tmp_path, **options)
        return Package(path, tmp_path / "parts", SHORT)

    return export


def needs(module):
    """Skip where a library is not there, or one that it is linked with."""
    try:
        importlib.import_module(module)
    except (ImportError, OSError) as error:
        pytest.skip(f"NOT RUN: {module}: {error}")


@pytest.mark.parametrize(
    "law, module, script", [("nn", "libcosimpy", LIBCOSIM), ("prox", "ecospy", ECOS)],
    ids=["libcosimpy", "ecospy"],
)  # fmt: skip
@pytest.mark.slow
def test_a_flat_package_runs_in_parallel_masters(flat, law, module, script):
    """To the bit as FMPy's slaves that step all at once; libcosim is told no step size here."""
    needs(module)
    package = flat(law)
    found, wanted = package.by(script), package.by_fmpys_slaves()
    assert found.shape == (SHORT.clock.samples, sum(len(names) for _, names in SHOWN))
    assert np.abs(np.diff(found, axis=0)).max() > 0
    assert np.array_equal(found, wanted)


@pytest.mark.slow
def test_fmpy_runs_both_forms_alike(flat, tmp_path):
    (nested,) = export_ssp(law="nn", scenario=SHORT, out=tmp_path / "nested")
    one, other = (
        simulate_ssp(str(path), stop_time=0.995, step_size=SHORT.clock.control)
        for path in (nested, flat("nn").path)
    )
    assert "plant.noise_right" not in other.dtype.names
    assert len(other.dtype.names) > 30
    for name in other.dtype.names:
        assert np.array_equal(one[name], other[name]), name


def test_a_flat_package_names_parts_and_nothing_else(flat):
    package = flat("mb")
    assert read_ssd(str(package.path), validate=True) is not None
    assert tuple(package.parts()) == ORDER
    assert len(package.connections()) == 14
    for line in package.connections():
        assert set(INNER) <= set(line.attrib)
    system = package.description.find("ssd:System", NAMES)
    assert system.find("ssd:Connectors", NAMES) is None


def test_a_connection_converts_by_the_row_that_gives_and_then_by_the_row_that_takes():
    """Theirs px is ours by x = 0.5 px + 2, and is taken as pos = 10 x + 5; a renaming is none."""
    rows = MapRow("x", (("px", 0.5),), 2.0), MapRow("theta", (("th", 1.0),))
    taken = MapRow("pos", (("x", 10.0),), 5.0), MapRow("angle", (("theta", 1.0),))
    parts = {
        "controller": Component("ctl", b"", [], list(taken), [], []),
        "plant": Component("bot", b"", [], [], list(rows), []),
    }
    system = ET.fromstring(_structure(parts, SHORT, False).encode())
    found = {}
    for line in system.findall(".//{*}Connection"):
        change = line.find("{*}LinearTransformation")
        numbers = None if change is None else (change.get("factor"), change.get("offset"))
        ends = (line.get("startElement"), line.get("startConnector"), line.get("endConnector"))
        found[ends] = numbers and tuple(map(float, numbers))

    assert found == {
        ("plant", "px", "pos"): (5.0, 25.0), ("plant", "th", "angle"): None,
        ("plant", "px", "x"): (0.5, 2.0), ("plant", "th", "theta"): None,
    }  # fmt: skip


@pytest.mark.parametrize("row", ["theta", "psi"])
def test_an_export_says_where_a_connection_converts(exported, mapped, tmp_path, row):
    """FMPy reads conversions and does not do them."""
    names = {**{name: name for name in STATE}, row: "theta"}
    names.pop("theta" if row == "psi" else "psi", None)
    outputs = "\n".join(f'{ours} = "{theirs}"' for ours, theirs in names.items())
    inputs = 'tau_right = "tau_right"\ntau_left = "tau_left"'
    text = f"[plant.inputs]\n{inputs}\n[plant.outputs]\n{outputs}\n"
    given = ("--plant", str(exported("plant", 2)), "--map", str(mapped(text)), "--law", "pid")
    here = ("--scenario", "paper-simulation-nominal", "--out", str(tmp_path / "package"))
    done = CliRunner().invoke(root, ["export", "ssp", *given, *here], env={"COLUMNS": "999"})

    assert done.exit_code == 0
    assert ("wmr.ssp: connections convert units" in done.stderr) == (row == "psi")


@pytest.mark.parametrize("is_flat", [False, True])
@pytest.mark.slow_but("True")
def test_a_package_tells_its_step_size(tmp_path, is_flat):
    """OMSimulator is told of a weakly coupled system with a fixed step, libcosim of a master."""
    slower = override(SHORT, {"clock.control": 0.02})
    (path,) = export_ssp(law="pid", scenario=slower, flat=is_flat, out=tmp_path)
    assert read_ssd(str(path), validate=True) is not None
    about = Package(path, tmp_path, slower).description
    system = about.find("ssd:System/ssd:Annotations/ssc:Annotation", NAMES)
    assert system.attrib["type"] == "org.openmodelica"
    solver = system.find("oms:Annotations/oms:SimulationInformation", NAMES)
    master = solver.find("oms:FixedStepMaster", NAMES)
    assert (solver.attrib["method"], master.attrib["description"]) == ("oms_ma", "oms-ma")
    experiment = about.find("ssd:DefaultExperiment", NAMES)
    algorithm = experiment.find(".//osp:FixedStepAlgorithm", NAMES)
    assert experiment.attrib["stopTime"] == "3.0"
    assert [float(text) for text in (
        solver.attrib["fixedStepSize"], master.attrib["stepSize"], algorithm.attrib["baseStepSize"]
    )] == [0.02] * 3  # fmt: skip
