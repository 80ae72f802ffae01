"""Limited speeds, and a command scaled to meet all of their limits.

A channel is a speed that follows its own command independently: v and omega, or the ground speed of
each wheel, v + l omega and v - l omega.  Their limits form a convex set of commands around 0, so
each command has a largest safe share.  Scaling by this share keeps omega/v, the path's curvature.

Unequal wheels couple v and omega: then the wheels are the channels, each limited to min(V, l
Omega), so that |v| <= V and |omega| <= Omega follow (`filter.wheel-box`).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from itertools import chain

import casadi as ca

from wmr_ctrl.control.sides import LIMITS, is_number, sides
from wmr_ctrl.core.signals import LARGEST, Signal
from wmr_ctrl.world.model.system import Parameters
from wmr_ctrl.world.scenario import Scenario
from wmr_ctrl.world.scenario.sections import Limits

from .governor import NEAR, FirstOrder, admitted, largest_command

AXES = (0, 1)
WAYS = (1, -1)
FIRST = {"drive": 0, "turn": 1}
"""Axis that goes first, by the scale's name."""
ROUNDING = 2.0**-26
"""Share of V that the filter stays away from the limit: roundings (`filter.rounding.*`), and times
that are taken for the same (1e-9 of a period), are far below it."""
TINY = 1e-30
"""Room of a limit that is used up [m/s], so that no share is 0/0."""

MEMORYLESS = ca.SX(0), ca.SX(0)
"""kappa of both axes where nothing is known of the speed."""

ELAPSED = Signal("elapsed", "s", "time since the previous sample; 0: the clock's period")
SENT = Signal("v_sent", "m/s, rad/s", "command that is safe", 2)
DELTA = Signal("filter.delta", "m/s, rad/s", "largest speed due to pushes alone", 2)
FLAGS = Signal("filter_flags", "1", "sum of the flags that are set")

LIMITED, UNUSED, BOUNDS_LEFT, LATE, REFUSED, UNSOUND, TURN_RADIUS = 1, 2, 4, 8, 16, 32, 2048
SLOWING, NEAR_BY, NO_DISTANCE, LIMIT_REFUSED = 4096, 8192, 16384, 32768
"""Bits of the flags, with what they say in FLAG_MEANINGS."""
FLAG_NAMES = {
    LIMITED: "limited",
    UNUSED: "unused",
    BOUNDS_LEFT: "bounds-left",
    LATE: "late",
    REFUSED: "refused",
    UNSOUND: "unsound",
    TURN_RADIUS: "turn-radius",
    SLOWING: "slowing",
    NEAR_BY: "near",
    NO_DISTANCE: "no-distance",
    LIMIT_REFUSED: "limit-refused",
}
TOLD_FLAGS = (SLOWING, NEAR_BY, NO_DISTANCE, LIMIT_REFUSED)
"""Flags of a filter that is told limits or free distances."""
FLAG_MEANINGS = {
    LIMITED: "the command was not sent as it came",
    UNUSED: "no odometry was used",
    BOUNDS_LEFT: "odometry contradicts the stated bounds",
    LATE: "the step came outside its jitter",
    REFUSED: "the command was no number",
    UNSOUND: "the parameters are such as no filter can keep",
    TURN_RADIUS: "the base cannot turn as tightly as it was asked to",
    SLOWING: "the base may still be faster than a limit that was lowered",
    NEAR_BY: "something is too near for any command but one away from it",
    NO_DISTANCE: "no free distance came that is recent enough",
    LIMIT_REFUSED: "a limit was no number: it counts as 0",
}


@dataclass(frozen=True)
class Channel:
    """The speed ways[0] v + ways[1] arm omega, its numbers, and its limits' values ``largest``.

    ``ways``: 1, -1 or 0 each.  ``sides``: numbers of both directions, or once if they are equal.
    ``made_of``: positive numbers whose minimum or maximum is one of the channel's numbers; each may
    be NaN.
    """

    ways: tuple[int, int]
    arm: ca.SX
    sides: tuple[FirstOrder, ...]
    largest: tuple[float, float]
    made_of: tuple[ca.SX, ...] = ()

    @property
    def bounds(self) -> FirstOrder:
        """Numbers of the forward direction.  Backwards only the limit may differ."""
        return self.sides[0]

    def of(self, pair: Sequence[ca.SX | int] | ca.SX) -> ca.SX:
        """The channel's part of (v, omega)."""
        return self.ways[0] * pair[0] + self.ways[1] * (self.arm * pair[1])


FREE = Signal(
    "free", "m, m, rad, rad", "free distance ahead and behind, left and right; 1e12: no limit", 4
)
FREE_AGE = Signal("free_age", "s", "age of the free distances; negative: none is told")
TOLD = (LIMITS, FREE, FREE_AGE)
"""Further inputs of filters, beside commands and odometry."""


def told_limits(told: ca.SX, channels: Sequence[Channel]) -> list[list[ca.SX]]:
    """Limits in force of both axes, forwards and then backwards, from the received ones (4,).

    Each is at most the scenario's limit and at least the push, at which only 0 is sent.  NaN counts
    as the push.
    """
    sides = []
    for place, way in enumerate(WAYS):
        limits = []
        for i, channel in enumerate(channels):
            b, limit = channel.sides[place], way * told[2 * i + 1 - place]
            widest = reduce(ca.fmax, (side.V for side in channel.sides))
            less = ca.fmax(b.dbar, ca.fmin(limit - ROUNDING * widest, b.V))
            limits.append(ca.if_else(is_number(limit), less, b.dbar))
        sides.append(limits)
    return sides


def unusable_limits(told: ca.SX) -> ca.SX:
    """Flag that one of the limits (4,) is not a number."""
    numbers = reduce(ca.logic_and, (is_number(told[k]) for k in range(4)))
    return ca.if_else(numbers, 0, LIMIT_REFUSED)


def is_nothing(command: ca.SX) -> ca.SX:
    """1 where a command (2,) is (0, 0)."""
    return ca.logic_and(command[0] == 0, command[1] == 0)


def two_sided(channels: Sequence[Channel]) -> list[Channel]:
    """Channels with separate numbers for both directions, even if these are equal."""
    return [replace(c, sides=(c.sides[0], c.sides[-1])) for c in channels]


def largest_commands(channels: Sequence[Channel]) -> tuple[list[ca.SX], list[ca.SX]]:
    """Largest commands that are always safe, forwards and backwards, of each channel."""
    ways = [[largest_command(b.V, b) for b in channel.sides] for channel in channels]
    return [way[0] for way in ways], [way[-1] for way in ways]


def ends_of(p: Parameters, name: str) -> list[tuple[ca.SX, ca.SX]]:
    """Least and largest number called ``name`` of v and of omega, which may share one interval."""
    ends = ca.vertsplit(p.take(f"filter.{name}"))
    return [(ends[0], ends[1]), (ends[-2], ends[-1])]


def gains_of(p: Parameters) -> tuple[ca.SX, ca.SX]:
    """Least and largest gain of each axis (2,)."""
    linear, angular = ends_of(p, "gain")
    return ca.vertcat(linear[0], angular[0]), ca.vertcat(linear[1], angular[1])


def channels_of(
    scenario: Scenario,
    p: Parameters,
    numbers: tuple[ca.SX, ca.SX, ca.SX],
    kappa: Sequence[ca.SX] = MEMORYLESS,
) -> list[Channel]:
    """Channels of a scenario's filter; ``numbers``: gain (least, largest of each axis), push.

    ``kappa``: of each axis.
    """
    settings, limits = scenario.filter, scenario.limits
    K_min, K_max, d = numbers
    V = _kept(limits, p, d)
    nbar = p.take("filter.odometry") if settings.odometry else ca.SX.zeros(2)
    body = [
        tuple(
            FirstOrder(v[i], d[i], nbar[i], K_min[i], K_max[i],
                       ca.if_else(v[i] > d[i], kappa[i], 0) if limits.apart else kappa[i])
            for v in V
        )
        for i in AXES
    ]  # fmt: skip
    sizes = [(high, -low) for low, high in limits.sides]
    both = [Channel((1 - i, i), ca.SX(1), body[i], sizes[i]) for i in AXES]
    wheels = settings.channels == "wheels"
    if not wheels and settings.wheel_speed is None:
        return both
    l, tops, most = p.take("robot.l"), [list[ca.SX]() for _ in V], list[float]()
    if settings.wheel_speed is not None:
        tops, most = [[p.take("filter.wheel_speed") * (1 - ROUNDING)]], [settings.wheel_speed]
    if wheels:
        turning = l * reduce(ca.fmin, [v[1] for v in V])
        tops = [[*tops[0], v[0], turning] for v in V]
        most.append(scenario.robot.l * min(sizes[1]))
    rims = tuple(
        FirstOrder(
            reduce(ca.fmin, top), d[0] + l * d[1], nbar[0] + l * nbar[1],
            ca.fmin(K_min[0], K_min[1]), ca.fmax(K_max[0], K_max[1]), kappa[0],
        )
        for top in tops
    )  # fmt: skip
    ends = [min([*most, size] if wheels else most) for size in sizes[0]]
    made_of = (l, *chain(*tops), *ca.vertsplit(K_min), *ca.vertsplit(K_max))
    around = [Channel((1, way), l, rims, (ends[0], ends[1]), made_of) for way in WAYS]
    return around if wheels else [*both, *around]


def _kept(limits: Limits, p: Parameters, d: ca.SX) -> list[ca.SX]:
    """Limits (2,) to aim at, forwards and backwards if they may differ.

    They are never below the speed that pushes alone cause, if the full limit admits that speed.
    Then only 0 is sent, also for braking, since no margin is left for rounding.
    """
    aimed = sides(limits, p, ROUNDING)
    if not limits.apart:
        return [aimed[0]]
    pairs = zip(aimed, sides(limits, p), strict=True)
    return [ca.fmax(less, ca.fmin(whole, d)) for less, whole in pairs]


def scaled(
    r: Sequence[ca.SX], channels: Sequence[Channel], lo: list[ca.SX], hi: list[ca.SX], scale: str
) -> ca.SX:
    """The command (2,) within the limits lo <= 0 <= hi of all channels.

    ``scale``: by one factor, each axis by its own, or one axis first and then the other.
    """
    if scale in FIRST:
        return one_first(r, channels, lo, hi, FIRST[scale])
    sent = stretched(r, channels, lo, hi, scale)
    if not channels[0].ways[1]:  # the axes themselves: no rounding leads beyond their limits
        return ca.vertcat(*(ca.fmin(ca.fmax(sent[i], lo[i]), hi[i]) for i in AXES))
    return sent


def stretched(
    r: Sequence[ca.SX], channels: Sequence[Channel], lo: list[ca.SX], hi: list[ca.SX], scale: str
) -> ca.SX:
    """Both axes' commands by one factor or, with ``scale`` "axes", each by its own."""
    if len(channels[0].sides) > 1:  # a limit may be 0
        lo, hi = [ca.fmin(low, -TINY) for low in lo], [ca.fmax(high, TINY) for high in hi]
    shares = admitted([channel.of(r) for channel in channels], lo, hi)
    common = reduce(ca.fmin, shares)
    factors = shares if scale == "axes" else [common, common]
    return ca.vertcat(*(factors[i] * r[i] for i in AXES))


def one_first(
    r: Sequence[ca.SX], channels: Sequence[Channel], lo: list[ca.SX], hi: list[ca.SX], first: int
) -> ca.SX:
    """Command with one axis limited first, then the other within the remaining range.

    The limits apply one by one, so that limits known early can be used before the others.
    """
    sent = [ca.SX(0), ca.SX(0)]
    for axis in (first, 1 - first):
        back, ahead = zip(*_ends(sent, channels, lo, hi, axis), strict=True)
        forth, down = reduce(ca.fmin, ahead, r[axis]), reduce(ca.fmax, back, r[axis])
        if axis != first:  # what is used up may be so beyond the limit, by roundings
            forth, down = ca.fmax(forth, 0), ca.fmin(down, 0)
        sent[axis] = ca.if_else(r[axis] >= 0, forth, down)
    return ca.vertcat(*sent)


def _ends(
    sent: Sequence[ca.SX], channels: Sequence[Channel], lo: list[ca.SX], hi: list[ca.SX], axis: int
) -> Iterator[tuple[ca.SX, ca.SX]]:
    """Range (back, ahead) of an axis that each channel allows, given the other axis' command."""
    for channel, low, high in zip(channels, lo, hi, strict=True):
        way, used = channel.ways[axis], channel.of(sent)
        if way:
            inverse = 1 / channel.arm if axis else ca.SX(1)
            ends = (low - used, high - used) if way > 0 else (used - high, used - low)
            yield ends[0] * inverse, ends[1] * inverse


def usable_command(asked: ca.SX) -> tuple[list[ca.SX], ca.SX]:
    """The command of both axes, 0 if it is not a number, and the flag for that."""
    usable = reduce(ca.logic_and, (within(asked[i], LARGEST) for i in AXES))
    return [ca.if_else(usable, asked[i], 0) for i in AXES], ca.if_else(usable, 0, REFUSED)


def within(value: ca.SX, size: ca.SX | float) -> ca.SX:
    """1 if |value| <= size; 0 otherwise, and for NaN."""
    return ca.logic_and(value >= -size, value <= size)


def passed(elapsed: ca.SX, T: ca.SX) -> ca.SX:
    """Time since the previous sample; the period if ``elapsed`` is 0 (unknown)."""
    return ca.if_else(elapsed == 0, T, elapsed)


def usable_time(elapsed: ca.SX, T: ca.SX) -> ca.SX:
    """Time in which a command may change: since the previous sample, at most one period.

    0 if the clock did not advance, went back, or gives no number.
    """
    since = passed(elapsed, T)
    return ca.if_else(since >= T, T, ca.if_else(since >= 0, since, 0))


def punctual(elapsed: ca.SX, T: ca.SX, jitter: float) -> ca.SX:
    """1 if a sample came within its jitter [periods]; 0 otherwise, and for NaN."""
    return within(passed(elapsed, T) - T, (jitter + NEAR) * T)


def has_bit(flags: ca.SX, bit: int) -> ca.SX:
    """1 where this bit of a sum of flags is set."""
    return ca.floor(flags / bit) - 2 * ca.floor(flags / (2 * bit))


def limited(sent: ca.SX, r: Sequence[ca.SX]) -> ca.SX:
    """Flag of a command that was changed before it was sent."""
    return ca.if_else(ca.logic_and(sent[0] == r[0], sent[1] == r[1]), 0, LIMITED)


def sound(channels: Sequence[Channel]) -> ca.SX:
    """1 if every channel's numbers allow a safe command; 0 otherwise, and for NaN."""
    tests = []
    for b in chain.from_iterable(channel.sides for channel in channels):
        less = b.dbar <= b.V if len(channels[0].sides) > 1 else b.dbar < b.V
        tests += [b.dbar >= 0, less, b.V <= LARGEST, b.nbar >= 0, b.nbar <= LARGEST]
        tests += [b.K_min > 0, b.K_max >= b.K_min, b.K_max <= LARGEST]
    for number in {id(item): item for channel in channels for item in channel.made_of}.values():
        tests += [number > 0, number <= LARGEST]
    return reduce(ca.logic_and, tests)
