"""cosimulate: FMUs in the loop, and the resulting Run."""

import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property
from pathlib import Path

import casadi as ca
import numpy as np

from wmr_ctrl.control.controller import watched_controller
from wmr_ctrl.control.given import law_of
from wmr_ctrl.control.laws.context import own_diagnostics
from wmr_ctrl.control.setup import Setup, one_period_later, settle
from wmr_ctrl.core import signals
from wmr_ctrl.core.errors import ArgumentError, ScenarioError, UnknownNameError
from wmr_ctrl.core.signals import elements
from wmr_ctrl.export.fmi.blocks import filter_model, guard_model, parallel
from wmr_ctrl.export.fmi.fmu_files import model_of, scenario_given, write_fmu
from wmr_ctrl.export.fmi.model_description import FmuModel, Role
from wmr_ctrl.export.fmi.targets import targets_of
from wmr_ctrl.results import Assumptions, Run
from wmr_ctrl.simulation.many import checked_seeds
from wmr_ctrl.simulation.runnable import assemble_run
from wmr_ctrl.world.model.kinematics import tracking_error
from wmr_ctrl.world.scenario import Change, Scenario

from . import fitting, parts
from .diverted import diverted
from .fmu_file import FmuError
from .mapping import COMMANDED, DESIRED, NOISES, TORQUES, MapRow, PartMap, load_map, parameter_rows
from .master import HEAD, MASTERS, Master, Outside, Parts, Progress
from .slave import Slave

UNTOLD = (
    "Under the master jacobi each torque acts one control period later than the guard is told, and "
    "the least disturbance counts that as a push."
)
UNFILTERED = (
    "Under the master jacobi each command acts one control period later than the filter is told. "
    "Its limits hold only where filter.delay counts that period, too: state it larger by "
    "clock.control, or step the parts in order (the master gauss-seidel)."
)
TELL = "Build the controller for it: --know-delay, or delay_known=True."
IN_ORDER = "No such delay is possible here: step the parts in order (the master gauss-seidel)."


@dataclass(frozen=True)
class CosimSetup:
    """FMUs of a co-simulation: given files, and the setups to export the others from.

    ``setup`` is that of the whole loop; ``own`` the one that our controller, guard or filter is
    built for; ``bare`` is ``setup`` without guard or filter, if that is a separate part after one
    of our controllers.  ``foreign``: the controller is foreign; ``files``: the given ones;
    ``maps``: those of foreign parts; ``at_once``: all parts step together.
    """

    setup: Setup
    own: Setup
    bare: Setup | None
    foreign: bool
    files: Mapping[str, str | Path | None]
    maps: Mapping[str, PartMap]
    at_once: bool

    @property
    def limiter(self) -> str:
        """The limiter that is a separate part: "guard", "filter" or "" for none."""
        scenario = self.setup.scenario
        if not self.foreign and self.bare is None:
            return ""
        if self.setup.takes_velocity:
            return "filter" if scenario.filter.kind != "none" else ""
        return "guard" if scenario.guard.enabled else ""

    @cached_property
    def diagnostics(self) -> tuple[signals.Signal, ...]:
        """Signals that the controller outputs beyond those of all laws."""
        if self.foreign:
            return parts.FILTERING if self.setup.takes_velocity else signals.GUARD_DIAGNOSTICS
        return own_diagnostics(watched_controller(self.own))

    @cached_property
    def models(self) -> Mapping[str, FmuModel]:
        """Our models by part, except for files with a map; made for the master.

        A guard steps directly after its controller, under either master.
        """
        setup = self.bare or self.own
        kinds = {"reference": "reference", "controller": setup.name, "plant": "plant"}
        models = {
            part: model_of(kind, setup.name, setup.scenario)
            for part, kind in kinds.items()
            if part not in self.maps or self.files.get(part) is None
        }
        if self.at_once:
            models = {part: parallel(model) for part, model in models.items()}
        limiters = {"guard": guard_model, "filter": lambda own: filter_model(own.scenario)}
        return models | {self.limiter: limiters[self.limiter](self.own)} if self.limiter else models


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
    compile_sources: bool = False,
    progress: Progress | None = None,
) -> Run:
    """Co-simulate reference, controller and plant FMUs through FMPy and return the Run.

    ``law``: None is that of ``controller`` if it is one of ours, else the scenario's own; it must
    be None with a foreign controller.  ``plant``, ``controller``: FMU files to use in place of
    those that are exported from ``scenario`` and ``law``, in version ``fmi`` (2 or 3).  With
    guard.enabled the guard is a further FMU after a foreign controller, and after one of ours that
    was exported without it; on a base that takes velocities the filter is.  ``map_file``: TOML map
    of the names and units of FMUs that are not ours, see ``cosim.mapping``.  ``compile_sources``:
    build the sources of an FMU that has no library for this machine.

    ``master``: "gauss-seidel" (equals the native loop) or "jacobi" (the torque acts one step
    later).  For the latter, with ``delay_known`` the controller is built for drives that are one
    control period later than the scenario's, so that guard and observer take this master's delay
    into account.  The loop is then the native one with that delay.

    What libraries print goes to standard error.

    The Run has engine "fmu". Its monitor saw every step of our plant, or the communication steps of
    a plant with a map.  Raises ArgumentError if an FMU cannot do what the scenario requires,
    FmuError if it cannot be loaded.  An FMU that fails later ends the Run, which names it.
    """
    if master not in MASTERS:
        raise UnknownNameError("master", master, MASTERS)
    if delay_known and master != "jacobi":
        raise ArgumentError(
            f"delay_known is for master = 'jacobi': under {master!r} no torque is delayed. Leave "
            "it out."
        )
    checked_seeds([seed])
    files = {"controller": controller, "plant": plant}
    if compile_sources and not any(files.values()):
        raise ArgumentError(
            "compile_sources builds the sources of a given FMU. Name a plant or a controller, or "
            "leave it out."
        )
    case = _cosim_setup(scenario, law, files, map_file, delay_known, at_once=master == "jacobi")
    with diverted(), tempfile.TemporaryDirectory(prefix="wmr_cosim_") as folder:
        slaves = _slaves(case, fmi, Path(folder), compile_sources)
        try:
            return _run(case, slaves, master, seed, progress)
        finally:
            for slave in slaves.values():
                slave.end()


def _cosim_setup(
    scenario: str | Path | Scenario,
    law: str | None,
    files: Mapping[str, str | Path | None],
    map_file: str | Path | None,
    delay_known: bool,
    *,
    at_once: bool,
) -> CosimSetup:
    controller = files["controller"]
    maps = load_map(map_file) if map_file is not None else {}
    idle = next((part for part in maps if files[part] is None), None)
    if idle is not None:
        raise ArgumentError(
            f"the map {map_file} has a part [{idle}], and no {idle} FMU is given. Name its file, "
            "or leave that part out of the map."
        )
    within = fitting.law_within(controller)
    theirs = controller is not None and within is None
    if theirs and law is not None:
        raise ArgumentError(
            f"law = {law!r} has no effect: the controller {controller} is a foreign FMU with a "
            "law of its own. Leave the law out."
        )
    case = scenario_given(scenario)
    setup = settle(case, law_of(case, law or within))
    fitting.check_told(setup)
    if delay_known and setup.takes_velocity:
        raise ArgumentError(
            "delay_known is for robots that take torques. On a base that takes velocities state "
            "base.delay and filter.delay larger by clock.control, or step the parts in order."
        )
    own = one_period_later(setup) if delay_known else setup
    foreign = theirs or "controller" in maps
    bare = None
    limited = setup.scenario.guard.enabled or setup.scenario.filter.kind != "none"
    if controller is not None and not foreign and limited:
        bare = fitting.unguarded(controller, setup)
    return CosimSetup(setup, own, bare, foreign, files, maps, at_once)


def _slaves(case: CosimSetup, fmi: int, folder: Path, compiled: bool) -> dict[str, Slave]:
    slaves: dict[str, Slave] = {}
    for name in filter(None, ("reference", "controller", case.limiter, "plant")):
        given = case.files.get(name)
        path = Path(given) if given is not None else folder / f"{name}.fmu"
        if given is None:
            write_fmu(case.models[name], fmi, targets_of("host"), path, result=False, level=0)
        ours = given is None
        slaves[name] = Slave(path, name, folder / name, ours=ours, compiled=compiled and not ours)
    return slaves


def _run(
    case: CosimSetup, slaves: dict[str, Slave], master: str, seed: int, progress: Progress | None
) -> Run:
    scenario, maps = case.setup.scenario, case.maps
    outside = Outside(case.setup, seed)
    coupled = Parts(
        parts.own_part(slaves["reference"], (), DESIRED),
        _controller(case, slaves),
        parts.plant_part(slaves["plant"], maps.get("plant"), scenario.robot, outside.rolling),
        _changer(scenario, slaves["plant"], maps.get("plant")),
    )
    fitting.check_parts(case.setup, coupled.plant)
    fitting.check_sizes(scenario, coupled.plant, maps)
    giver = coupled.controller
    for part in (coupled.plant, giver if isinstance(giver, parts.Part) else giver.controller):
        fitting.check_step(scenario, part)
    steady = outside.calm if coupled.plant.is_base else outside.steady
    fitting.check_spans(scenario, coupled.plant, steady)
    starts = {name: part.start for name, part in maps.items()}
    for name in slaves.keys() - maps.keys():
        # an FMU of ours that may come from another scenario gets this one's numbers
        fitting.check_structure(slaves[name], case.models[name])
        single = (v for v in case.models[name].variables if not (v.array or v.integer))
        given = (v for v in single if v.parameter or v.role is Role.START)
        starts[name] = {v.name: v.start for v in given}
    loop: Master = MASTERS[master](scenario, coupled, outside)
    facts = {"master": master, **{f"fmu_{name}": slave.label for name, slave in slaves.items()}}
    facts |= {"delay": "known to the controller"} if case.own is not case.setup else {}
    failure = ""
    try:
        for name, slave in slaves.items():
            slave.begin(scenario.clock.duration, starts[name])
        fitting.check_start(scenario, coupled.plant)
        loop.run(progress)
    except FmuError as error:
        failure = str(error)
    for name, slave in slaves.items():
        facts |= {f"{what}_{name}": told for what, told in slave.faults.items()}
    named = slaves["controller"].description.modelName
    law = named if case.foreign else case.setup.name
    sent = signals.COMMAND if case.setup.takes_velocity else ()
    further = (item for item in outside.columns if item not in signals.TORQUE)
    logged_signals = (*signals.LOG_HEAD, *case.diagnostics, *sent, *further)
    table = _table(loop, case.setup.commanded)
    logged = (logged_signals, _columns(logged_signals, table), outside.monitor(failure))
    run = assemble_run(scenario, law, seed, "fmu", logged, facts, _assumed(case))
    if not coupled.plant.foreign:
        return run
    return replace(run, settings=replace(run.settings, plant_kind="fmu", plant=loop.watched_every))


def _assumed(case: CosimSetup) -> Assumptions:
    """Assumptions of guard or filter; void if its outputs act later than it assumes."""
    assumed = case.own.assumptions
    if not case.at_once or case.own is not case.setup:
        return assumed
    if case.setup.takes_velocity:
        filtered = case.setup.scenario.filter.kind != "none"
        return replace(assumed, void=UNFILTERED if filtered else "")
    remedy = TELL
    try:
        one_period_later(case.setup)
    except ScenarioError:
        remedy = IN_ORDER
    return replace(assumed, void=" ".join(filter(None, (assumed.void, UNTOLD, remedy))))


def _controller(
    case: CosimSetup, slaves: Mapping[str, Slave]
) -> parts.Part | parts.GuardedController:
    """The controller, followed by the guard if that is a separate part."""
    names = elements((*signals.DIAGNOSTICS, *case.diagnostics))
    slave, robot = slaves["controller"], case.setup.scenario.robot
    asked = COMMANDED if case.setup.takes_velocity else TORQUES
    asked = signals.FORCE.elements if case.limiter == "guard" else asked
    part = parts.controller_part(slave, case.maps.get("controller"), robot, names, asked)
    if not case.limiter:
        return part
    behind, sources, shown = {
        "guard": (parts.GuardedController, parts.GUARDED, parts.GUARD_SHOWN),
        "filter": (parts.FilteredController, parts.FILTERED, parts.FILTER_SHOWN),
    }[case.limiter]
    return behind(part, parts.own_part(slaves[case.limiter], sources, shown))


def _changer(scenario: Scenario, slave: Slave, part: PartMap | None) -> Callable[[Change], None]:
    """Function that changes the plant's parameters; refused if its map lacks one of them."""
    names = sorted({f"robot.{key}" for change in scenario.changes for key in change.values()})
    rows = parameter_rows(part, slave.unit) if part is not None else {}
    missing = [name for name in names if name not in rows]
    if part is not None and missing:
        raise ArgumentError(
            f"the scenario changes {', '.join(missing)}, and the map's [plant.parameters] does "
            f'not name it. Add "{missing[0]}" = "name there", or use a scenario without changes.'
        )
    setters = {name: _setter(slave, rows.get(name, MapRow(name, ((name, 1.0),)))) for name in names}

    def change(what: Change) -> None:
        for key, value in what.values().items():
            setters[f"robot.{key}"](value)

    return change


def _setter(slave: Slave, row: MapRow) -> Callable[[float], None]:
    """Function that sets the foreign FMU's parameter that gives ``row.target``."""
    ((theirs, share),) = row.terms
    variable = slave.variable(theirs)
    if variable.causality not in ("parameter", "input") or variable.variability == "fixed":
        raise ArgumentError(
            f"the scenario changes {row.target}, and {theirs} of {slave.path} cannot be set during "
            f"a run (it is a {variable.variability} {variable.causality}). Name a tunable "
            "parameter or an input, or use a scenario without changes."
        )
    write = slave.writer([theirs])
    return lambda value: write([(value - row.offset) / share])


def _table(loop: Master, commanded: Sequence[signals.Signal]) -> dict[str, np.ndarray]:
    """Columns by element name, with heading and tracking error of the true pose."""
    effects, further = elements(loop.outside.columns), loop.parts.controller.targets[2:]
    names = (*HEAD, *elements(commanded), *NOISES, *effects, *further)
    rows = np.array(loop.rows, dtype=float).reshape(len(loop.rows), len(names))
    table = {name: rows[:, i] for i, name in enumerate(names)}
    table[signals.PSI.name] = table["theta"] + np.pi / 2
    if loop.parts.plant.is_base:  # its torques are its own
        table |= dict.fromkeys(TORQUES, np.full(len(rows), np.nan))
    errors = np.zeros((3, 0))
    if len(rows):
        errors = np.asarray(_error()(rows[:, 6:9].T, rows[:, 1:4].T))
    return table | {name: errors[i] for i, name in enumerate(signals.TRACKING_ERROR.elements)}


@cache
def _error() -> ca.Function:
    """Graph of the tracking errors of several poses."""
    desired, pose = ca.SX.sym("desired", 3), ca.SX.sym("pose", 3)
    return ca.Function("e", [desired, pose], [tracking_error(desired, pose)])


def _columns(
    listed: Sequence[signals.Signal], table: dict[str, np.ndarray]
) -> dict[str, np.ndarray]:
    """Columns by signal; signals that a foreign controller does not output are NaN."""
    nothing = np.full(len(table["t"]), np.nan)
    rows = {s.name: [table.get(name, nothing) for name in s.elements] for s in listed}
    return {name: np.column_stack(row) if len(row) > 1 else row[0] for name, row in rows.items()}
