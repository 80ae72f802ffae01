"""Motors, ground and air: what they add to the guard's assumptions, on their graphs."""

from __future__ import annotations

from fractions import Fraction

import casadi as ca

from wmr_ctrl.guard.lagging import integral, moved
from wmr_ctrl.proofs.claims.world import ours, within
from wmr_ctrl.proofs.methods.spec import Z3
from wmr_ctrl.proofs.statement import Statement, above, at_least, equal, symbols
from wmr_ctrl.world import gust, motor, resistance, slope

ALONG = {name: Fraction(x) for name, x in zip(("pull", "offset", "along", "across"), (1, 0, 1, 0),
                                              strict=True)}  # fmt: skip
"""Straight uphill."""


def _stepped(flip: float) -> Statement:
    """The whole number of steps is that of the graph: floor(x) <= x < floor(x) + 1."""
    t = symbols("torque step", "step")
    number = ca.floor(t["torque"] / t["step"] + 0.5)
    off = motor.stepped(t["torque"], t["step"]) - t["torque"]
    x = t["torque"] / t["step"] + 0.5
    given = (above(t["step"]), at_least(x, number), above(1, x - number))
    half = t["step"] / (2 if flip > 0 else 2.5)
    return Statement(t, within(off, half), given, {"number": number})


def _held(flip: float) -> Statement:
    """One plant step of the lag that holds its value, and Z that the guard follows."""
    t = symbols("z p step share a b between least falls rises")
    z, p, h, s, a, b, e, least, falls, rises = t.values()
    after = p + e * (z - p)
    guarded = integral(z, p, (h, b * (1 - falls), a * (1 - rises)))
    goals = (
        at_least(
            guarded + s * moved(z, p, (falls, rises)), ((1 if flip > 0 else 1.01) * h + s) * after
        ),
        at_least(moved(z, p, (falls, rises)), after),
    )
    given = (
        at_least(z), at_least(p), above(h), above(a), at_least(s, a), at_least(b, s),
        equal(a * (1 - least), h * least), at_least(rises), at_least(least, rises),
        at_least(e, least), at_least(falls, e), above(1, falls),
        at_least(b * (1 - falls), h * falls),
    )  # fmt: skip
    return Statement(t, goals, given)


def _zone(flip: float) -> Statement:
    """What is lost has the torque's sign."""
    t = symbols("torque zone", "zone")
    lost = t["torque"] - motor.beyond_zone(t["torque"], t["zone"])
    most = t["zone"] if flip > 0 else 0.9 * t["zone"]
    goals = (*within(lost, most), at_least(lost * t["torque"]))
    return Statement(t, goals, (above(t["zone"]),))


def _deficit(most: ca.SX, speed: ca.SX, stall: ca.SX, slowing: ca.SX) -> ca.SX:
    """d(s): the torque that is missing at worst, convex in the speed."""
    return ca.fmax(most - stall * (1 - slowing * ca.fmax(speed, 0)), 0)


def _line(flip: float) -> Statement:
    """A torque loses nothing but size, at most d of the speed in its own direction."""
    t = symbols("torque speed stall slowing most", "stall slowing")
    made = motor.on_line(t["torque"], t["speed"], t["stall"], t["slowing"])
    ahead, back = (_deficit(t["most"], s * t["speed"], t["stall"], t["slowing"]) for s in (1, -1))
    ahead, back = ca.fmin(ahead, t["most"]), ca.fmin(back, t["most"])
    share = 1 if flip > 0 else 0.9
    goals = (
        at_least(share * ahead, t["torque"] - made),
        at_least(share * back, made - t["torque"]),
        at_least((t["torque"] - made) * t["torque"]),
    )
    given = (above(t["stall"]), at_least(t["slowing"]), *within(t["torque"], t["most"]))
    return Statement(t, goals, given)


def _pair(way: int, flip: float) -> Statement:
    """d of both wheels' speeds is largest at the limits: way 1 for the thrust, -1 the moment."""
    t = symbols("v turn u1 edge stall slowing most", "stall slowing")

    def both(v: ca.SX, turn: ca.SX) -> ca.SX:
        speeds = (v + turn, v - turn) if way > 0 else (turn + v, turn - v)
        return ca.SX(sum(_deficit(t["most"], s, t["stall"], t["slowing"]) for s in speeds))

    given = (
        above(t["stall"]), at_least(t["slowing"]), above(t["u1"]), above(t["edge"]),
        *within(t["v"], t["u1"]), *within(t["turn"], t["edge"]),
    )  # fmt: skip
    end = both(t["u1"] if flip > 0 else 0.9 * t["u1"], t["edge"])
    return Statement(t, (at_least(end, both(t["v"], t["turn"])),), given)


def _pair_ahead(flip: float) -> Statement:
    return _pair(1, flip)


def _pair_around(flip: float) -> Statement:
    return _pair(-1, flip)


# Ground and air.


def _slope(flip: float) -> Statement:
    """|cos|, |sin| <= 1."""
    t = symbols("pull offset along across")
    force = slope.pulled(t["pull"], t["offset"], t["along"], t["across"])
    most = t["pull"] if flip > 0 else 0.9 * t["pull"]
    circle = equal(t["along"] ** 2 + t["across"] ** 2, 1)
    goals = (*within(force[0], most), *within(force[1], most * ca.fabs(t["offset"])))
    return Statement(t, goals, (at_least(t["pull"]), circle))


def _resisted(axis: int, flip: float) -> Statement:
    """right + left has the sign of v1, right - left that of omega: here both positive."""
    t = symbols("most_right most_left half right left")
    most = ca.vertcat(t["most_right"], t["most_left"])
    force = resistance.resisted(most, t["half"], t["right"], t["left"])[axis]
    more = ca.fabs(most[0] - most[1]) * (1 if axis == 0 else t["half"])
    moves = t["right"] + t["left"] if axis == 0 else t["right"] - t["left"]
    given = (
        at_least(most[0]), at_least(most[1]), above(t["half"]), at_least(moves),
        *within(t["right"], 1), *within(t["left"], 1),
    )  # fmt: skip
    return Statement(t, (at_least(more * (1 if flip > 0 else 0.9), force),), given)


def _resisted_thrust(flip: float) -> Statement:
    return _resisted(0, flip)


def _resisted_moment(flip: float) -> Statement:
    return _resisted(1, flip)


def _gust(flip: float) -> Statement:
    t = symbols("share number keep", "keep")
    now = gust.filtered(t["share"], t["number"], t["keep"])
    given = (
        *within(t["share"], 1), *within(t["number"], 1), at_least(t["keep"]), at_least(1, t["keep"])
    )  # fmt: skip
    return Statement(t, within(now, 1 if flip > 0 else 0.9), given)


CLAIMS = (
    ours(
        "lag.stepped",
        "a lag that holds a plant step's last value adds h Z1 + s Z1 <= what Z adds that rises "
        "with a = h e/(1 - e) and falls with b, and ends no higher, for every s in [a, b]",
        "What a lag in plant steps counts for: that of a slightly smaller time constant.",
        "e = exp(-h/tau_min); tau_min <= tau <= b, exponentials as symbols with exp(-h/a) <= "
        "exp(-h/tau_min) <= exp(-h/tau) <= exp(-h/b) < 1 and h <= b (exp(h/b) - 1)",
        _held,
    ),
    ours(
        "motor.step",
        "torque in steps is off by at most half a step",
        "What a motor's resolution adds to dbar.",
        "step > 0",
        _stepped,
    ),
    ours(
        "motor.dead-zone",
        "a dead zone takes at most its width, in the torque's direction",
        "What it adds to dbar.",
        "zone > 0",
        _zone,
    ),
    ours(
        "motor.line",
        "on the torque-speed line a torque up to tau misses at most the smaller of tau and "
        "d(s) = max(tau - stall (1 - s/free), 0), s the speed in its direction, if positive",
        "What a motor misses at a speed.",
        "stall > 0, 1/free >= 0, |torque| <= tau",
        _line,
    ),
    ours(
        "motor.thrust",
        "d(s) of both wheels together is largest at v1 = u1, |omega| = u2 where they drive one way",
        "What motors add to dbar, thrust.",
        "|v1| <= u1, l |omega| <= l u2; stall > 0, 1/free >= 0",
        _pair_ahead,
    ),
    ours(
        "motor.moment",
        "and there too where they drive opposite ways",
        "What motors add to dbar, moment.",
        "|v1| <= u1, l |omega| <= l u2; stall > 0, 1/free >= 0",
        _pair_around,
    ),
    ours(
        "slope",
        "a slope pulls with at most m g sin(angle), and turns with at most |offset| times that",
        "What a slope adds to dbar.",
        "m g sin(angle) >= 0; shares along and across of a unit vector",
        _slope,
        Z3(effort=150, points=(ALONG,)),
    ),
    ours(
        "resistance.thrust",
        "rolling resistance drives the robot on with at most the difference of the wheels'",
        "Equal wheels only brake; what one has more may push. Backwards by symmetry.",
        "|tanh| <= 1; tanh((v1 + l omega)/v_s) + tanh((v1 - l omega)/v_s) >= 0, as v1 >= 0 has it",
        _resisted_thrust,
    ),
    ours(
        "resistance.moment",
        "and turns it on with at most l times that",
        "The same for the turn.",
        "|tanh| <= 1; the difference of the two >= 0, as omega >= 0 has it",
        _resisted_moment,
    ),
    ours(
        "gust",
        "a filter's share of the size stays within [-1, 1]",
        "A gust never exceeds its stated size.",
        "share and number within [-1, 1], 0 <= keep <= 1",
        _gust,
    ),
)
