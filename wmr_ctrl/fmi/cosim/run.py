"""cosimulate: FMUs in the loop, and the Run that they give."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path

import casadi as ca
import numpy as np

from wmr_ctrl.control.controller import watched_controller
from wmr_ctrl.control.setup import Setup, one_period_later, settle
from wmr_ctrl.errors import ArgumentError, UnknownNameError
from wmr_ctrl.fmi.blocks import parallel
from wmr_ctrl.fmi.cosim.fitting import check_parts, check_start, check_structure, law_within
from wmr_ctrl.fmi.cosim.mapping import PartMap, load_map
from wmr_ctrl.fmi.cosim.master import HEAD, MASTERS, Master, Parts, Progress
from wmr_ctrl.fmi.cosim.outside import Outside
from wmr_ctrl.fmi.cosim.parts import (
    NOISES,
    TORQUES,
    Part,
    controller_part,
    plant_part,
    reference_part,
)
from wmr_ctrl.fmi.cosim.slave import FmuError, Slave
from wmr_ctrl.fmi.export import model_of, scenario_given, write_fmu
from wmr_ctrl.fmi.model import FmuModel
from wmr_ctrl.fmi.targets import targets_of
from wmr_ctrl.fmi.variables import Role
from wmr_ctrl.laws.sample import own_diagnostics
from wmr_ctrl.model.system import System
from wmr_ctrl.model.tracking import tracking_error
from wmr_ctrl.results import Run
from wmr_ctrl.scenario import Change, Scenario
from wmr_ctrl.signals import LOG_HEAD, PSI, TRACKING_ERROR, Signal
from wmr_ctrl.sim.finish import checked_seeds, finished

CHANGEABLE = ("m", "I", "mu")


def cosimulate(
    scenario: str | Path | Scenario,
    law: str | None = None,
    *,
    plant: str | Path | None = None,
    controller: str | Path | None = None,
    map_file: str | Path | None = None,
    master: str = "gauss-seidel",
    delay_known: bool = False,
    seed: int = 0,
    fmi: int = 2,
    progress: Progress | None = None,
) -> Run:
    """Co-simulate reference, controller and plant FMUs through FMPy and return the Run.

    Parameters
    ----------
    law
        The control law; None: that of ``controller`` where it is one of ours, else "nn".
    plant, controller
        FMU files to use in place of those that are exported from ``scenario`` and ``law``.
    map_file
        TOML map of the names and units of FMUs that are not ours; see ``cosim.mapping``.
    master
        "gauss-seidel" (equals the native loop) or "jacobi" (the torque acts one step later).
    delay_known
        For "jacobi": the controller is built for drives that are one control period later than
        the scenario's, so that guard and observer count with what this master does; the loop is
        then the native one with that delay.
    fmi
        Version of the FMUs that are exported here: 2 or 3.

    Returns
    -------
    Run with engine "fmu", whose monitor saw every step of our plant; of a plant with a map, its
    communication steps.  Raises ArgumentError where an FMU cannot do what the scenario asks for,
    FmuError where it cannot be loaded; one that fails later ends the Run and is named by it.
    """
    if master not in MASTERS:
        raise UnknownNameError("master", master, MASTERS)
    if delay_known and master != "jacobi":
        raise ArgumentError(
            f"delay_known is for master = 'jacobi': under {master!r} no torque is late. Leave it "
            "out."
        )
    checked_seeds([seed])
    setup = settle(scenario_given(scenario), law or law_within(controller) or "nn")
    own = settle(one_period_later(setup.scenario), setup.name) if delay_known else setup
    maps = load_map(map_file) if map_file is not None else {}
    with tempfile.TemporaryDirectory(prefix="wmr_cosim_") as folder:
        files = {"reference": None, "controller": controller, "plant": plant}
        slaves = _slaves(own, files, fmi, Path(folder), at_once=master == "jacobi")
        try:
            return _run(setup, own, slaves, maps, master, seed, progress)
        finally:
            for slave in slaves.values():
                slave.end()


def _slaves(
    setup: Setup,
    files: dict[str, str | Path | None],
    fmi: int,
    folder: Path,
    *,
    at_once: bool,
) -> dict[str, Slave]:
    slaves: dict[str, Slave] = {}
    for name, given in files.items():
        path = Path(given) if given is not None else folder / f"{name}.fmu"
        if given is None:
            model = _model(setup, name, at_once=at_once)
            write_fmu(model, fmi, targets_of("host"), path, result=False)
        slaves[name] = Slave(path, name, folder / name)
    return slaves


def _model(setup: Setup, name: str, *, at_once: bool) -> FmuModel:
    what = setup.name if name == "controller" else name
    model = model_of(what, setup.name, setup.scenario)
    return parallel(model) if at_once else model


def _run(
    setup: Setup,
    own: Setup,
    slaves: dict[str, Slave],
    maps: dict[str, PartMap],
    master: str,
    seed: int,
    progress: Progress | None,
) -> Run:
    """``own`` is what the controller is built for, ``setup`` what stands around it."""
    scenario, system = setup.scenario, watched_controller(own)
    further = [name for item in system.diagnostics for name in item.signal.elements]
    outside = Outside(setup, seed)
    parts = Parts(
        reference_part(slaves["reference"]),
        controller_part(slaves["controller"], maps.get("controller"), further),
        plant_part(slaves["plant"], maps.get("plant"), scenario.robot, outside.rolling),
        _changer(scenario, slaves["plant"], maps.get("plant")),
    )
    check_parts(setup, parts.plant, parts.controller)
    for name, slave in slaves.items():
        ours = None if name in maps else _model(own, name, at_once=master == "jacobi")
        starts = maps[name].start if ours is None else _starts(ours, slave)
        slave.begin(scenario.clock.duration, starts)
    check_start(scenario, parts.plant)
    loop: Master = MASTERS[master](scenario, parts, outside)
    facts = {"master": master, **{f"fmu_{name}": slave.label for name, slave in slaves.items()}}
    facts |= {"delay": "known to the controller"} if own is not setup else {}
    controlled = slaves["controller"].description.modelName if "controller" in maps else setup.name

    failure = ""
    try:
        loop.run(progress)
    except FmuError as error:
        failure = str(error)
    return _result(own, controlled, system, loop, parts.controller, seed, facts, failure)


def _starts(model: FmuModel, slave: Slave) -> dict[str, float]:
    """The scenario's numbers for an FMU of ours that may come from another scenario."""
    check_structure(slave.path, model)
    return {
        v.name: v.start
        for v in model.variables
        if (v.parameter or v.role is Role.START) and not (v.array or v.integer)
    }


def _changer(scenario: Scenario, slave: Slave, part: PartMap | None) -> Callable[[Change], None]:
    """A function that changes the plant's parameters; refused where its map has no name for one."""
    names = {
        f"robot.{key}"
        for c in scenario.changes
        for key in CHANGEABLE
        if getattr(c, key) is not None
    }
    known = {name: name for name in names} if part is None else dict(part.parameters)
    missing = sorted(names - known.keys())
    if missing:
        raise ArgumentError(
            f"the scenario changes {', '.join(missing)}, and the map's [plant.parameters] has no "
            f'name for it. Add "{missing[0]}" = "their name", or take a scenario without changes.'
        )

    def change(what: Change) -> None:
        values = {key: getattr(what, key) for key in CHANGEABLE}
        slave.set(
            {known[f"robot.{key}"]: value for key, value in values.items() if value is not None}
        )

    return change


def _result(
    setup: Setup,
    law: str,
    system: System,
    loop: Master,
    part: Part,
    seed: int,
    facts: dict[str, str],
    failure: str,
) -> Run:
    effects = loop.outside.columns
    signals = (*LOG_HEAD, *own_diagnostics(system), *effects)
    named = tuple(name for item in effects for name in item.elements)
    table = _table(loop, (*HEAD, *TORQUES, *NOISES, *named, *part.targets[2:]))
    logged = (signals, _columns(signals, table), loop.outside.monitor(failure))
    scenario = loop.scenario
    return finished(scenario, law, seed, "fmu", logged, facts, setup.assumptions)


def _table(loop: Master, names: Sequence[str]) -> dict[str, np.ndarray]:
    """Columns by element name, with heading and tracking error of the true pose."""
    rows = np.array(loop.rows, dtype=float).reshape(len(loop.rows), len(names))
    table = {name: rows[:, i] for i, name in enumerate(names)}
    table[PSI.name] = table["theta"] + np.pi / 2
    errors = np.asarray(_error()(rows[:, 6:9].T, rows[:, 1:4].T))
    return table | {name: errors[i] for i, name in enumerate(TRACKING_ERROR.elements)}


@cache
def _error() -> ca.Function:
    """The tracking error of poses side by side."""
    desired, pose = ca.SX.sym("desired", 3), ca.SX.sym("pose", 3)
    return ca.Function("e", [desired, pose], [tracking_error(desired, pose)])


def _columns(signals: Sequence[Signal], table: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Columns by signal; what a foreign controller does not publish is not a number."""
    nothing = np.full(len(table["t"]), np.nan)
    return {
        s.name: table.get(s.name, nothing)
        if s.size == 1
        else np.column_stack([table.get(name, nothing) for name in s.elements])
        for s in signals
    }
