"""SSP package: reference, controller and plant, connected, with units and parameter sets.

Controller and plant may be foreign FMUs with a co-simulation map; its names and units become linear
transformations of connections.
"""

import tempfile
import zipfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import Any

from wmr_ctrl.control.given import law_of
from wmr_ctrl.control.outside import check_plain_loop, check_takes_torques
from wmr_ctrl.control.setup import Setup, one_period_later, settle
from wmr_ctrl.core import signals
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.core.fields.named_units import units_of
from wmr_ctrl.export.cosim import mapping
from wmr_ctrl.export.cosim.fmu_file import FmuFile
from wmr_ctrl.world.scenario import Scenario, title_of

from .blocks import parallel
from .files import render, write_archive
from .fmu_files import (
    TOOL,
    Progress,
    model_of,
    scenario_given,
    versions_of,
    write_fmu,
)
from .model_description import FmuModel, Role
from .targets import targets_of

MARGIN = next(signal for signal in signals.DIAGNOSTICS if signal.name == "margin")
SHOWN = {
    name: unit
    for signal in (*signals.PLANT_STATE, *signals.TORQUE, MARGIN, *signals.GUARD_DIAGNOSTICS)
    for name, unit in zip(signal.elements, signal.units, strict=True)
}
"""Outputs of the whole system, with units: its motion, and what the controller's monitor says."""
DISTURBANCE = {s.name: s.unit for s in (*signals.TORQUE_NOISE, *signals.BODY_FORCE)}
"""Inputs of the whole system, with units; zero where nobody connects them."""
ORDER = ("reference", "controller", "plant")
SAME_AS = {
    **dict(zip(signals.TAU_APPLIED.elements, (s.name for s in signals.TORQUE), strict=True)),
    "torque_right": signals.TORQUE[0].name,
    "torque_left": signals.TORQUE[1].name,
}
"""Quantities that are others here: torques act as they are commanded, and there is no noise."""
REALS = ("Real", "Float64")
INNER = ("startElement", "startConnector", "endElement", "endConnector")
"""Attributes of a connection between two parts; one to the whole system has three of them."""
SET = "scenario"
"""Name of every part's set of parameters: ecos takes the sets of one name."""
_NOT_IN = "without the scenario's noise and changes of the robot"


@dataclass(frozen=True)
class Component:
    """One FMU of the package: its file, ports, numbers, and the relation to our quantities.

    ``inputs`` and ``outputs``: rows between its connectors and our quantities.
    """

    identifier: str
    content: bytes
    ports: list[dict[str, str]]
    inputs: list[mapping.MapRow]
    outputs: list[mapping.MapRow]
    parameters: list[dict[str, str]]


def has_conversions(package: Path) -> bool:
    """True if a connection of an SSP package converts its values."""
    with zipfile.ZipFile(package) as archive:
        return b"<ssc:LinearTransformation" in archive.read("SystemStructure.ssd")


def export_ssp(
    *,
    law: str | None = None,
    scenario: str | Path | Scenario = "paper-simulation",
    fmi: str | int = "2",
    target: str = "host",
    out: str | Path = ".",
    plant: str | Path | None = None,
    controller: str | Path | None = None,
    map_file: str | Path | None = None,
    delay_known: bool = False,
    flat: bool = False,
    progress: Progress | None = None,
) -> list[Path]:
    """Write ``wmr.ssp`` into the folder ``out``: FMI 2.0 FMUs of reference, ``law`` and plant.

    ``fmi``: "2", or "both", which is 2 here: SSP 1.0 came before FMI 3. ``plant`` and
    ``controller`` are foreign FMUs in place of ours, with a map (``map_file``) as in co-simulation.
    ``flat``: without connectors of the system itself, which ecos and libcosim do not read, nor of
    unconnected inputs: disturbances are then set in the plant.

    The FMUs are set for masters that step all parts at once; docs/explanation/fmu.md says what
    their delay does to each law, and `cosimulate` for ``delay_known``. The package has no noise and
    no changes of the robot: those come from outside. Raises ArgumentError for FMI 3, for effects
    that it cannot contain, by name, and for rows of a map with several terms; FmuError,
    UnknownNameError, ScenarioError or CompilerError.
    """
    if 2 not in versions_of(fmi):
        raise ArgumentError(
            f"fmi = {fmi!r}: an SSP 1.0 package holds FMUs of FMI 2.0. Leave fmi out, or export "
            "the parts by themselves for FMI 3."
        )
    case = scenario_given(scenario)
    law = law_of(case, law)
    setup = settle(case, law)
    check_takes_torques(case, "an SSP package is written")
    check_plain_loop(setup, "an SSP package")
    own = one_period_later(setup) if delay_known else setup
    maps = mapping.load_map(map_file) if map_file is not None else {}
    given = {"controller": controller, "plant": plant}
    parts: dict[str, Component] = {}
    for name in ORDER:
        theirs = given.get(name)
        if theirs is not None:
            parts[name] = _theirs(name, theirs, maps.get(name), setup)
        else:
            law_setup, what = (own, law) if name == "controller" else (setup, name)
            parts[name] = _ours(parallel(model_of(what, law, law_setup.scenario)), target)
    files = {"SystemStructure.ssd": _structure(parts, setup.scenario, flat).encode()}
    for name, part in parts.items():
        units = units_of(filter(None, (item["unit"] for item in part.parameters)))
        text = render("parameters.ssv", name=SET, tool=TOOL, units=units, values=part.parameters)
        files[f"resources/{name}.ssv"] = text.encode()
        files[f"resources/{part.identifier}.fmu"] = part.content
    path = write_archive(Path(out) / "wmr.ssp", files)
    if progress:
        progress(f"{path}: {', '.join(part.identifier for part in parts.values())}, {target}")
    return [path]


def _ours(model: FmuModel, target: str) -> Component:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"{model.identifier}.fmu"
        content = write_fmu(model, 2, targets_of(target), path, result=False).read_bytes()
    joined = (v for v in model.variables if v.role is Role.INPUT or (v.output and not v.array))
    ports = [_port(v.name, "input" if v.role is Role.INPUT else "output", v.unit) for v in joined]
    numbers = (v for v in model.variables if v.parameter and not v.integer)
    parameters = [{"name": v.name, "value": repr(v.start), "unit": v.unit} for v in numbers]
    inputs, outputs = (
        mapping.identity([port["name"] for port in ports if port["kind"] == kind])
        for kind in ("input", "output")
    )
    return Component(model.identifier, content, ports, inputs, outputs, parameters)


def _theirs(name: str, path: str | Path, part: mapping.PartMap | None, setup: Setup) -> Component:
    """A foreign FMU with the map of its names and units."""
    if part is None:
        raise ArgumentError(
            f"{name} = {str(path)!r}: a package needs the map of its names and units, with a part "
            f"[{name}] (--map FILE.toml)."
        )
    if name == "controller" and setup.scenario.guard.enabled:
        raise ArgumentError(
            f"guard.enabled is true, but the guard is part of our controllers and not in {path}. "
            "Set guard.enabled = false."
        )
    file = FmuFile(path, name)
    inputs = mapping.input_rows(part, file.unit, name)
    ours = mapping.controller_outputs if name == "controller" else mapping.plant_outputs
    outputs = ours(part, file.unit, setup.scenario.robot)
    named = (*(row.target for row in inputs), *(key for row in outputs for key, _ in row.terms))
    reals = {key for key, variable in file.variables.items() if variable.type in REALS}
    for key in {*named, *part.start} - reals:
        raise ArgumentError(
            f"{name}: {key} is no real variable of {path}, and a package connects and sets only "
            "those. Map another one, or use cosim."
        )
    for row in (*inputs, *outputs):
        if len(row.terms) != 1:
            raise ArgumentError(
                f"{name}: {row.target} is a sum of {len(row.terms)} variables, and a connection of "
                "an SSP package carries one. Map variables that need no sum, or use cosim."
            )
    ports = [_port(row.target, "input") for row in inputs]
    ports += [_port(row.terms[0][0], "output") for row in outputs]
    start = [{"name": key, "value": repr(value), "unit": ""} for key, value in part.start.items()]
    return Component(Path(path).stem, Path(path).read_bytes(), ports, inputs, outputs, start)


def _port(name: str, kind: str, unit: str = "") -> dict[str, str]:
    return {"name": name, "kind": kind, "unit": unit}


def _structure(parts: dict[str, Component], scenario: Scenario, flat: bool) -> str:
    connections = list(_connections(parts))
    ports = {name: part.ports for name, part in parts.items()}
    if flat:
        connections = [line for line in connections if len(line["ends"]) == len(INNER)]
        ports = {name: _wired(name, part, connections) for name, part in parts.items()}
    used = {value for line in connections for _, value in line["ends"]}
    given = {row.target for part in parts.values() for row in part.outputs}
    outside = [  # inputs that a connection uses, outputs that a part gives
        *(_port(name, "input", unit) for name, unit in DISTURBANCE.items() if name in used),
        *(_port(name, "output", unit) for name, unit in SHOWN.items() if name in given),
    ]
    outside = [] if flat else outside
    units = [port["unit"] for port in (*chain(*ports.values()), *outside)]
    return render(
        "SystemStructure.ssd", tool=TOOL, title=f"{title_of(scenario) or scenario.name}; {_NOT_IN}",
        clock=scenario.clock, outside=outside, parts=parts, ports=ports, connections=connections,
        units=units_of(filter(None, units)),
    )  # fmt: skip


def _wired(name: str, part: Component, connections: list[dict[str, Any]]) -> list[dict[str, str]]:
    """Connectors of a part without its free inputs, to which FMPy 0.3.32 gives wrong values."""
    ends = [dict(line["ends"]) for line in connections]
    taken = {end["endConnector"] for end in ends if end["endElement"] == name}
    return [port for port in part.ports if port["kind"] == "output" or port["name"] in taken]


def _connections(parts: dict[str, Component]) -> Iterator[dict[str, Any]]:
    """Connections of each input to the source of its quantity, then the outputs of the whole."""
    owner = {row.target: (name, row) for name, part in parts.items() for row in part.outputs}
    for name, part in parts.items():
        for row in part.inputs:
            ours, factor = row.terms[0]
            end = [("endElement", name), ("endConnector", row.target)]
            quantity = SAME_AS.get(ours, ours)
            if quantity in DISTURBANCE:
                yield {
                    "ends": [("startConnector", quantity), *end],
                    "factor": factor,
                    "offset": row.offset,
                }
            else:
                yield _joined(owner, quantity, end, factor, row.offset)
    for shown in SHOWN:
        if shown in owner:
            yield _joined(owner, shown, [("endConnector", shown)], 1.0, 0.0)


def _joined(
    owner: Mapping[str, tuple[str, mapping.MapRow]],
    quantity: str,
    end: list[tuple[str, str]],
    factor: float,
    offset: float,
) -> dict[str, Any]:
    """Connection from the source of a quantity: its own conversion, then that of the end."""
    if quantity not in owner:
        raise ArgumentError(
            f"{end[-1][1]} needs {quantity}, which no part of the package gives. Map another "
            "quantity, or use cosim."
        )
    part, row = owner[quantity]
    theirs, share = row.terms[0]
    start = [("startElement", part), ("startConnector", theirs)]
    offset += factor * row.offset
    return {"ends": [*start, *end], "factor": factor * share, "offset": offset}
