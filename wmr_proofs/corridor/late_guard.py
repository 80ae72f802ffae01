"""Conditions under which a guard that takes late commands into account changes no force.

With the slope S of the guard's ceiling, commands F_j that may still act for tau_j, all within a
size N >= net, and P = sum tau_j F_j, the ceiling is at least F where

    |F + S y + alpha P| <= S (u1 - nbar) - net - alpha N sum tau_j,

and so without S y for a robot at rest, and without F for its safe point.  With jitter J the last
command acts for J more, or F has 1 + alpha J times the weight; for pieces in which either of two
commands may act, both are considered (ledger: corridor.guard-late, corridor.guard-sums).
"""

from collections.abc import Iterator, Sequence
from itertools import product

import casadi as ca
import numpy as np

from wmr_ctrl.control.guard.bounds import GuardNumbers, aim, mass_range, net, pair_of, slope
from wmr_ctrl.control.guard.delay import largest_force
from wmr_ctrl.control.guard.guard import Bounds
from wmr_ctrl.control.guard.lateness import Counting
from wmr_ctrl.control.setup import Setup
from wmr_ctrl.theory.checks.error_coordinates import Floats
from wmr_ctrl.world.scenario import Scenario

from .condition import AXES, Condition

ROOM = 1.6
"""Share of the linear loop's largest forces up to which commands in transit are counted."""


def counts_late(setup: Setup) -> bool:
    """True if a guard takes commands in transit into account."""
    scenario = setup.scenario
    late = setup.guard.lateness(scenario.clock)
    return scenario.guard.enabled and any(not item.at_once for item in late)


def is_plain(setup: Setup) -> bool:
    """True if the guard takes only commands in transit into account: no lag, no late velocity."""
    late = setup.guard.lateness(setup.scenario.clock)
    return all(not (x.lag or x.oldest or x.varying or x.tail) for x in late)


def commands_counted(setup: Setup) -> int:
    """Commands in transit that a plain guard takes into account on each axis; 0 without one."""
    if not counts_late(setup):
        return 0
    return setup.guard.lateness(setup.scenario.clock)[0].commands


def sizes_of_forces(setup: Setup, forces: Floats) -> Floats:
    """N (2) for a linear loop whose forces are at most ``forces`` (2)."""
    least = [net(setup.guard, i) for i in range(len(AXES))]
    return np.asarray(np.maximum(least, ROOM * forces))


def late_conditions(
    setup: Setup, force: ca.SX, v: ca.SX, sent: Sequence[ca.SX], sizes: Floats
) -> Iterator[Condition]:
    """Conditions for a ``force`` (2) at a measured velocity, after commands ``sent``, latest first.

    ``sizes``: N (2).
    """
    scenario, guard, period = setup.scenario, setup.guard, setup.scenario.clock.control
    errors = pair_of(guard.nbar)
    for i, (axis, late) in enumerate(zip(AXES, guard.lateness(scenario.clock), strict=True)):
        alpha, N, spare = float(guard.alpha or 0.0), float(sizes[i]), net(guard, i)
        steep = slope(guard, i)
        near = steep * (aim(scenario, guard, i) - errors[i])
        far = steep * (aim(scenario, guard, i) - guard.f_speed[i])
        most = float(ca.evalf(largest_force(numeric_bounds(scenario, guard, i)))) * (1 - 1e-12)
        yield Condition(f"the guard's largest force ({axis})", force[i], ca.SX(most))
        yield Condition(f"the guard's count of a force ({axis})", force[i], ca.SX(N), inner=True)
        for share, pieces in _lines(late, alpha * period):
            for chosen in product(*(which for which, _ in pieces)):
                in_flight = sum(
                    (
                        alpha * period * time * sent[j - 1][i]
                        for j, (_, time) in zip(chosen, pieces, strict=True)
                    ),
                    ca.SX(0),
                )
                taken = alpha * period * N * sum(time for _, time in pieces)
                for moving, room in ((steep * v[i], near), (ca.SX(0), far)):
                    for new in (share * force[i], ca.SX(0)):
                        value = new + moving + in_flight
                        left = ca.SX(room - spare * share - taken)
                        yield Condition(f"the guard's ceiling ({axis})", value, left)


def _lines(late: Counting, alpha: float) -> list[tuple[float, list[tuple[tuple[int, ...], float]]]]:
    """Weights of the new force, and of the earlier commands with the times of their pieces.

    ``alpha``: per period.
    """
    pieces = list(late.mean)
    if not late.jitter:
        return [(1.0, pieces)]
    return [(1.0, [*pieces, ((1,), late.jitter)]), (1.0 + alpha * late.jitter, pieces)]


def numeric_bounds(scenario: Scenario, guard: GuardNumbers, axis: int) -> Bounds:
    """Bounds of one axis of the guard, as numbers."""
    period, late = scenario.clock.control, guard.lateness(scenario.clock)[axis]
    (low, high), alpha = mass_range(guard, axis), float(guard.alpha or 0.0)
    pairs = (guard.dbar, guard.nbar, guard.brake, guard.f_min, guard.f_speed)
    dbar, nbar, brake, f_min, f_speed = (ca.SX(pair_of(pair)[axis]) for pair in pairs)
    times = (late.most, late.jitter, late.mixed)
    delay, jitter, mixed = (ca.SX(period * time) if time else None for time in times)
    return Bounds(
        u1=ca.SX(aim(scenario, guard, axis)), period=ca.SX(period), M_min=ca.SX(low),
        M_max=ca.SX(high), dbar=dbar, nbar=nbar, alpha=ca.SX(alpha), brake=brake, f_min=f_min,
        f_speed=f_speed, delay=delay, jitter=jitter, mixed=mixed,
    )  # fmt: skip
