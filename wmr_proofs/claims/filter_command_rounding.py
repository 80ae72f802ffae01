"""Rounding of the command filter: commands brought inside all limits, at once or slowly.

A computed number is any result of rounding each operation by at most 2^-53 of it (`rounded`).
"""

from typing import Any

import casadi as ca

from wmr_ctrl.control.filter.channels import (
    AXES,
    FIRST,
    ROUNDING,
    Channel,
    one_first,
    scaled,
    stretched,
)
from wmr_ctrl.control.filter.channels import WAYS as SIDES
from wmr_ctrl.control.filter.clip import moved, ramp_shares
from wmr_ctrl.control.filter.governor import FirstOrder, largest_command
from wmr_proofs.claim import Claims, Mutation
from wmr_proofs.methods.spec import Z3
from wmr_proofs.statement import (
    Cuts,
    Named,
    Relations,
    Statement,
    Symbols,
    between,
    nonnegative,
    positive,
    symbols,
    within,
)

BEYOND = 2.0**-50
"""Share of its limit by which roundings may carry v or omega beyond it."""
RIM = 2.0**-48
"""Share of the wheels' largest limit by which they may carry a wheel's speed beyond its own."""
OVER = 2.0**-29
"""Share of its limit by which rounding may carry a command that changes slowly beyond it."""
SLOWEST = 2.0**-20
"""Least change in a period of a command that changes slowly, as a share of its limit."""
claim = Claims(by=Z3(), premises="assumption.libm")


class Limited(Named):
    """Symbols of v, omega and both wheels with their limits; ``on`` names those that are limited.

    ``body``: v and omega; ``wheels``; ``both``.  M is the largest limit of a wheel, in size;
    ``asked`` is the command of both axes, ``sent`` what is computed of it, ``ends`` are lo and hi
    of all channels.
    """

    def __init__(self, on: str) -> None:
        arm, ones = ca.SX.sym("p.l"), FirstOrder(*[ca.SX(1)] * 6)
        axes = [Channel((1 - i, i), ca.SX(1), (ones,), (1.0, 1.0)) for i in AXES]
        sides = [Channel((1, way), arm, (ones,), (1.0, 1.0)) for way in SIDES]
        self.channels = {"body": axes, "wheels": sides, "both": [*axes, *sides]}[on]
        numbers = range(1, len(self.channels) + 1)
        limits = " ".join(f"hi{i} lo{i}" for i in numbers)
        self.symbols = s = {"l": arm} | symbols(f"r0 r1 M v omega {limits}")
        self.ends = [s[f"lo{i}"] for i in numbers], [s[f"hi{i}"] for i in numbers]
        self.asked, self.sent = [s.r0, s.r1], [s.v, s.omega]

    @property
    def stated(self) -> Relations:
        """Hypotheses: l > 0, each limit on its side of 0, wheel limits at most M in size."""
        given = [self.l > 0]
        for channel, low, high in zip(self.channels, *self.ends, strict=True):
            for size in (high, -low):
                given.append(size > 0)
                given += [] if self.is_axis(channel) else [size <= self.M]
        return tuple(given)

    def is_axis(self, channel: Channel) -> bool:
        """True for v and omega."""
        return not all(channel.ways)

    def kept(self, command: list[ca.SX], spare: float, axes: bool) -> Relations:
        """v and omega (``axes``), or the wheels, within their limits, except for ``spare``."""
        kept = list[Relations]()
        for channel, low, high in zip(self.channels, *self.ends, strict=True):
            if self.is_axis(channel) == axes:
                up, down = (high, -low) if axes else [self.M] * 2
                speed = channel.of(command)
                kept += [high + spare * up >= speed, speed >= low - spare * down]
        return tuple(kept)

    def computed(self, command: ca.SX) -> Cuts:
        """Expressions of v and omega."""
        return {"v": command[0], "omega": command[1]}


SCALED: dict[str, dict[str, Any]] = {
    "wheels-curvature": {"on": "wheels", "scale": "curvature", "spare": RIM / 2},
    **{f"{on}-{scale}": {"on": on, "scale": scale, "spare": RIM}
       for on in ("body", "wheels", "both") for scale in ("turn", "drive")},
}  # fmt: skip


@claim(
    "filter.rounding.scaled",
    each=SCALED,
)
def kept(mutation: Mutation, on: str, scale: str, spare: float) -> Statement:
    """of the command that is computed lo <= v, omega <= hi, and lo - e M <= v + l omega, v - l
    omega <= hi + e M, each where it is limited: e = 2^-49 for wheels that are limited by themselves
    and one factor, 2^-48 where omega or v goes first, whatever else is limited.

    v and omega keep their limits to the last bit, whichever goes first, and wheels keep theirs
    however v and l omega cancel.

    Given: {SCALED_GIVEN} of v and omega, of the wheels, or of all, those of the wheels of at most M
    in size; {ROUNDED}.
    """
    a = Limited(on)
    if on == "both":  # before v and omega are cut
        sent = one_first(a.asked, a.channels, *a.ends, FIRST[scale])
    else:
        sent = scaled(a.asked, a.channels, *a.ends, scale)
    axes = a.kept(a.sent, mutation(0, -BEYOND), axes=True)
    goals = axes, a.kept(a.sent, mutation(1, 2.0**-6) * spare, axes=False)
    return Statement(a, goals, a.stated, computed=a.computed(sent))


@claim("filter.rounding.beside")
def beside(mutation: Mutation) -> Statement:
    """v and omega before they are cut are within (1 + 2^-50) of their limits, the wheels' speeds
    within 2^-49 M of theirs.

    One factor keeps v, omega and both wheels within their limits.

    Given: {BESIDE}; both axes scaled by one factor; {ROUNDED}.
    """
    a = Limited("both")
    made = stretched(a.asked, a.channels, *a.ends, "curvature")
    spare = mutation(1, 2.0**-6)
    goals = a.kept(a.sent, spare * BEYOND, axes=True), a.kept(a.sent, spare * RIM / 2, axes=False)
    return Statement(a, goals, a.stated, computed=a.computed(made))


@claim(
    "filter.rounding.beside-cut",
    premises="filter.rounding.beside",
)
def beside_cut(mutation: Mutation) -> Statement:
    """lo <= v, omega <= hi; lo - 2^-48 M <= v + l omega, v - l omega <= hi + 2^-48 M, of the
    command that is sent.

    v and omega that are cut at their limits take the wheels no further beyond theirs than
    roundings.

    Given: {BESIDE}; v and omega before they are cut as in filter.rounding.beside.
    """
    a = Limited("both")
    made = stretched(a.asked, a.channels, *a.ends, "curvature")
    sent = ca.vertsplit(scaled(a.asked, a.channels, *a.ends, "curvature"))
    known = a.kept(a.sent, BEYOND, axes=True), a.kept(a.sent, RIM / 2, axes=False)
    spare = mutation(RIM, RIM / 2)
    goals = a.kept(sent, 0, axes=True), a.kept(sent, spare, axes=False)
    return Statement(a, goals, (a.stated, known), a.computed(made))


@claim(
    "filter.rounding.slew-limit",
)
def slew_limit(mutation: Mutation) -> Statement:
    """K hi (1 + 2^-29) + delta + a (1 + 2^-30) reach <= V for the hi that the text of the clip of
    slow commands computes, by a quotient or by 1/K.

    The margin covers what rounding adds to commands and to how fast they change.

    Given: K > 0, delta, a, reach >= 0; V the stated limit; operations rounded by at most 2^-53.
    """
    s = symbols("V K delta slew reach direct inverse", "V K delta slew reach")
    V, K, dbar = s.V, s.K, s.delta + s.slew * s.reach
    aimed = V * (1 - mutation(ROUNDING, -ROUNDING))
    top = largest_command(aimed, FirstOrder(aimed, dbar, ca.SX(0), K, K, ca.SX(0)))
    computed = {"direct": top, "inverse": (aimed - dbar) * (1 / K)}
    added = s.delta + s.slew * (1 + 2.0**-30) * s.reach
    goals = tuple(K * s[name] * (1 + OVER) + added <= V for name in computed)
    signs = K > 0, nonnegative(s.delta, s.slew, s.reach)
    return Statement(s, goals, (signs, aimed > dbar), computed=computed)


def _slow(s: Symbols) -> Relations:
    """Hypothesis: previous and wanted command are within the limit, except for rounding."""
    hi = s.hi
    wanted = within(s.wanted, hi * (1 + BEYOND))
    return hi > 0, within(s.last, hi * (1 + OVER)), wanted


@claim(
    "filter.rounding.slew-kept",
)
def slew_kept(mutation: Mutation) -> Statement:
    """|u| <= hi (1 + 2^-29), u as the text computes it.

    Rounding carries commands that change slowly no further beyond their limit with time.

    Given: |wanted| <= hi (1 + 2^-50); the command before within hi (1 + 2^-29); 2^-22 <= share <=
    1; operations rounded by at most 2^-53.
    """
    s = symbols("hi last wanted share sent")
    shares = between(mutation(2.0**-22, 0.0), s.share, 1)
    goals = within(s.sent, s.hi * (1 + OVER))
    computed = {"sent": moved(s.last, s.wanted, s.share)}
    return Statement(s, goals, (_slow(s), shares), computed=computed)


@claim(
    "filter.rounding.slew-step",
)
def slew_step(mutation: Mutation) -> Statement:
    """|u - u_before| <= a T (1 + 2^-30), the axis' own share >= 2^-22, as the text computes them.

    Commands change no faster than the clip of slow commands counts on.

    Given: as in filter.rounding.slew-kept; a T >= 2^-20 hi; 0 <= share <= the axis' own share.
    """
    s = symbols("hi last wanted share sent own slew T", "slew T")
    most = s.slew * s.T
    (own,) = ramp_shares(s.last, s.wanted, most)
    quick = most >= mutation(1, 2.0**-10) * SLOWEST * s.hi, s.own >= s.share
    given = _slow(s), positive(s.slew, s.T), s.share >= 0, quick
    goals = within(s.sent - s.last, most * (1 + 2.0**-30)), s.own >= 2.0**-22
    computed = {"own": own, "sent": moved(s.last, s.wanted, s.share)}
    return Statement(s, goals, given, computed=computed)
