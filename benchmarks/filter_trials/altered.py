"""Formulas of a stop that are made wrong, each as it was in a first version or by one term.

Each breaks in drives whose base keeps all bounds: trials that miss one would say little.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field, replace
from functools import reduce
from typing import Any
from unittest.mock import patch

import casadi as ca

from wmr_ctrl.control.filter import stopping
from wmr_ctrl.control.filter.channels import AXES
from wmr_ctrl.control.filter.stopping import StoppingGovernor, whole_steps
from wmr_ctrl.control.filter.ways import Stop, ToldBound, covered

from .stopping import (
    BACK,
    CONSTANT,
    GREEDY,
    HARD,
    ODD,
    PLAIN,
    PRESS,
    SLOWLY,
    SWITCHING,
    TAPS,
    Base,
    Drives,
    Found,
)

HOLD, STEADY, TAKEOVERS = Stop.hold, Stop.steady, ToldBound.takeovers


@dataclass(frozen=True)
class Altered:
    """Wrong formulas, their fault (see `stopping.breaks`), and drives that show it."""

    formulas: Mapping[tuple[Any, str], Any]
    breaks: str
    told: Base
    chosen: Mapping[str, Any] = field(default_factory=dict)

    @contextmanager
    def applied(self) -> Iterator[None]:
        """Replace the formulas while graphs are built."""
        with ExitStack() as stack:
            for (owner, name), formula in self.formulas.items():
                stack.enter_context(patch.object(owner, name, formula))
            yield

    def found(self, count: int, seed: int) -> Found:
        """Drives behind the altered filter."""
        with self.applied():
            filtering = Drives(self.told)
        return filtering.run(count, seed, **self.chosen)


def _pull(gain: str, *, first: bool = False) -> property:
    """Speed away with this gain, of the ``first`` command or of the later ones."""

    def pull(self: StoppingGovernor) -> list[list[ca.SX]]:
        sides = []
        for place in AXES:
            pulls = []
            for i, b in enumerate(self._bounds(place)):
                command = ca.fabs(self.offered[i])
                steady = (self.in_force[1 - place][i] - b.dbar) / b.K_max
                most = command if first else ca.fmin(command, steady)
                pulls.append(getattr(b, gain) * most - b.dbar)
            sides.append(pulls)
        return sides

    return property(pull)


def _fewer_zeros(plan: Any, T: ca.SX, time: ca.SX, more: float = -1e-9) -> ca.SX:
    steps = whole_steps(plan, T, time, more)
    return ca.floor(0.8 * steps) if more > 0 else steps


def _slow_roll(self: Stop) -> ca.SX:
    return self.push * (self.rest - covered(self.rest, self.tau[1]))


def _steady(end: int) -> Callable[..., ca.SX]:
    return lambda self, free, takeovers: STEADY(
        replace(self, tau=(self.tau[end], self.tau[end])), free, takeovers
    )


def _limit(line: str) -> Callable[..., ca.SX]:
    """Largest command by only one of the two lines: that of the longest or of the least time."""

    def admitted(self: StoppingGovernor, place: int, axis: int) -> ca.SX:
        motion = self.told[place][axis]
        V, v_bar, b = self.in_force[place][axis], self.takeover[place][axis], motion.bounds
        acts = ca.fmax(motion.schedule.shortest * self.T, 1e-9)
        above = 1 / ca.expm1(acts / motion.tau[1])
        share = b.kappa if line == "longest" else above
        return (V - b.dbar + share * (V - v_bar)) / b.K_max

    return admitted


def _each_axis(self: StoppingGovernor) -> ca.SX:
    """Wrong rule: each axis considers its own sides alone."""
    own = [reduce(ca.logic_and, (side[i] for side in self.open)) for i in AXES]
    return ca.vertcat(*(ca.if_else(own[i], self.offered[i], 0) for i in AXES))


BAR = Base(delay=(0.1, 0.15), tau=(0.15, 0.3), v=(1.0, 1.0), leave=0)
DOCS, WIDE = Base(delay=(0.0, 0.03), leave=0), Base(tau=(0.1, 1.0), leave=0)
LAZY = Base(tau=(1.5, 3.0), push=(0.2, 0.2), rest=0.4, v=(1.0, 0.9), leave=0)
WALL, LIMITS, *_ = HARD


def _away(driver: int, **chosen: Any) -> Mapping[str, Any]:
    """Choices of drives away from a wall; a driver who ``trusts`` drives for the time that it
    waited.
    """
    hard = {"driver": driver, "base": GREEDY, "limits": CONSTANT, "near": True, "seconds": 30.0}
    return {**hard, **chosen}


ALTERED: Mapping[str, Altered] = {
    "a hold half as long": Altered(
        {(Stop, "hold"): lambda self, pull: 0.5 * HOLD(self, pull)}, "touch", BAR,
        _away(TAPS, trusts=True),
    ),
    "a fifth of the zeros before rest less": Altered(
        {(stopping, "whole_steps"): _fewer_zeros}, "touch", WIDE, _away(SLOWLY)
    ),
    "pull by the largest gain": Altered(
        {(StoppingGovernor, "pull"): _pull("K_max")}, "touch",
        Base(gain=(0.7, 1.4), delay=(0.1, 0.1), leave=0), _away(TAPS, trusts=True),
    ),
    "pull of the first command": Altered(
        {(StoppingGovernor, "pull"): _pull("K_min", first=True)}, "touch",
        Base(rest=3.0, delay=(0.05, 0.05), leave=0), _away(TAPS, trusts=True),
    ),
    "roll by the largest time constant": Altered(
        {(Stop, "roll"): property(_slow_roll)}, "touch", replace(WIDE, leave=1),
        _away(BACK, near=False, trusts=True),
    ),
    "a command away passes at any time": Altered(
        {(StoppingGovernor, "_is_ripe"): lambda self, place, axis: ca.SX(1)}, "touch", BAR,
        _away(TAPS),
    ),
    "each axis by its own sides": Altered(
        {(StoppingGovernor, "safe"): property(_each_axis)}, "touch", PLAIN,
        {"driver": PRESS, "base": GREEDY, "limits": CONSTANT},
    ),
    "the line of the least time constant alone": Altered(
        {(Stop, "steady"): _steady(0)}, "touch", PLAIN, WALL
    ),
    "the line of the largest time constant alone": Altered(
        {(Stop, "steady"): _steady(1)}, "touch", PLAIN, WALL
    ),
    "the first instant of a takeover alone": Altered(
        {(ToldBound, "takeovers"): lambda self, v, targets: TAKEOVERS(self, v, targets)[:1]},
        "touch", Base(delay=(0.1, 0.2), leave=0), WALL,
    ),
    "the last instant of a takeover alone": Altered(
        {(ToldBound, "takeovers"): lambda self, v, targets: TAKEOVERS(self, v, targets)[-1:]},
        "touch", Base(delay=(0.1, 0.2), leave=0), WALL,
    ),
    "both ends of a takeover, none between": Altered(
        {(ToldBound, "takeovers"): lambda self, v, targets: [
            TAKEOVERS(self, v, targets)[0], TAKEOVERS(self, v, targets)[-1]]},
        "touch", Base(delay=(0.1, 0.25), leave=0), WALL,
    ),
    "no way of a push while the brake closes": Altered(
        {(Stop, "creep"): property(lambda self: ca.SX(0))}, "touch", PLAIN, WALL
    ),
    "things come nearer for a command alone": Altered(
        {(Stop, "time"): property(lambda self: self.acts)}, "touch",
        Base(delay=(0.05, 0.05), nearing=0.3, leave=0), WALL,
    ),
    "no bound by 0 where a brake may close": Altered(
        {(ToldBound, "_lifted"): lambda self, v, piece: v}, "fast", LAZY,
        {"far": (0.0, 0.0), "base": SWITCHING, "driver": ODD, "limits": CONSTANT},
    ),
    "a lowered limit by the longest time alone": Altered(
        {(StoppingGovernor, "_admitted"): _limit("longest")}, "late", DOCS, LIMITS
    ),
    "a limit by the least time alone": Altered(
        {(StoppingGovernor, "_admitted"): _limit("least")}, "fast", DOCS, LIMITS
    ),
}  # fmt: skip
