"""Rounding of the command filter: computed limits of clip and governor, and computed commands
within all limits, with and without a slew limit.

A computed number is any result of rounding each operation by at most 2^-53 of it (`rounded`), an
exponential by at most 2^-49.  V is the limit that the text aims at, the stated one less 2^-26: the
speed stays within V (1 + 2^-28).  F is the free distance from which on no command is limited; 2^-26
F is reserved for rounding.
"""

from typing import Any

from casadi import SX, expm1, fmax, fmin, logic_not, logic_or, vertsplit

from wmr_ctrl.control.filter import governor
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
from wmr_ctrl.control.filter.governor import FirstOrder, drive, largest_command, relaxed
from wmr_ctrl.control.filter.governor_step import contradiction
from wmr_ctrl.control.filter.ramp_stop import stopping_speed
from wmr_ctrl.control.filter.ways import Reached, Stop, farthest
from wmr_proofs.claim import Claims, Mutation
from wmr_proofs.statement import (
    UNIT,
    Cuts,
    Group,
    Named,
    Number,
    Relations,
    Statement,
    Symbols,
    between,
    nonnegative,
    positive,
    symbols,
    when,
    within,
)

from .command_filter import NUMBERS, sound

SLACK = 2.0**-28
"""Share of V by which the speed may be above its computed bound."""
LIBM = 2.0**-49
"""Largest relative error of a computed exponential, or of what is made of one."""
MARGIN = 32 * UNIT
PIECE = 2.0**-44
"""Share of V by which the speed may gain on its computed bound in a piece of time."""
OFF, AIMED_OFF = 64 * UNIT, 208 * UNIT
"""By what share of its way the base may go more or less than computed, in a piece that older
odometry divides, and by what share of V this may move it."""
A_PIECE = 2.0**-14
"""Least share of the way that the base goes while a command may act, for each piece of the time."""
claim = Claims(premises="assumption.libm")


def _numbers(further: str, fixed: str = "") -> tuple[Symbols, FirstOrder]:
    s = symbols(f"{NUMBERS} {further}", f"{NUMBERS} {fixed}".strip())
    return s, FirstOrder(**{name: s[name] for name in NUMBERS.split()})


def _computed(value: SX, exact: SX, off: Number = 0.0) -> Relations:
    """A computed exponential of a time whose relative error is ``off``."""
    return between((1 - LIBM) * exact - off, value, (1 + LIBM) * exact + off)


@claim("filter.rounding.clip")
def clip(mutation: Mutation) -> Statement:
    """(K_max hi + dbar) (1 + 2^-46) <= V for the hi that the clip's text computes, by a quotient
    or by 1/K_max.

    The clip's commands keep the stated limit to the last bit.

    Given: {INTERVALS}; V the stated limit; operations rounded by at most 2^-53.
    """
    s, b = _numbers("direct inverse")
    aimed = b.V * (1 - mutation(ROUNDING, -ROUNDING))
    top = largest_command(aimed, FirstOrder(aimed, b.dbar, b.nbar, b.K_min, b.K_max, SX(0)))
    computed = {"direct": top, "inverse": (aimed - b.dbar) * (1 / b.K_max)}
    goals = tuple((b.K_max * s[name] + b.dbar) * (1 + 2.0**-46) <= b.V for name in computed)
    return Statement(s, goals, (sound(b), aimed > b.dbar), computed=computed)


@claim("filter.rounding.target")
def target(mutation: Mutation) -> Statement:
    """the computed drive(u) misses K u + dbar by at most 2^-51 (|drive(u) - dbar| + dbar).

    The steady speed of a command is computed accurately enough.

    Given: {INTERVALS}; operations rounded by at most 2^-53.
    """
    s, b = _numbers("u target")
    exact = drive(s.u, b)
    most = mutation(4, 0.5) * UNIT * (abs(exact - b.dbar) + b.dbar)
    return Statement(s, within(s.target - exact, most), sound(b), computed={"target": exact})


@claim("filter.rounding.relaxed")
def carried_on(mutation: Mutation) -> Statement:
    """the computed relaxed(w, target) misses w + share (target - w) by at most 2^-48 V.

    The propagated bound is computed accurately enough.

    Given: |w| <= 2 V, 0 <= share <= 2, |share (target - w)| <= 8 V; operations rounded by at most
    2^-53.
    """
    s = symbols("V w target share next", "V")
    V, way = s.V, s.share * (s.target - s.w)
    given = V > 0, between(0, s.share, 2), within(s.w, 2 * V), within(way, 8 * V)
    goals = within(s.next - (s.w + way), mutation(1, 2.0**-6) * MARGIN * V)
    return Statement(s, goals, given, computed={"next": relaxed(s.w, s.target, s.share, s.share)})


@claim(
    "filter.rounding.piece",
    premises="filter.rounding.target filter.rounding.rim filter.rounding.relaxed",
    each={"rising": {"sign": 1, "goes": "most_as"}, "falling": {"sign": -1, "goes": "least_as"}},
)
def piece(mutation: Mutation, sign: int, goes: str) -> Statement:
    """v + share (mean - v) <= relaxed(w, target) - 2^-48 V + (1 - least) e + 2^-44 V.

    In any piece of time, however short, the computed bound becomes too small by at most 2^-44 V.

    Given: V > 0; e, d >= 0; w + e >= v, the speed; w, the computed bound; mean <= target + d, most
    d <= 2^-48 V, most |target| <= 4 V; 0 <= least <= share <= most <= 1, the computed shares within
    2^-49 of least and most, and off beyond; off <= 2^-47, off |target| <= 1.625 2^-46 V.
    """
    s = symbols("V w v d target mean share most least most_as least_as e off", "V")
    V, e, most, share = s.V, s.e, s.most, s.share
    following = relaxed(s.w, s.target, s.most_as, s.least_as)
    least = relaxed(s.w, s.target, s[goes], s[goes])
    given = (
        V > 0, between(0, s.least, most), most <= 1,
        _computed(s.most_as, most, s.off), _computed(s.least_as, s.least, s.off),
        between(0, s.off, OFF), within(s.off * s.target, AIMED_OFF * V),
        between(s.least, share, most), e >= 0, s.w + e >= s.v, within(s.w, 2 * V),
        s.d >= 0, most * s.d <= MARGIN * V, within(most * s.target, 4 * V),
        s.target + s.d >= s.mean, sign * (s.target - s.w) >= 0,
    )  # fmt: skip
    gained = (1 - s.least) * e + mutation(1, 2.0**-7) * PIECE * V
    reached = s.v + share * (s.mean - s.v)
    goals = following >= least, least - MARGIN * V + gained >= reached
    return Statement(s, goals, given)


@claim("filter.rounding.takeover")
def takeover(mutation: Mutation) -> Statement:
    """e v + (1 - e) mean <= V (1 + 2^-28) for the hi that the governor's text computes, by
    quotients or by 1/K_max.

    The computed limit also keeps the speed if its bound was propagated through n pieces of time.

    Given: {INTERVALS}; w + (2^-28 + 2 n 2^-44) V >= v, the speed; w, the computed bound, from -2 V
    to V; mean = K_max hi + dbar + d at most, (1 - e) d <= 2^-45 V; 1 <= n; e = exp(-H/tau_min) <= 1
    - n 2^-14, kappa within 2^-49 of e/(1 - e); operations rounded by at most 2^-53.
    """
    s, b = _numbers("w direct inverse v e d n")
    V, e, n = b.V, s.e, s.n
    known = s.w + mutation(1, 64) * (SLACK + 2 * n * PIECE) * V
    given = (
        sound(b), e > 0, 1 - n * A_PIECE >= e, n >= 1,
        _computed(b.kappa * (1 - e), e), b.kappa >= 0, known >= s.v, s.w <= V,
        s.w >= -2 * V, s.d >= 0, (1 - e) * s.d <= 2.0**-45 * V,
    )  # fmt: skip
    each = 1 / b.K_max
    by_it = (V - b.dbar) * each + b.kappa * each * (V - s.w)
    computed = {"direct": largest_command(s.w, b), "inverse": by_it}
    means = (b.K_max * s[name] + b.dbar + s.d for name in computed)
    goals = tuple(e * s.v + (1 - e) * mean <= V * (1 + SLACK) for mean in means)
    return Statement(s, goals, given, computed=computed)


@claim("filter.rounding.rim")
def rim(mutation: Mutation) -> Statement:
    """the computed drive(v + l omega) misses its own by at most 2^-50 (K_max (|v| + l |omega|) +
    dbar).

    The steady speed of a wheel under a command is computed accurately enough.

    Given: {INTERVALS}; l > 0; operations rounded by at most 2^-53.
    """
    s, b = _numbers("v omega l target", "l")
    exact = drive(Channel((1, 1), s.l, (b,), (1.0, 1.0)).of((s.v, s.omega)), b)
    size = abs(s.v) + s.l * abs(s.omega)
    goals = within(s.target - exact, mutation(8, 0.4) * UNIT * (b.K_max * size + b.dbar))
    return Statement(s, goals, (sound(b), s.l > 0), computed={"target": exact})


LOOKED_BACK = governor.Schedule(delay=(0.3, 0.7), losses=1, jitter=0.1, age=1.2)
"""Times for the structure of the pieces that odometry looks back through; others count alike."""


@claim("filter.rounding.rest")
def rest(mutation: Mutation) -> Statement:
    """the remaining time of a piece at -age, as computed, differs from end + age by at most 2^-52
    age; if the piece is treated as over or as whole, the error is at most 2^-52 age.

    Older odometry divides a piece of time at the right instant, except for rounding.

    Given: T > 0; 0 <= age <= 1.2 T, odometry's age; pieces of an example's schedule; operations
    rounded by at most 2^-53.
    """
    s = symbols("age T rest", "T")
    age, T = s.age, s.T
    pieces = LOOKED_BACK.pieces(-LOOKED_BACK.age, 0.0, 1)
    ends = {f"end{k}": piece.end * T for k, piece in enumerate(pieces)}
    starts = {"start": pieces[0].start * T}
    s |= symbols(" ".join((*ends, *starts)))
    left = governor.SpeedBound(LOOKED_BACK, FirstOrder(*[SX(1)] * 6), (SX(1), SX(1)), T)
    spare, goals = mutation(1, 2.0**-3) * 2 * UNIT * age, Group()
    for k, piece in enumerate(pieces):
        over, whole = -age >= s[f"end{k}"], -age <= s[f"end{k - 1}" if k else "start"]
        off = within(s.rest - (piece.end * T + age), spare)
        goals += when(logic_not(logic_or(over, whole)), off)
        goals.append(when(over, spare >= piece.end * T + age))
        goals.append(when(whole, piece.start * T + age >= -spare))
    given = T > 0, between(0, age, LOOKED_BACK.age * T)
    return Statement(s, goals, given, computed=ends | starts | {"rest": left.rest(age, pieces)})


@claim("filter.rounding.odometry")
def odometry(mutation: Mutation) -> Statement:
    """v <= min(y + nbar, V) + 2^-28 V, the sum as computed.

    A bound from odometry is too small by no more than a propagated one.

    Given: v <= y + nbar, |v| <= V (1 + 2^-28); operations rounded by at most 2^-53.
    """
    s, b = _numbers("v y sum")
    V, slack = b.V, SLACK * b.V
    given = V > 0, b.nbar >= 0, within(s.v, V + slack)
    goal = fmin(s.sum, V) + mutation(1, -1) * slack >= s.v
    return Statement(s, goal, (given, s.y + b.nbar >= s.v), computed={"sum": s.y + b.nbar})


@claim("filter.rounding.agrees")
def agrees(mutation: Mutation) -> Statement:
    """above + below >= -2^-15 V, as computed.

    Rounding alone never makes odometry contradict the stated bounds, even if all of them are only
    just met.

    Given: v <= above + (2^-28 + n 2^-44) V, -v <= below + (2^-28 + n 2^-44) V, above and below as
    computed and at most V; n <= 2^16; operations rounded by at most 2^-53.
    """
    s = symbols("V v above below n sum least", "V")
    V, off = s.V, (SLACK + s.n * PIECE) * s.V * mutation(1, 2**14)
    bounds = s.above + off >= s.v, s.below + off >= -s.v
    given = V > 0, s.n <= 2.0**16, s.n >= 0, s.above <= V, s.below <= V, bounds
    computed = {"sum": s.above + s.below, "least": -contradiction(V)}
    return Statement(s, s.sum >= s.least, given, computed=computed)


@claim("filter.rounding.free.way")
def way(mutation: Mutation) -> Statement:
    """x <= the computed farthest(w, m, t) + 1.25 2^-27 V t.

    In a piece of time the base moves hardly farther than computed.

    Given: v <= w + 2^-27 V, |w| and |m| <= 4 V; 0 <= A_least <= A <= A_most <= t, both computed to
    within 2^-49; x <= m t + (v - m) A; operations rounded by at most 2^-53.
    """
    s = symbols("t A least most least_as most_as V v w m x far")
    t, slack = s.t, 2 * SLACK * s.V
    given = (
        s.V > 0, between(0, s.least, s.A), between(s.A, s.most, t), s.w + slack >= s.v,
        within(s.w, 4 * s.V), within(s.m, 4 * s.V), _computed(s.least_as, s.least),
        _computed(s.most_as, s.most), s.m * t + (s.v - s.m) * s.A >= s.x,
    )  # fmt: skip
    computed = {"far": farthest(s.w, s.m, t, s.least_as, s.most_as)}
    return Statement(s, s.far + mutation(1.25, 0.5) * slack * t >= s.x, given, computed=computed)


class Line(Stop[SX]):
    """A stop with symbols for its room and for s and r of its line."""

    def room(self, free: SX) -> SX:
        """The room itself."""
        return free

    def line(self, instant: SX, tau: SX) -> tuple[SX, SX]:
        """Instant and time constant of the line, unchanged."""
        return instant, tau


@claim("filter.rounding.free.line")
def line(mutation: Mutation) -> Statement:
    """the computed s and r miss D - A + A_B q and A + A_B (1 - q) by at most 2^-46 (D + A_B).

    The line that limits a command by a distance is computed accurately enough.

    Given: tau > 0, 0 <= q <= 1, 0 <= A = tau q <= D, 0 <= A_B; q computed to within 2^-49;
    operations rounded by at most 2^-53.
    """
    t = symbols("tau acts last at q fading minus s r")
    D, A, none = t.acts + (t.last - t.at), t.tau * t.q, SX(0)
    s, r = Stop((t.tau, t.fading), none, None, t.acts, t.last, none).line(t.at, t.tau)
    most = mutation(1, 2.0**-8) * 2.0**-46 * (D + t.fading)
    given = (
        t.tau > 0, t.acts > 0, t.last >= t.at, t.fading >= 0,
        between(0, t.q, 1), D >= A, _computed(-t.minus, t.q),
    )  # fmt: skip
    exact = D - A + t.fading * t.q, A + t.fading * (1 - t.q)
    goals = within(t.s - exact[0], most), within(t.r - exact[1], most)
    return Statement(t, goals, given, {"minus": expm1(-D / t.tau)}, computed={"s": s, "r": r})


@claim("filter.rounding.free.command")
def command(mutation: Mutation) -> Statement:
    """way + r max(speed, d) + (K_max u + d) s <= room + 2^-46 F.

    A computed command satisfies its line, except for rounding.

    Given: 0 < K_max, s; 0 <= r, d, speed, way; way, r max(speed, d) <= F; |room| <= 4 F, all as
    computed; 0 <= u <= hi = ((room - way - r max(speed, d))/s - d)/K_max as computed; {ROUNDED}.
    """
    t, none = symbols("F K push room s r way speed u hi"), SX(0)
    F, K, push, room, s, r, way, speed, u, hi = t.values()
    stop = Line((r, r), push, None, none, none, none)
    made = (stop.steady(room, [Reached(s, way, speed)]) - push) / K
    led, most = r * fmax(speed, push), mutation(1, 2.0**-10) * 2.0**-46 * F
    given = (
        K > 0, s > 0, nonnegative(r, push, way, speed), way <= F,
        led <= F, within(room, 4 * F), between(0, u, hi),
    )  # fmt: skip
    need = way + led + (K * u + push) * s
    return Statement(t, room + most >= need, given, computed={"hi": made})


@claim("filter.rounding.free.ramp")
def ramp(mutation: Mutation) -> Statement:
    """w h + w^2/(2 A) <= (1 + 2^-48) room, w = K u.

    A base that slows down by A stops within its room, except for rounding of the command.

    Given: 0 < K, A, h; 0 <= room; 0 <= u <= hi = stopping_speed(room)/K as computed, where
    stopping_speed(room) = 2 room/(h + sqrt(h^2 + 2 room/A)); {ROUNDED}.
    """
    t = symbols("K A h room u hi")
    K, A, h, room, u, hi = t.values()
    w, most = K * u, 1 + mutation(1, 2.0**-5) * 2.0**-48
    given = positive(K, A, h), room >= 0, between(0, u, hi)
    goal = most * room >= w * h + w * w / (2 * A)
    return Statement(t, goal, given, computed={"hi": stopping_speed(room, h, A) / K})


BEYOND = 2.0**-50
"""Share of its limit by which roundings may carry v or omega beyond it."""
RIM = 2.0**-48
"""Share of the wheels' largest limit by which they may carry a wheel's speed beyond its own."""
OVER = 2.0**-29
"""Share of its limit by which rounding may carry a command that changes slowly beyond it."""
SLOWEST = 2.0**-20
"""Least change in a period of a command that changes slowly, as a share of its limit."""
command_claim = Claims(premises="assumption.libm")


class Limited(Named):
    """Symbols of v, omega and both wheels with their limits; ``on`` names those that are limited.

    ``body``: v and omega; ``wheels``; ``both``.  M is the largest limit of a wheel, in size;
    ``sent`` is what is computed of the command of both axes, ``ends`` are lo and hi of all
    channels, ``asked`` is that command with channels and ends.
    """

    def __init__(self, on: str, told: int = 1) -> None:
        """``told``: limits of each speed, 1 for both directions or 2; these may be 0."""
        arm, ones = SX.sym("p.l"), FirstOrder(*[SX(1)] * 6)
        axes = [Channel((1 - i, i), SX(1), (ones,) * told, (1.0, 1.0)) for i in AXES]
        sides = [Channel((1, way), arm, (ones,) * told, (1.0, 1.0)) for way in SIDES]
        self.channels = {"body": axes, "wheels": sides, "both": [*axes, *sides]}[on]
        places = range(1, len(self.channels) + 1)
        limits = " ".join(f"hi{i} lo{i}" for i in places)
        self.symbols = s = {"l": arm} | symbols(f"r0 r1 M v omega {limits}")
        self.ends = [s[f"lo{i}"] for i in places], [s[f"hi{i}"] for i in places]
        self.sent = [s.v, s.omega]
        self.asked = [s.r0, s.r1], self.channels, *self.ends

    @property
    def stated(self) -> Relations:
        """Hypotheses: l > 0, each limit on its side of 0, wheel limits at most M in size."""
        given = [self.l > 0]
        for channel, low, high in zip(self.channels, *self.ends, strict=True):
            for size in (high, -low):
                given.append(size > 0 if len(channel.sides) < 2 else size >= 0)
                given += [] if self.is_axis(channel) else [size <= self.M]
        return tuple(given)

    def is_axis(self, channel: Channel) -> bool:
        """True for v and omega."""
        return not all(channel.ways)

    def kept(self, command: list[SX], spare: float, axes: bool) -> Relations:
        """v and omega (``axes``), or the wheels, within their limits, except for ``spare``."""
        kept = Group()
        for channel, low, high in zip(self.channels, *self.ends, strict=True):
            if self.is_axis(channel) == axes:
                up, down = (high, -low) if axes else [self.M] * 2
                speed = channel.of(command)
                kept += [high + spare * up >= speed, speed >= low - spare * down]
        return tuple(kept)

    def computed(self, command: SX) -> Cuts:
        """Expressions of v and omega."""
        return {"v": command[0], "omega": command[1]}


SCALED: dict[str, dict[str, Any]] = {
    "wheels-curvature": {"on": "wheels", "scale": "curvature", "spare": RIM / 2},
    **{f"{on}-{scale}": {"on": on, "scale": scale, "spare": RIM}
       for on in ("body", "wheels", "both") for scale in ("turn", "drive")},
}  # fmt: skip


@command_claim("filter.rounding.scaled", each=SCALED)
def kept(mutation: Mutation, on: str, scale: str, spare: float) -> Statement:
    """of the command that is computed lo <= v, omega <= hi, and lo - e M <= v + l omega, v - l
    omega <= hi + e M, each where it is limited: e = 2^-49 for wheels that are limited by themselves
    and one factor, 2^-48 where omega or v goes first, whatever else is limited.

    v and omega keep their limits to the last bit, whichever has priority, and wheels keep theirs
    for any cancellation of v and l omega.

    Given: {SCALED_GIVEN} of v and omega, of the wheels, or of all, those of the wheels of at most M
    in size; {ROUNDED}.
    """
    a = Limited(on)
    if on == "both":  # before v and omega are cut
        sent = one_first(*a.asked, FIRST[scale])
    else:
        sent = scaled(*a.asked, scale)
    axes = a.kept(a.sent, mutation(0, -BEYOND), axes=True)
    goals = axes, a.kept(a.sent, mutation(1, 2.0**-6) * spare, axes=False)
    return Statement(a, goals, a.stated, computed=a.computed(sent))


@command_claim("filter.rounding.beside", each={"asked": {"cut": False}, "sent": {"cut": True}})
def beside(mutation: Mutation, cut: bool) -> Statement:
    """v and omega before they are cut are within (1 + 2^-50) of their limits, the wheels' speeds
    within 2^-49 M of theirs; of the command that is sent then, lo <= v, omega <= hi, and lo - 2^-48
    M <= v + l omega, v - l omega <= hi + 2^-48 M.

    One factor keeps v, omega and both wheels within their limits, but for roundings; v and omega
    that are cut at theirs take the wheels hardly further.

    Given: {BESIDE}; both axes scaled by one factor; {ROUNDED}.
    """
    a = Limited("both")
    asked = a.computed(stretched(*a.asked, "curvature"))

    def known(spare: float) -> Relations:
        """Limits before the cut, but for these shares of what roundings take."""
        kept = a.kept(a.sent, spare * RIM / 2, axes=False)
        return a.kept(a.sent, spare * BEYOND, axes=True), kept

    if not cut:
        return Statement(a, known(mutation(1, 2.0**-6)), a.stated, computed=asked)
    sent = vertsplit(scaled(*a.asked, "curvature"))
    goals = a.kept(sent, 0, axes=True), a.kept(sent, mutation(RIM, RIM / 2), axes=False)
    return Statement(a, goals, (a.stated, known(1)), asked)


@command_claim("filter.rounding.slew-limit")
def slew_limit(mutation: Mutation) -> Statement:
    """K hi (1 + 2^-29) + delta + a (1 + 2^-30) reach <= V for the hi that the text of the clip with
    slew computes, by a quotient or by 1/K.

    The margin covers the effect of rounding on commands and on their rate of change.

    Given: K > 0, delta, a, reach >= 0; V the stated limit; operations rounded by at most 2^-53.
    """
    s = symbols("V K delta slew reach direct inverse", "V K delta slew reach")
    V, K, dbar = s.V, s.K, s.delta + s.slew * s.reach
    aimed = V * (1 - mutation(ROUNDING, -ROUNDING))
    top = largest_command(aimed, FirstOrder(aimed, dbar, SX(0), K, K, SX(0)))
    computed = {"direct": top, "inverse": (aimed - dbar) * (1 / K)}
    added = s.delta + s.slew * (1 + 2.0**-30) * s.reach
    goals = tuple(K * s[name] * (1 + OVER) + added <= V for name in computed)
    signs = K > 0, nonnegative(s.delta, s.slew, s.reach)
    return Statement(s, goals, (signs, aimed > dbar), computed=computed)


def _slow(s: Symbols) -> Relations:
    """Hypothesis: previous and wanted command are within the limit, except for rounding."""
    hi = s.hi
    return hi > 0, within(s.last, hi * (1 + OVER)), within(s.wanted, hi * (1 + BEYOND))


@command_claim("filter.rounding.slew-kept")
def slew_kept(mutation: Mutation) -> Statement:
    """|u| <= hi (1 + 2^-29), u as the text computes it.

    The excess of slowly changing commands due to rounding does not grow with time.

    Given: |wanted| <= hi (1 + 2^-50); the command before within hi (1 + 2^-29); 2^-22 <= share <=
    1; operations rounded by at most 2^-53.
    """
    s = symbols("hi last wanted share sent")
    shares = between(mutation(2.0**-22, 0.0), s.share, 1)
    computed = {"sent": moved(s.last, s.wanted, s.share)}
    return Statement(s, within(s.sent, s.hi * (1 + OVER)), (_slow(s), shares), computed=computed)


@command_claim("filter.rounding.slew-step")
def slew_step(mutation: Mutation) -> Statement:
    """|u - u_before| <= a T (1 + 2^-30), the axis' own share >= 2^-22, as the text computes them.

    Commands change no faster than the clip with slew assumes.

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
