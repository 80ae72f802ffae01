"""Runs on the rigid body: the compiled loop up to the wheels, MuJoCo beyond them."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import TypeVar

import numpy as np

from wmr_ctrl.core.signals import RIGID as RIGID_COLUMNS
from wmr_ctrl.core.signals import elements
from wmr_ctrl.results import RigidMonitor, Run, RunTable, split_columns, table_of_rows, tracked
from wmr_ctrl.results.figures import FIGURES, RIGID, SUMMED, values_of
from wmr_ctrl.results.outcomes import STOP_REASONS
from wmr_ctrl.simulation.coupled import Coupled
from wmr_ctrl.simulation.figures import final_state
from wmr_ctrl.simulation.many import not_summed
from wmr_ctrl.simulation.memory import Task
from wmr_ctrl.simulation.runnable import RunnableLoop, assemble_run
from wmr_ctrl.world.scenario import Scenario
from wmr_ctrl.world.scenario.sections import Body, Initial

from .rigid import BodyMotion, RigidBody, mujoco
from .workers import Progress, make_each

T = TypeVar("T")
_ROWS_PER_REPORT = 100


def run_rigid(loop: RunnableLoop, seed: int, progress: Progress | None = None) -> Run:
    """One run of a loop from `codegen.build.build_plantless`; it ends if the robot tips over.

    Raises MissingExtraError, CompilerError, or ScenarioError for numbers impossible for a rigid
    body.
    """
    return run_to_end(loop, seed, progress)[0]


def run_to_end(
    loop: RunnableLoop, seed: int, progress: Progress | None = None
) -> tuple[Run, tuple[float, ...]]:
    """The Run, and its final state: x, y [m], theta [rad], v1 [m/s], omega [rad/s]."""
    scenario, layout = loop.scenario, loop.compiled.layout
    coupling, rows = Coupling(loop, seed), list[list[float]]()
    for k in range(scenario.clock.samples):
        if coupling.ended:
            break
        rows.append(coupling.sample())
        if progress is not None and (k + 1) % _ROWS_PER_REPORT == 0:
            progress((k + 1) / scenario.clock.samples)
    signals = (*layout.columns, *RIGID_COLUMNS)
    table = np.array(rows).reshape(len(rows), len(elements(signals)))
    monitor = replace(coupling.loop.monitor(), rigid=coupling.seen)
    logged = (signals, split_columns(signals, table), monitor)
    facts = {"kernel_hash": loop.compiled.digest, "mujoco": str(mujoco().__version__)}
    run = assemble_run(scenario, loop.law, seed, "native", logged, facts, loop.bounds, "mujoco")
    return run, coupling.body.now.plane_state[:5]


def run_rigid_each(
    runs: Sequence[tuple[RunnableLoop, int]],
    then: Callable[[int, Run], T],
    jobs: int | None = None,
    progress: Progress | None = None,
) -> list[T]:
    """Results of ``then`` for index and Run of each pair (loop, seed), as `sim.many.run_each`.

    On ``jobs`` processes (default: cores); the result is the same for any number of them.
    ``progress`` is called with the share done.  Errors as in `run_rigid`, and ArgumentError for
    jobs < 1.
    """
    finished = make_each(run_rigid, runs, jobs, progress)
    return [then(place, run) for place, run in enumerate(finished)]


class Coupling:
    """A compiled loop and a rigid body, sample by sample.

    ``ended``: whether the run must end; ``seen``: monitor of the body so far.
    """

    def __init__(self, loop: RunnableLoop, seed: int) -> None:
        self.limits, self.clock = loop.scenario.body, loop.scenario.clock
        self.body = RigidBody(loop.scenario)
        self.loop = Coupled(loop.compiled, seed, self.clock.plant)
        self._changes = dict(zip(loop.compiled.phase_start[1:], loop.scenario.changes, strict=True))
        self._row = len(elements(loop.compiled.layout.columns))
        self._reached = 0
        self.seen = watched(RigidMonitor(), self.body.now, self.limits, 0.0)
        self.ended = self.seen.tipped is not None or self.loop.ended

    def sample(self) -> list[float]:
        """Make a row of the log, then the steps of its period, at most to the run's end."""
        body, margin = self.body, self.body.tip_margin
        least = min(self.seen.least_tip_margin, margin)
        self.seen = replace(self.seen, least_tip_margin=least)
        now = body.now
        shown = self.loop.sampled(now.plane_state)
        held = shown[: -self._row]
        row = [*shown[-self._row :], *now.wheels, *now.slip, now.tilt, margin]
        for _ in range(self.clock.substeps):
            if self._reached in self._changes:
                body.change(self._changes[self._reached])
            body.step(self.loop.acting(held))
            self._reached += 1
            beyond = self.loop.ends(body.now.plane_state, self._reached)
            t = self._reached * self.clock.plant
            self.seen = watched(self.seen, body.now, self.limits, t)
            if self.seen.tipped is not None or beyond:
                self.ended = True
                break
        return row


def watched(seen: RigidMonitor, now: BodyMotion, limits: Body, t: float) -> RigidMonitor:
    """The monitor ``seen`` after a body's motion at t [s]."""
    slip = max(abs(now.slip[0]), abs(now.slip[1]))
    slips = seen.slipped is None and slip > limits.slip_max
    return RigidMonitor(
        tipped=t if now.tilt > limits.tilt_max else seen.tipped,
        slipped=t if slips else seen.slipped,
        max_slip=max(seen.max_slip, slip),
        max_wheel_speed=max(seen.max_wheel_speed, abs(now.wheels[0]), abs(now.wheels[1])),
        max_tilt=max(seen.max_tilt, now.tilt),
        least_tip_margin=seen.least_tip_margin,
    )


# -- figures of many runs ------------------------------------------------------------------------


def rigid_table(
    tasks: Sequence[Task],
    figures: Sequence[str] = (),
    jobs: int | None = None,
    progress: Progress | None = None,
    build: Callable[[Scenario], RunnableLoop] | None = None,
) -> RunTable:
    """The table of some runs, each made once for all of its figures; as `sim.many.tabulated`.

    ``jobs``: processes; ``build``: from a scenario to its loop without a plant, for tasks with a
    separate start.  Errors as in `run_rigid`.
    """
    pairs = []
    for task in tasks:
        loop, start = task.loop, task.start
        if build is not None and start is not None:
            begin = Initial(pose=(start[0], start[1], start[2]), velocity=(start[3], start[4]))
            loop = build(replace(loop.scenario, initial=begin))
        pairs.append((loop, task.seed))
    rows = make_each(partial(rigid_row, further=not_summed(figures)), pairs, jobs, progress)
    return table_of_rows(rows)


def rigid_row(loop: RunnableLoop, seed: int, further: Sequence[str] = ()) -> dict[str, object]:
    """Figures, outcome and ``tracked`` of a run; it counts as stopped if it has tipped over.

    ``further``: names of further figures of the catalogue.
    """
    run, end = run_to_end(loop, seed)
    asked = values_of(run, map(FIGURES.__getitem__, further))
    about = {"seed": seed, "outcome": run.outcome.value, "tracked": bool(tracked(run))}
    return {**about, **figures_from_run(run, end), **asked}


def figures_from_run(run: Run, end: tuple[float, ...]) -> dict[str, float | None]:
    """All numbers of `COLUMNS` of one run, and of its body; ``end`` is its last state, (5,).

    They equal those of `sim.many.tabulated` up to the rounding of sums.
    """
    seen = run.monitor
    row = values_of(run, (*SUMMED, *(RIGID if seen.rigid else ())))
    events = {"first": seen.first_violation, "stop": seen.stopped, "bounds": seen.bounds_left}
    row |= {f"{name}_axis": None if e is None else float(e[1]) for name, e in events.items()}
    row |= final_state(end, run.settings.frames)
    return row | {"samples": float(run.rows), "stop": float(STOP_REASONS.index(seen.stop_reason))}
