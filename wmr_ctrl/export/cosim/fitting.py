"""Checks before the first step: parts of a scenario that the given FMUs cannot provide."""

import zipfile
from collections.abc import Mapping
from pathlib import Path

from wmr_ctrl.codegen.build import first_step_at
from wmr_ctrl.control.applied import remembered
from wmr_ctrl.control.controller import law_graph
from wmr_ctrl.control.laws import LAWS
from wmr_ctrl.control.outside import check_outside_plant
from wmr_ctrl.control.setup import Setup, settle
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.core.signals import SENT_BEFORE, TAU_APPLIED
from wmr_ctrl.export.fmi.blocks import law_model
from wmr_ctrl.export.fmi.extra import GRAPH
from wmr_ctrl.export.fmi.model_description import FmuModel
from wmr_ctrl.world.effect import EffectRole
from wmr_ctrl.world.scenario import Scenario, override
from wmr_ctrl.world.scenario.unstated import unknown_keys

from .mapping import COMMANDED, DISTURBED, READY, STATE, TORQUES, WHEELS, PartMap
from .parts import Part
from .slave import Slave

_REACHING = {
    "noise_right": {"noise_right", "torque_right"},
    "noise_left": {"noise_left", "torque_left"},
    "thrust": {"thrust"},
    "moment": {"moment"},
}
"""Inputs of a plant by what a disturbance writes: one of them must be mapped."""
ROLLING = ("robot.r", "robot.l")
"""Sizes by which speeds of wheels are those of the robot."""
_NEAR = 1e-6
"""Largest distance of a foreign plant's start from the scenario's [m, rad, m/s, rad/s]."""


def law_within(path: str | Path | None) -> str | None:
    """Law of one of our controllers; None for any other file, or for None."""
    if path is None or not zipfile.is_zipfile(path):
        return None
    with zipfile.ZipFile(path) as archive:
        if GRAPH not in archive.namelist():
            return None
        described = archive.read("modelDescription.xml").decode(errors="replace")
    return next((law for law in LAWS if f'modelName="wmr_{law}"' in described), None)


def check_structure(slave: Slave, model: FmuModel) -> None:
    """Raise ArgumentError unless the FMU equals ``model`` except for its numbers.

    Our FMUs contain their graph; numbers are set before a run, but guard, drives and options of a
    law are part of the graph.
    """
    path, graph = slave.path, _graph_in(slave.path)
    if not graph:
        raise ArgumentError(
            f"the FMU {path} is not one of ours. Give a map of its names and units (--map "
            "FILE.toml)."
        )
    if graph != model.graph:
        raise ArgumentError(
            f"the FMU {path} ({slave.description.modelName}) is not the {model.what} of this "
            "scenario: they differ in more than numbers (the law or its options, guard, drives), "
            "or another version made it. Export it from this scenario, or leave it out."
        )


def unguarded(path: str | Path, setup: Setup) -> Setup | None:
    """The setup of one of our controllers that was made without the guard or filter of ``setup``.

    None if it has that part, or is foreign.  Raises ArgumentError for a law that remembers its
    commands, since an external guard or filter changes them without its knowledge.
    """
    velocity = setup.takes_velocity
    off: dict[str, object] = {"filter.kind": "none"} if velocity else {"guard.enabled": False}
    bare = settle(override(setup.scenario, off), setup.name)
    if _graph_in(path) != law_model(bare).graph:
        return None
    law = law_graph(bare)
    relies = any(item.signal in (SENT_BEFORE, TAU_APPLIED) for item in law.inputs)
    if remembered(law) or relies or (velocity and setup.control_law.traits.integrates):
        what, where = ("velocity", "filter") if velocity else ("torque", "guard")
        raise ArgumentError(
            f"{path} contains no {where}, and {setup.name} relies on the {what} that it commanded, "
            f"which a {where} outside it would change. Export it with the {where}, or leave it out."
        )
    return bare


def _graph_in(path: str | Path) -> str:
    """The graph that one of our FMUs was made from; empty for foreign ones."""
    with zipfile.ZipFile(path) as archive:
        return archive.read(GRAPH).decode() if GRAPH in archive.namelist() else ""


def check_told(setup: Setup) -> None:
    """Raise ArgumentError for a loop that needs a measurement or action of our own loop."""
    check_outside_plant(setup)
    filtered = setup.scenario.filter
    if setup.takes_velocity and filtered.is_told and filtered.free_error is not None:
        raise ArgumentError(
            "filter.free_error: nothing in a co-simulation measures free distances, without which "
            "the filter lets no command pass. Leave it out, or run the scenario natively."
        )


def check_parts(setup: Setup, plant: Part) -> None:
    """Raise ArgumentError if a foreign plant replaces a part of the scenario."""
    scenario = setup.scenario
    if plant.is_base and not setup.takes_velocity:
        raise ArgumentError(
            f"the map gives velocities to {plant.slave.path}, and the scenario's robot takes "
            "torques. Map torque_right and torque_left, or take a scenario with base.kind = "
            '"velocity".'
        )
    if not plant.is_base and plant.uses.isdisjoint((*TORQUES, *DISTURBED)):
        raise ArgumentError(
            f"the map's [plant.inputs] gives {plant.slave.path} no command. Add rows for "
            f"{', '.join((*COMMANDED * setup.takes_velocity, *TORQUES))}."
        )
    lost = [
        f"[{item.section.KEY}]"
        for item in setup.with_role(EffectRole.DISTURBANCE)
        if item.active(scenario)
        and any(
            plant.uses.isdisjoint(_REACHING[output.signal.name])
            for output in item.system(scenario).outputs
        )
    ]
    if lost:
        raise ArgumentError(
            f"the disturbance does not reach {plant.slave.path}. Map torque_right and torque_left, "
            "which include it (and thrust and moment, where it acts on the body), or remove it "
            f"from the scenario: {', '.join(lost)} (disturbance.std = 0)."
        )


def check_sizes(scenario: Scenario, plant: Part, maps: Mapping[str, PartMap]) -> None:
    """Raise ArgumentError if the map's quantities depend on unstated sizes of the robot."""
    given = {name for part in maps.values() for name in part.outputs}
    wheels = {*READY[1:], *WHEELS} & (given | plant.uses)
    torques = plant.foreign and not plant.is_base
    sizes = [k for k in unknown_keys(scenario) if torques or (wheels and k in ROLLING)]
    if sizes:
        raise ArgumentError(
            f"the map gives {', '.join(sorted(wheels)) or 'torques'}, which follow from "
            f"{', '.join(sizes)}, and nobody states them. State the robot's sizes, or map "
            "v_command and omega_command."
        )


def check_step(scenario: Scenario, part: Part) -> None:
    """Raise ArgumentError unless the map's step size of an FMU divides the control period."""
    step, period = part.step_size, scenario.clock.control
    if step is not None and not _divides(step, period):
        raise ArgumentError(
            f"the map's step of {part.slave.path}, {step:g} s, does not divide clock.control = "
            f"{period:g} s. Take {period / max(1, round(period / step)):.9g} s, or leave it out "
            "for one step a period."
        )


def check_spans(scenario: Scenario, plant: Part, steady: bool) -> None:
    """Raise ArgumentError if a plant would be stepped by less than its map's step size.

    ``steady``: its inputs are constant over a control period; else they may change every
    clock.plant.
    """
    step, pace, path = plant.step_size, scenario.clock.plant, plant.slave.path
    says = "whose map says"
    if step is None:
        if not plant.foreign or plant.slave.takes_any_step:
            return
        step, says = scenario.clock.control if steady else pace, "which takes steps of one size,"
    if not steady and not _divides(step, pace):
        raise ArgumentError(
            f"the map's step of {path}, {step:g} s, does not divide clock.plant = {pace:g} s, by "
            "which drives or disturbances of this scenario change what acts on the plant. Set "
            "clock.plant to a multiple of that step, or take out those drives (lag, delay, ...) "
            "and disturbances (slope, resistance)."
        )
    for change in scenario.changes:
        begins = first_step_at(change.t, pace) * pace
        if begins < scenario.clock.duration and not _divides(step, begins):
            raise ArgumentError(
                f"the change at t = {change.t:g} s falls between two steps of {path}, {says} "
                f"{step:g} s. Move it to a multiple of that step."
            )


def _divides(step: float, span: float) -> bool:
    """True if ``span`` [s] is a whole number of steps, up to rounding; 0 is none."""
    count = round(span / step)
    return abs(count * step - span) <= _NEAR * span and (count > 0 or span == 0)


def check_start(scenario: Scenario, plant: Part) -> None:
    """Raise ArgumentError unless an initialised foreign plant starts where the scenario does."""
    wanted = (*scenario.initial.pose, *scenario.initial.velocity)
    off = [
        f"{name} = {has:.9g}, not {want:.9g}"
        for name, want, has in zip(STATE, wanted, plant.read(), strict=False)
        if not abs(has - want) <= _NEAR * max(1.0, abs(want))
    ]
    if plant.foreign and off:
        raise ArgumentError(
            f"{plant.slave.path} does not start where the scenario does: {', '.join(off)}. Set "
            "the map's [plant.start], or initial.pose and initial.velocity."
        )
