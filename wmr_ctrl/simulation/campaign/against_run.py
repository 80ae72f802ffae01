"""Compare the linear loop with compiled runs from many starts: sizes at which they differ.

The deviation of a start is the weighted RMS, over the horizon, of the difference between the linear
response and the run's, divided by that of the linear response.  The run's response is its tracking
error less that of the run from the reference with the same noise; the angle error is multiplied by
half the track, so that the three elements are displacements of the wheels [m].
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import cast

import numpy as np

from wmr_ctrl.core.errors import ArgumentError, WmrError
from wmr_ctrl.core.fields.orientation import inward
from wmr_ctrl.core.late_bound import late_bound
from wmr_ctrl.core.signals import PLANT_STATE, places
from wmr_ctrl.results import Floats, Monitor, json_safe
from wmr_ctrl.simulation.batch import run_logged
from wmr_ctrl.simulation.memory import Task, laid_out
from wmr_ctrl.simulation.runnable import RunnableLoop
from wmr_ctrl.theory.checks.error_coordinates import POSE
from wmr_ctrl.theory.checks.surroundings import lost_samples, rounded_effects
from wmr_ctrl.theory.linear.answer import (
    linear_answer,
    moved_along,
    operating_point,
    start_off,
    tracking_errors,
)
from wmr_ctrl.theory.linear.linearise import Point, law_loop
from wmr_ctrl.theory.linear.state_space import constant_speed
from wmr_ctrl.world.references import sample
from wmr_ctrl.world.scenario import Scenario, override

Progress = Callable[[float], None]
DIRECTIONS: Mapping[str, tuple[float, float, float]] = {
    "ahead": (1.0, 0.0, 0.0), "behind": (-1.0, 0.0, 0.0), "left": (0.0, 1.0, 0.0),
    "right": (0.0, -1.0, 0.0), "turned left": (0.0, 0.0, 1.0), "turned right": (0.0, 0.0, -1.0),
}  # fmt: skip
"""Where the reference is at t = 0, as seen from the robot."""
HORIZON = 20.0
"""Seconds of the answers, unless the run is shorter or a change of the robot comes earlier."""
SETTLED = 5.0
"""Seconds on the reference after which base and drives are taken as settled."""
GROWN = 10.0
"""An unstable linear loop is followed until its answer has grown so many times."""
LEVELS = {"one_per_cent": 0.01, "ten_per_cent": 0.1}
SMALLEST = 1e-4
"""Smallest size that is tried [m or rad]."""
FARTHEST = 5.0
"""Largest size that is tried [m]."""
WIDEST = 3.0
"""Largest size that is tried [rad]."""
COARSE, FINE, ROUNDS = 28, 6, 2


@dataclass(frozen=True)
class Parting:
    """One direction: deviations by size, and an example.

    ``sizes`` (N) in ``unit``; ``one_per_cent`` and ``ten_per_cent``: the size above which the
    deviation is larger, None if there is none, with the ``reason``.  ``linear`` and ``run``
    (samples, 3): both responses [m, m, rad] from the start of size ``shown``.
    """

    unit: str
    sizes: Floats
    deviations: Floats
    one_per_cent: float | None
    ten_per_cent: float | None
    reason: str | None
    shown: float
    linear: Floats
    run: Floats


@dataclass(frozen=True)
class LawAgainstRun:
    """One law: the horizon and the period [s], remarks, and a Parting for each direction."""

    law: str
    seconds: float
    period: float
    remarks: tuple[str, ...]
    directions: Mapping[str, Parting]


@dataclass(frozen=True)
class AgainstRun:
    """Linear loops compared with runs on one scenario; ``refused``: reasons by law."""

    scenario: str
    laws: Mapping[str, LawAgainstRun]
    refused: Mapping[str, str]

    def to_json(self) -> dict[str, object]:
        """Sizes by law and direction: one_per_cent, ten_per_cent, unit, reason."""
        names = (*LEVELS, "unit", "reason")
        found: dict[str, object] = {
            law: {
                way: {name: json_safe(vars(item)[name]) for name in names}
                for way, item in each.directions.items()
            }
            for law, each in self.laws.items()
        }
        return {**found, **{law: {"refused": text} for law, text in self.refused.items()}}

    def table(self) -> str:
        """The sizes as a text table."""
        lines = [f"{'law':10}{'reference is':14}{'1 %':>10}{'10 %':>10}"]
        for law, each in self.laws.items():
            for way, item in each.directions.items():
                sizes = (item.one_per_cent, item.ten_per_cent)
                shown = "".join(f"{'-' if size is None else f'{size:.3g}':>10}" for size in sizes)
                lines.append(f"{law:10}{way:14}{shown} {item.unit:4} {item.reason or ''}".rstrip())
        for law, each in self.laws.items():
            lines += [f"{law}: {text}" for text in each.remarks]
        lines += [f"{law}: {text}" for law, text in self.refused.items()]
        return "\n".join(lines)

    def plot(self, path: str | Path) -> Path:
        """Draw both responses and the deviations into one picture; returns its path."""
        return cast("Path", late_bound("draw_against_run")(self, Path(path)))


def against_run(
    build: Callable[[Scenario, str], RunnableLoop],
    scenario: Scenario,
    laws: Sequence[str],
    jobs: int | None = None,
    progress: Progress | None = None,
) -> AgainstRun:
    """Compare linear loop and run for each law; ``build`` compiles a loop.

    The error of a refused law is raised if it is the only one.
    """
    found, refused = dict[str, LawAgainstRun](), dict[str, str]()
    for k, law in enumerate(laws):
        if progress:
            progress(k / len(laws))
        try:
            found[law] = _of_law(build, scenario, law, jobs)
        except WmrError as error:
            if len(laws) == 1:
                raise
            refused[law] = str(error)
    return AgainstRun(scenario.name, found, refused)


def _of_law(
    build: Callable[[Scenario, str], RunnableLoop], scenario: Scenario, law: str, jobs: int | None
) -> LawAgainstRun:
    period = scenario.clock.control
    first = min((item.t for item in scenario.changes if item.t > 0), default=np.inf)
    wanted = min(HORIZON, scenario.clock.duration, first)
    samples = max(2, int(wanted / period + 1e-9))
    at = operating_point(scenario, law)
    linear = linear_answer(scenario, law, at, samples)
    weights, remarks = np.array((1.0, 1.0, scenario.robot.l)), _remarks(scenario)
    grown = np.linalg.norm(linear * weights[:, None] / weights, axis=(1, 2))
    if (beyond := grown > GROWN * grown[0]).any():
        samples = max(2, int(beyond.argmax()))
        remarks += (f"the linear loop is unstable: followed for {samples * period:.3g} s",)
    runs = _Runs(build, scenario, law, at, samples, jobs)
    directions = {
        way: _parting(runs, np.array(vector), linear[:samples] @ np.array(vector), weights)
        for way, vector in DIRECTIONS.items()
    }
    return LawAgainstRun(law, samples * period, period, remarks, directions)


def _remarks(scenario: Scenario) -> tuple[str, ...]:
    """Sentences on effects that the linear loop neglects."""
    guard = "without the guard, which is on in the run" if scenario.guard.enabled else ""
    late = scenario.takes_velocity and scenario.base.delay > 0
    waits = "without the start's wait, in which no command has come and the base slows"
    said = (lost_samples(scenario), rounded_effects(scenario), guard, waits * late)
    return tuple(f"the linear loop is {text}" for text in said if text)


def _parting(runs: _Runs, vector: Floats, linear: Floats, weights: Floats) -> Parting:
    """Runs of growing size in one direction, then more of them near each level."""
    unit, largest = ("rad", WIDEST) if vector[2] else ("m", FARTHEST)
    whole, apart = np.linalg.norm(linear * weights), dict[float, float]()
    answers = dict[float, Floats | None]()
    sizes = [SMALLEST, *np.geomspace(SMALLEST, largest, COARSE)[1:].tolist()]
    for _ in range(ROUNDS + 1):
        made = runs.answers([size * vector for size in sizes])
        for size, answer in zip(sizes, made, strict=True):
            off = np.inf if answer is None else np.linalg.norm((answer - size * linear) * weights)
            apart[size], answers[size] = float(off / (size * whole)), answer
        ends = [_passed(apart, level) for level in LEVELS.values()]
        pairs = [(low, high) for low, high in ends if low and high]
        sizes = [x for pair in pairs for x in np.geomspace(*pair, FINE + 2)[1:-1].tolist()]
    reasons = list[str]()
    for level, (inside, beyond) in zip(LEVELS.values(), ends, strict=True):
        if not inside:
            least = 100 * min(apart.values())
            reasons.append(f"never within {100 * level:g} % ({least:.3g} % at best)")
        elif not beyond:
            reasons.append(f"within {100 * level:g} % up to {largest:g} {unit}")
    one, ten = (inside if beyond else None for inside, beyond in ends)
    shown, tried = pairs[-1][0] if pairs else SMALLEST, sorted(apart)
    run = answers[shown]
    return Parting(
        unit, np.array(tried), np.array([apart[size] for size in tried]), one, ten,
        "; ".join(reasons) or None, shown, shown * linear, 0 * linear if run is None else run,
    )  # fmt: skip


def _passed(apart: Mapping[float, float], level: float) -> tuple[float | None, float | None]:
    """Last size within a level before it is exceeded, and the next one; None if there is none."""
    inside = None
    for size, share in sorted(apart.items()):
        if share <= level:
            inside = size
        elif inside:
            return inside, size
    return inside, None


class _Runs:
    """A law's compiled runs from starts off the point, less the run from the point itself."""

    def __init__(
        self,
        build: Callable[[Scenario, str], RunnableLoop],
        scenario: Scenario,
        law: str,
        at: Point,
        samples: int,
        jobs: int | None,
    ) -> None:
        """Compile, settle on the reference, and run from there."""
        period = scenario.clock.control
        timed = override(scenario, {"clock.duration": samples * period})
        self.at, self.samples, self.jobs = at, samples, jobs
        self.desired = sample(scenario, period * np.arange(float(samples)))[:, :3]
        self.loop = _remembering(build(timed, law), at)
        settle = round(SETTLED / period)
        if constant_speed(scenario) and settle:
            longer = override(scenario, {"clock.duration": settle * period})
            self.loop = replace(_settled(replace(self.loop, scenario=longer), at), scenario=timed)
        self.base = np.zeros((samples, 3))
        (base,) = self.answers([np.zeros(3)])
        if base is None:
            raise ArgumentError(
                f"{law} on {scenario.name} does not stay on its reference: its own run ends before "
                f"{samples * period:.3g} s, so there is nothing to hold a linear loop against. "
                "`wmr-ctrl check` says why."
            )
        self.base = base

    def answers(self, offs: Sequence[Floats]) -> list[Floats | None]:
        """Tracking error (samples, 3) by start, less the undisturbed one; None if a run ended."""
        columns = places(self.loop.compiled.layout.columns)
        pose = [columns[signal.name].start for signal in PLANT_STATE[:3]]

        def errors(_: int, rows: Floats, seen: Monitor) -> Floats | None:
            poses = rows[:, pose]
            whole = len(rows) == self.samples and bool(np.isfinite(poses).all())
            return tracking_errors(self.desired, poses) - self.base if whole else None

        tasks = [Task(self.loop, 0, _start(self.loop.scenario, self.at, off)) for off in offs]
        return run_logged(tasks, errors, jobs=self.jobs)


def _start(scenario: Scenario, at: Point, off: Floats) -> tuple[float, ...]:
    x, y, theta, *v = start_off(scenario, at.e + off, at.v).tolist()
    return (x, y, inward(theta, scenario.frames), *v)


def _begun(loop: RunnableLoop, state: Floats) -> RunnableLoop:
    """The loop with another initial state."""
    start = tuple(map(float, state))
    return replace(loop, compiled=replace(loop.compiled, start=start))


def _remembering(loop: RunnableLoop, at: Point) -> RunnableLoop:
    """The loop whose law starts with the memory of a point."""
    state, rows = np.array(loop.compiled.start), places(loop.compiled.layout.state)
    own = places(port.signal for port in law_loop(loop.scenario, loop.law).core.state)
    for name in own.keys() & rows.keys():
        state[rows[name]] = at.memory[own[name]]
    return _begun(loop, state)


def _settled(loop: RunnableLoop, at: Point) -> RunnableLoop:
    """The loop in its final state on the reference, moved back to the reference's beginning."""
    memory = laid_out([Task(loop, 0, _start(loop.scenario, at, np.zeros(3)))], [], log=True)
    memory.run()
    clock, after = loop.scenario.clock, memory.state[:, 0].copy()
    if len(memory.logged(0)) < clock.samples or not np.isfinite(after).all():
        return loop
    start, end = sample(loop.scenario, np.array([0.0, clock.duration]))[:, :3]
    rows = places(loop.compiled.layout.state)
    poses = [item.name for item in loop.compiled.layout.state if item.unit == POSE]
    for place in (slice(3), *(rows[name] for name in poses)):
        after[place] = moved_along(after[place], start, end)
    return _begun(loop, after)
