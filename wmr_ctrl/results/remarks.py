"""Remarks: what a user has to know of a finished run, each with a key, numbers and a remedy."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from wmr_ctrl.results.monitor import RigidMonitor
from wmr_ctrl.results.oscillation import oscillation
from wmr_ctrl.results.outcomes import Outcome
from wmr_ctrl.results.tracking import (
    arrival,
    guard_share,
    last_quarter,
    position_max,
    position_rms,
    tracked,
)
from wmr_ctrl.results.wording import percent

if TYPE_CHECKING:
    from wmr_ctrl.results.run import Run

HELD_BACK = 0.1
"""Share of the last quarter's samples from which the guard holds a run back."""

SHORT = {
    "not-tracked": "it did not track",
    "goal-not-reached": "it did not reach its goal",
    "oscillates": "its torques oscillate",
    "guard-holds-back": "the guard holds it back",
    "assumption-void": "an assumption of the guarantee is void",
}
"""Remarks in a few words, by key; the other keys are what the outcome says."""


@dataclass(frozen=True, slots=True)
class Remark:
    """One thing to know: a key for scripts and a text of what, by how much, and the remedy."""

    key: str
    text: str


def remarks_on(run: Run) -> tuple[Remark, ...]:
    """All that is to be said against a run; empty only if all is well."""
    return tuple(remark for part in _PARTS for remark in part(run))


def in_short(remarks: tuple[Remark, ...]) -> str:
    """The remarks that no outcome tells, as "it did not track and its torques oscillate"."""
    *head, last = (SHORT[item.key] for item in remarks if item.key in SHORT)
    return f"{', '.join(head)} and {last}" if head else last


def _outcome(run: Run) -> Iterator[Remark]:
    monitor = run.monitor
    if monitor.violations:
        outcome = Outcome.LIMIT_VIOLATED
        yield Remark(outcome.value, outcome.sentence(monitor, run.guard))
    seen = monitor.rigid
    if seen and seen.tipped is not None:
        yield Remark(Outcome.TIPPED.value, Outcome.TIPPED.sentence(monitor))
    if seen and seen.slipped is not None:
        yield Remark(Outcome.SLIPPED.value, _slipped(seen))
    if run.guard and monitor.bounds_left:
        outcome = Outcome.BOUNDS_LEFT
        yield Remark(outcome.value, outcome.sentence(monitor, run.guard))


def _slipped(seen: RigidMonitor) -> str:
    return (
        f"From t = {seen.slipped:.6g} s on the wheels slipped over the ground, at most by "
        f"{seen.max_slip:.3g} m/s; laws and guard assume that they grip. Limit the wheel torques: "
        "`wmr-ctrl check` names the largest one without spin."
    )


def _not_tracked(run: Run) -> Iterator[Remark]:
    if tracked(run) is not False:
        return
    late, most, allowed = position_rms(run)["last_quarter"], position_max(run), run.settings
    if late is None or most is None:
        yield Remark("not-tracked", "The run ended before its last quarter was over.")
        return
    yield Remark(
        "not-tracked",
        f"Over the last quarter the robot was {late:.3g} m RMS and at most {most:.3g} m from its "
        f"desired position; metrics.tolerance is {allowed.tolerance:g} m. See the other remarks "
        "and `wmr-ctrl check` for the cause, choose another law or gains, ask for a slower "
        "reference, or raise the tolerance if that is good enough.",
    )


def _not_arrived(run: Run) -> Iterator[Remark]:
    times, settings = arrival(run), run.settings
    if times is None or settings.arrival is None or times["robot"] is not None:
        return
    if settings.duration < settings.arrival:
        yield Remark(
            "goal-not-reached",
            f"The desired motion comes to rest at its goal at t = {settings.arrival:.4g} s, after "
            f"the run of {settings.duration:g} s. Lengthen clock.duration.",
        )
    elif settings.tolerance is not None and run.rows:
        away = float(np.hypot(run["x"][-1] - run["x_d"][-1], run["y"][-1] - run["y_d"][-1]))
        yield Remark(
            "goal-not-reached",
            f"At the end the robot was {away:.3g} m from the goal; metrics.tolerance is "
            f"{settings.tolerance:g} m. A desired motion at rest corrects no sideways error: ask "
            "for a slower end (reference.a_max) or a law that tracks closer.",
        )


def _oscillates(run: Run) -> Iterator[Remark]:
    cycle = oscillation(run)
    if cycle is not None:
        yield Remark(
            "oscillates",
            f"The wheel torques swing by {cycle.swing:.3g} N m peak to peak at "
            f"{cycle.frequency:.3g} Hz, {1 / cycle.frequency / run.settings.control:.3g} samples a "
            "period: a limit cycle, or a loop that is close to one. Lower the law's gains, or "
            "shorten clock.control and the drives' delay.",
        )


def _held_back(run: Run) -> Iterator[Remark]:
    shares = guard_share(run, last_quarter(run.settings))
    if shares is not None and max(shares) >= HELD_BACK:
        thrust, moment = map(percent, shares)
        yield Remark(
            "guard-holds-back",
            f"Over the last quarter the guard changed the thrust in {thrust} and the moment in "
            f"{moment} of the samples: the law asks for more than the limits, less what the guard "
            "keeps back, admit. Ask for a slower reference, shorten clock.control, or state a "
            "smaller guard.dbar or a larger guard.M_min if they are true.",
        )


def _void(run: Run) -> Iterator[Remark]:
    if run.guard and run.settings.void:
        yield Remark("assumption-void", run.settings.void)


_PARTS: tuple[Callable[[Run], Iterator[Remark]], ...] = (
    _outcome,
    _not_tracked,
    _not_arrived,
    _oscillates,
    _held_back,
    _void,
)
