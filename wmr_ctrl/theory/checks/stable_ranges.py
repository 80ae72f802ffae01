"""Periods, delays and masses with which a law's linear loop is stable around its reference."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from wmr_ctrl.control.filter.filter import passing_commands
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.fields.arguments import checks_arguments
from wmr_ctrl.core.fields.values import LARGEST
from wmr_ctrl.world.scenario import Scenario

from .budget import counted
from .loop import Loop
from .radius import (
    MARGIN,
    RATIO,
    SHORTEST,
    edge,
    largest_radius,
    operating_points,
    stretches_of,
    supremum,
)
from .sampled_plant import Point
from .sending import loop_of
from .surroundings import oldest_shown

MOST_UNDER_WAY = 40
"""Commands in transit in a delay at the shortest period that is tried."""
MASSES = 20.0
"""Largest ratio of true to believed mass that is tried, and one over the smallest."""


@checks_arguments
def largest_stable_period(scenario: Scenario, law: str) -> float:
    """Supremum [s] of the range of stable periods that contains the scenario's, or of the next
    below.

    Over all points of the reference; 0.0 if the scenario's period and all shorter ones that were
    tried are unstable, inf if all longer ones (up to 10 s) are stable.  Raises UnknownNameError
    for a law.
    """
    return largest_period(loop_of(settle(scenario, law)))


@dataclass(frozen=True)
class Stability:
    """Stable periods, largest delay [s], and ratios of true to believed mass, around the reference.

    Delay and masses are for the scenario's period; see the functions of these names.  ``tried``:
    the shortest period that was tried.  ``held``: period beyond which the base stops between
    commands.  ``least_delay``: smallest stable delay.  ``off``: distance from the reference at rest
    [m], None without an equilibrium.  ``any_mass``: the base's own loop compensates its mass.
    ``remarks``: neglected effects, as texts.
    """

    shortest: float
    period: float
    delay: float | None
    masses: tuple[float, float] | None
    tried: float
    held: float = math.inf
    least_delay: float = 0.0
    off: float | None = 0.0
    any_mass: bool = False
    remarks: tuple[str, ...] = ()

    @property
    def delay_words(self) -> str:
        """Text on the stable delays."""
        low = (
            f"for a delay of {self.least_delay:.3g} to" if self.least_delay else "up to a delay of"
        )
        return f"{low} {self.delay:.3g} s"

    @property
    def mass_words(self) -> str:
        """Text on the stable mass ratios; an end of the tried range is not reported as a limit."""
        if self.any_mass:
            return "for any mass, since the base's own loop corrects for it"
        low, high = self.masses or (math.nan, math.nan)
        less, more = " or less" * (low <= 1 / MASSES), " or more" * (high >= MASSES)
        return f"for a mass of {low:.3g}{less} to {high:.3g}{more} times the believed one"


def stability(scenario: Scenario, law: str) -> Stability:
    """Stability of a law on a scenario; raises UnknownNameError for a law."""
    loop = loop_of(settle(scenario, law))
    delays, masses = stable_delays(loop), stable_masses(loop)
    any_mass = scenario.takes_velocity and "pi" not in scenario.base.loop
    least, most = delays or (0.0, None)
    return Stability(
        *stable_periods(loop), most, masses, shortest_tried(loop), loop.longest, least,
        distance_at_rest(loop), any_mass, tuple(_remarks(loop)),
    )  # fmt: skip


def distance_at_rest(loop: Loop) -> float | None:
    """Largest distance [m] of an equilibrium from the reference, over all its operating points.

    None if there is no equilibrium, or it is beyond the limits.
    """
    points = _rests(loop)
    inside = (at and (np.abs(at.v) <= loop.scenario.limits.v_u1).all() for at in points)
    return max(float(np.hypot(*at.e[:2])) for at in points if at) if all(inside) else None


@counted
def _rests(loop: Loop) -> list[Point | None]:
    period, stretches = loop.scenario.clock.control, stretches_of(loop.scenario)
    speeds = operating_points(loop.scenario) if stretches is None else stretches[0]
    return [loop.resting(v_d, theta, period) for theta in loop.around.headings for v_d in speeds]


def _remarks(loop: Loop) -> Iterator[str]:
    """Texts on effects that the linear loop of a base that takes velocities neglects."""
    base, robot = loop.scenario.base, loop.scenario.robot
    if not loop.setup.takes_velocity:
        return
    if loop.traits.estimates:
        yield "its estimates move; after a transient they may let it settle beyond"
    sent = np.array([at.force for at in _rests(loop) if at]).reshape(-1, 2)
    if (np.abs(sent) @ (1.0, robot.l) > robot.r * base.w_max).any():
        yield "as if base.w_max passed the commands that its path needs"
    if loop.scenario.filter.kind in ("clip", "governor") and any(
        ((sent @ row < low) | (sent @ row > high)).any()
        for _, row, (low, high) in passing_commands(loop.scenario)
    ):
        yield "as if the filter let the commands pass that its path takes"


def largest_period(loop: Loop) -> float:
    """`largest_stable_period` of an existing Loop."""
    return stable_periods(loop)[1]


@counted
def stable_periods(loop: Loop) -> tuple[float, float]:
    """Ends [s] of the range of stable periods that contains the scenario's, or of the next below.

    The lower end is 0.0 if all shorter periods that were tried are stable, too, which a delay can
    prevent; (0.0, 0.0) if the scenario's period and all shorter ones that were tried are unstable.
    """
    shortest, inside = shortest_tried(loop), loop.scenario.clock.control

    @cache
    def of(period: float) -> float:
        return largest_radius(loop, period)

    outside = math.inf
    while of(inside) > 1 + MARGIN:
        outside, inside = inside, inside / RATIO
        if inside < shortest:
            return 0.0, 0.0
    high = edge(of, inside, outside) if outside < math.inf else supremum(of, inside)
    below = inside
    while below >= shortest and of(below) <= 1 + MARGIN:
        below /= RATIO
    return (edge(of, below * RATIO, below) if below >= shortest else 0.0), high


def shortest_tried(loop: Loop) -> float:
    """Shortest period that is tried [s], since the number of commands in transit is limited."""
    late = max(loop.around.drives.delay, loop.setup.prediction)
    return max(SHORTEST, (late + oldest_shown(loop.setup)) / MOST_UNDER_WAY)


def largest_stable_delay(loop: Loop) -> float | None:
    """The upper end of `stable_delays`."""
    delays = stable_delays(loop)
    return None if delays is None else delays[1]


def stable_delays(loop: Loop) -> tuple[float, float] | None:
    """Least and supremum of the drives' delay [s] that are stable at the scenario's period.

    Lag and sensors are unchanged.  The least is 0, or the scenario's delay for a law that predicts
    and for a loop that is unstable without delay; None if it is unstable with that delay, too.  The
    supremum is inf if all delays that were tried, up to 40 periods, are stable.
    """
    period = loop.scenario.clock.control
    own = loop.around.drives

    def of(delay: float) -> float:
        known = max(delay - (own.delay - own.known), 0.0)
        late = replace(own, delay=delay, known=known)
        return largest_radius(loop.with_delay(known), period, late)

    for least in (own.delay,) if loop.setup.prediction else dict.fromkeys((0.0, own.delay)):
        tried = [least + k * period / 8 for k in range(1, 8 * MOST_UNDER_WAY)]
        if (most := _last(of, least, tried)) is not None:
            return least, most
    return None


@counted
def stable_masses(loop: Loop, most: float = MASSES) -> tuple[float, float] | None:
    """Smallest and largest ratio of true to believed mass and inertia with a stable loop.

    Both are scaled alike, at the scenario's period; tried from 1/``most`` to ``most``, as far as a
    scenario can state them. None for a law without a model of the mass, and if the loop is unstable
    with the believed one.
    """
    if not loop.traits.model:
        return None
    believed = loop.scenario.believed

    def of(ratio: float) -> float:
        robot = replace(loop.scenario.robot, m=ratio * believed.m, I=ratio * believed.I)
        return largest_radius(loop, loop.scenario.clock.control, robot=robot)

    steps = [RATIO**k for k in range(1, round(math.log(most) / math.log(RATIO)) + 1)]
    heavier = [step for step in steps if step * max(believed.m, believed.I) <= LARGEST]
    up = _last(of, 1.0, heavier) if heavier else math.inf
    down = _last(of, 1.0, [1 / step for step in steps])
    return None if up is None or down is None else (max(down, 1 / most), min(up, most))


def _last(of: Callable[[float], float], start: float, tried: Sequence[float]) -> float | None:
    """Stability limit along ``tried``; inf if all are stable, None if ``start`` is not."""
    of = cache(of)
    if of(start) > 1 + MARGIN:
        return None
    inside = start
    for value in tried:
        if of(value) > 1 + MARGIN:
            return edge(of, inside, value)
        inside = value
    return math.inf if inside > start else 0.0
