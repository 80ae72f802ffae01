"""The command filter: its limit on bases with a first-order speed loop; 0 is never refused.

At the end the filter's own graph, from odometry to command, as it is compiled and exported.

One axis, all numbers symbols.  tau, K and d may vary while a command acts, so the speed is v(t) =
E v_0 + (1 - E) m with E = exp(-int dt/tau) and m a mean of K u + d (filter.mean).
"""

from dataclasses import replace
from fractions import Fraction
from itertools import product
from typing import TypeAlias

from casadi import SX, expm1, fmax, fmin, if_else, logic_or

from wmr_ctrl.control.filter import governor
from wmr_ctrl.control.filter.channels import TINY, WAYS, Channel, two_sided
from wmr_ctrl.control.filter.governor import NEAR, FirstOrder, drive, drive_back, largest_command
from wmr_ctrl.control.filter.governor_step import Governor
from wmr_ctrl.world.scenario import load_scenario
from wmr_proofs.claim import CLAIMED, Claims, Mutation
from wmr_proofs.methods.spec import Z3
from wmr_proofs.statement import (
    Cuts,
    Group,
    Named,
    Relations,
    Statement,
    between,
    instance,
    listed,
    positive,
    symbols,
    valued,
    when,
)

from .common import elements_of, ports_of

NUMBERS = "V dbar nbar K_min K_max kappa"


claim = Claims()


def sound(b: FirstOrder) -> Relations:
    """0 < K_min <= K_max, 0 <= dbar < V."""
    return _signs(b), b.dbar < b.V


def admits(b: FirstOrder) -> Relations:
    """0 < K_min <= K_max, 0 <= dbar <= V."""
    return _signs(b), b.dbar <= b.V


def _signs(b: FirstOrder) -> Relations:
    return b.K_min > 0, b.K_max >= b.K_min, b.dbar >= 0


class FilterAxis(Named):
    """Symbols of one axis: the filter's numbers, a command, and the base's response.

    e is exp(-H/tau_min), E the share of the old speed that is left.
    """

    def __init__(self) -> None:
        self.symbols = symbols(f"{NUMBERS} u v v_bar K d mean E e", NUMBERS)
        self.bounds = FirstOrder(**{name: self[name] for name in NUMBERS.split()})

    @property
    def hi(self) -> SX:
        """Largest command that is safe."""
        return largest_command(self.v_bar, self.bounds)

    @property
    def relaxing(self) -> Relations:
        """0 < e <= E <= 1 and kappa = e/(1 - e), e < 1."""
        e = self.e
        return e > 0, e < 1, between(e, self.E, 1), self.kappa * (1 - e) == e


@claim("filter.drive")
def driven(mutation: Mutation) -> Statement:
    """K u + d <= drive(u) = max(K_min u, K_max u) + dbar <= max(K_max u, 0) + dbar for every u;
    likewise for -u and drive_back(u) = drive(-u).

    The steady speed of a command for the worst gain and push.

    Given: {ANY_SIDE}.
    """
    a = FilterAxis()
    given = admits(a.bounds), between(a.K_min, a.K, a.K_max), a.dbar >= mutation(1, 0.9) * a.d
    u, b, reached = a.u, a.bounds, a.K * a.u
    ahead, back = drive(u, b), drive_back(u, b)
    most = highest(u, b) >= ahead, highest(-u, b) >= back
    return Statement(a, (ahead >= reached + a.d, back >= a.d - reached, most), given)


def highest(u: SX, b: FirstOrder) -> SX:
    """Bound of drive(u)."""
    return fmax(b.K_max * u, 0) + b.dbar


@claim("filter.inside")
def inside(mutation: Mutation) -> Statement:
    """E v + (1 - E) mean <= V.

    A command that takes over at a speed of at most v_bar keeps the base within its limit for as
    long as it may act.

    Given: {ANY_SIDE}; v <= v_bar <= V; mean <= drive(u) (filter.drive), u <= hi(v_bar) = (V - dbar
    + kappa (V - v_bar))/K_max; e <= E <= 1 with e = exp(-H/tau_min) < 1, kappa = e/(1 - e).
    """
    a = FilterAxis()
    b, E = a.bounds, a.E
    known = a.v_bar >= a.v, mutation(1, 0.99) * a.v_bar <= b.V
    sent = a.hi >= a.u, drive(a.u, b) >= a.mean
    goal = E * a.v + (1 - E) * a.mean <= b.V
    return Statement(a, goal, (admits(a.bounds), a.relaxing, known, sent))


@claim("filter.contains-clip")
def contains_clip(mutation: Mutation) -> Statement:
    """hi(v_bar) >= (V - dbar)/K_max >= 0, with equality for v_bar = V.

    The governor is never stricter than the clip, and never refuses to stop: 0 is always safe.

    Given: {ANY_SIDE}; v_bar <= V, kappa >= 0; hi as in filter.inside.
    """
    a = FilterAxis()
    b = a.bounds
    smallest = (b.V - b.dbar) / b.K_max
    given = admits(a.bounds), mutation(1, 0.99) * a.v_bar <= b.V, b.kappa >= 0
    goals = a.hi >= smallest, smallest >= 0, largest_command(b.V, b) == smallest
    return Statement(a, goals, given)


@claim("filter.necessary")
def necessary(mutation: Mutation) -> Statement:
    """e v_bar + (1 - e)(K_max u + dbar) > V.

    No larger command is safe for the base with the largest gain, the smallest time constant and the
    largest push.

    Given: {ANY_SIDE}; 0 <= u, hi(v_bar) < u; e = exp(-H/tau_min) < 1, kappa = e/(1 - e); hi as in
    filter.inside.
    """
    a = FilterAxis()
    b, e = a.bounds, a.e
    given = admits(a.bounds), a.relaxing, a.u > mutation(1, 0.99) * a.hi, a.u >= 0
    end = e * a.v_bar + (1 - e) * (b.K_max * a.u + b.dbar)
    return Statement(a, end > b.V, given)


@claim("filter.estimate")
def estimate(mutation: Mutation) -> Statement:
    """v + share (mean - v) <= relaxed(w, target).

    The speed bound that is propagated from sample to sample remains a bound.

    Given: v <= w, mean <= target, 0 <= least <= share <= most <= 1 (least = 1 - exp(-t/tau_max),
    most = 1 - exp(-t/tau_min)); relaxed(w, target) = w + max(most (target - w), least (target -
    w)).
    """
    t = symbols("v w mean target least share most")
    v, w, mean, target, least, share, most = t.values()
    shares = between(mutation(1, 0.9) * least, share, most), most <= 1
    goal = governor.relaxed(w, target, most, least) >= v + share * (mean - v)
    return Statement(t, goal, (w >= v, target >= mean, least >= 0, shares))


@claim("filter.curvature")
def curvature(mutation: Mutation) -> Statement:
    """0 < eta <= 1 and lo_i <= eta r_i <= hi_i with eta the smaller of both axes' shares.

    One factor scales both axes, so omega/v stays as requested.

    Given: lo_i < 0 < hi_i; both axes' commands r_i of any size; an axis' share is a/max(|r_i|, a)
    with a = hi_i for r_i >= 0 and -lo_i else.
    """
    t = symbols("r1 lo1 hi1 r2 lo2 hi2")
    r, lo, hi = ([t[f"{name}{i}"] for i in (1, 2)] for name in ("r", "lo", "hi"))
    eta = mutation(1, 1.01) * fmin(*governor.admitted(r, lo, hi))
    goals = [eta > 0, eta <= 1]
    goals += [hi[i] >= eta * r[i] for i in (0, 1)]
    goals += [eta * r[i] >= lo[i] for i in (0, 1)]
    return Statement(t, goals, positive(*hi, *(-item for item in lo)))


STATED = {
    "filter.kind": "governor", "filter.tau": ((0.2, 0.3), (0.1, 0.4)),
    "filter.gain": ((0.9, 1.1), (0.8, 1.2)), "filter.d": (0.05, 0.05),
    "filter.odometry": (0.02, 0.02),
}  # fmt: skip
"""Settings for the assembled graph's structure; its numbers are symbols all the same.

Bounds of v and of omega, each for itself: one interval for both is the case in which they agree.
"""
ALIKE = {"filter.tau": (0.2, 0.3), "filter.gain": (0.9, 1.1)}
"""What takes their place for wheels, whose loops are alike."""
Keys: TypeAlias = dict[str, object]
"""Keys of a scenario."""
WHEELED: Keys = {"filter.channels": "wheels", **ALIKE}
BESIDE: Keys = {"filter.wheel_speed": 1.0, **ALIKE}
SHAPES = {
    f"{key} {scale}": {"more": {**more, "filter.scale": scale}}
    for key, more, scales in (
        ("axes", {}, ("curvature", "axes", "turn", "drive")),
        ("wheels", WHEELED, ("curvature", "turn", "drive")),
        ("beside", BESIDE, ("turn", "drive")),
    )
    for scale in scales
}
"""Limited speeds, and ways to scale a command.

One factor beside limits of wheels is in filter.rounding.beside.
"""
BY_SIDE: Keys = {"limits.v_min": (-0.5, -1.0), "limits.v_max": (1.0, 1.5)}
"""A limit of each direction, every one a symbol of its own."""
LATE: dict[str, Keys] = {
    "late": {"filter.delay": (0.0, 0.013), "filter.losses": 1, "filter.jitter": 0.002,
             "filter.age": 0.02, "filter.hold": 0.05},
}  # fmt: skip
"""Commands and samples that come at other times."""
SEEN: dict[str, Keys] = {"": {}, " without odometry": {"filter.odometry": None}}
LIMITS = SEEN | {" by direction": BY_SIDE}
"""One limit for both directions of an axis, with odometry or none, or a limit for each."""
SIDES = {
    f"{name}-{way}{told}": {"side": side, "axis": axis, "told": limits}
    for told, limits in LIMITS.items()
    for axis, name in enumerate(("linear", "angular"))
    for side, way in enumerate(("forwards", "backwards"))
}


def limited(b: FirstOrder, told: Keys) -> Relations:
    """What a governor requires of limits that are ``told`` by direction, or of one for both."""
    return (admits if told == BY_SIDE else sound)(b)


class AssembledStep(Named):
    """One axis and direction of the filter's own graph, as it is compiled and exported.

    Its exponentials are free numbers between 0 and 1.  ``limit``: the largest command that it
    admits; ``slow``: 0 < tau_min <= tau_max.
    """

    def __init__(self, side: int, axis: int, told: Keys) -> None:
        """Read the graph of the step."""
        self.graph = Governor(load_scenario("paper-simulation", STATED | told))
        self.told, self.side, self.axis, self.way = told, side, axis, WAYS[side]
        self.free = symbols("v u E mean share kappa gone")
        self.symbols = self.free | elements_of(*ports_of(self.graph.system))
        self.limit = self.graph.limits[side][axis]
        self.channel = two_sided(self.graph.channels)[axis]
        self.bounds = self.channel.sides[side]
        T, (low, high) = self.graph.T, self.graph.motions[side][axis].tau
        self.slow = low > 0, high >= low
        self.cuts = {"1/(exp(T/tau_min) - 1)": 1 / expm1(T / low)}
        self.cuts |= {"-most": expm1(-T / low), "-least": expm1(-T / high)}

    def given(self, mutation: Mutation, target: SX) -> Relations:
        """Hypotheses on base, speed, odometry and exponentials; the mean under a command.

        Odometry, if there is any, is as stated; so are the stored bounds, if the sample came in
        time.
        """
        graph, axis, f = self.graph, self.axis, self.free
        b, v, y = self.bounds, f.v, graph.odometry.sym[axis]
        ahead, back = (own.V for own in self.channel.sides)
        kappa, most, least = self.cuts.values()
        up, down = (known.sym[axis] for known in graph.known)
        error = mutation(1, 1.01) * b.nbar
        elapsed = graph.elapsed.sym
        timely = logic_or(elapsed == 0, abs(elapsed - graph.T) <= NEAR * graph.T)
        return (
            [limited(own, self.told) for own in self.channel.sides], ahead >= v, back >= -v,
            b.nbar >= 0, f.kappa == kappa,
            f.gone == most, f.kappa > 0, -f.kappa * f.gone == 1 + f.gone,
            -least > 0, least >= most, 1 + most > 0,
            when(timely, (up >= v, down >= -v)),
            when(graph.seen, (error >= y - v, error >= v - y)),
            between(1 + most, f.E, 1), graph.T > 0, target >= f.mean,
        )  # fmt: skip


@claim("filter.limits", each={name or "one": {"told": told} for name, told in LIMITS.items()})
def limits(mutation: Mutation, told: Keys) -> Statement:
    """the largest command that the whole filter admits is at least 0, on either axis, either way,
    and above 0 where dbar < V.

    Stopping is always allowed, and so is driving if a push leaves room for it.

    Given: 0 < K_min <= K_max, 0 <= dbar <= V each way, V {LESS}; or dbar < V, one limit for both
    ways less 2^-26 of it; 0 < tau_min <= tau_max of each axis, T > 0; any odometry of the sample or
    none, any time since the last one; v and omega limited; no delay, jitter or losses, H = T;
    {PLAIN}.
    """
    cuts = Cuts()
    graph = Governor(load_scenario("paper-simulation", STATED | told))
    goals, given = Group(), Group()
    for axis, channel in enumerate(two_sided(graph.channels)):
        (low, high), name = graph.motions[0][axis].tau, ("linear", "angular")[axis]
        growth = expm1(graph.T / low)
        kappa = 1 / growth
        cuts |= {f"kappa {name}": kappa, f"-most {name}": expm1(-graph.T / low)}
        cuts[f"-least {name}"] = expm1(-graph.T / high)
        given += [positive(low, high, growth, kappa)]
        for side, b in zip(graph.limits, channel.sides, strict=True):
            given.append(limited(b, told))
            goals.append(side[axis] >= mutation(0, b.V))
            goals.append(if_else(b.dbar < b.V, side[axis], 1) > 0)
    return Statement(elements_of(*ports_of(graph.system)), goals, given, cuts)


def arms(channels: list[Channel]) -> Relations:
    """The half track of each wheel is positive."""
    return positive(*(channel.arm for channel in channels if channel.ways[1]))


@claim(
    "filter.sent",
    premises="filter.limits",
    each={
        f"{name}{key}": {"told": told, **shape}
        for key, told in (("", {}), (" by direction", BY_SIDE))
        for name, shape in SHAPES.items()
    }
    | {name: {"told": {}, "more": more} for name, more in (LATE | SEEN).items() if name},
)
def sent(mutation: Mutation, more: Keys, told: Keys) -> Statement:
    """|w| is at most the step's limit, either way, w each limited speed of the command that the
    whole governor sends, for any request on both axes: v and omega, both wheels, or all of
    these, in each way to scale but one factor beside wheels.

    Nothing bypasses the filter, whichever speeds it limits and however it scales.

    Given: {COMMANDS}, any odometry or none, any time since the last sample; l > 0; the limits above
    0 (filter.limits) or, if v and omega have one of each direction, theirs at least 0 and those of
    wheels above 0, at least 1e-30 with one factor; odometry of the sample and no other times than a
    period, or, of v and omega with one factor and one limit for both directions, delay, age,
    losses, jitter and hold; {PLAIN}.
    """
    graph = Governor(load_scenario("paper-simulation", STATED | told | more))
    given: list[Relations] = [arms(graph.channels)]
    cuts, goals = {"numbers are sound": graph.sound}, Group()
    for side, way in enumerate(WAYS):
        for i, (channel, limit) in enumerate(zip(graph.channels, graph.limits[side], strict=True)):
            cuts[f"limit {side} {i}"] = limit
            by_side = told == BY_SIDE, all(channel.ways)
            given.append(limit >= 0 if by_side == (True, False) else limit > 0)
            given += [limit >= TINY] * all((*by_side, "curvature" in more.values()))
            most = mutation(1, 0.99) * limit
            goals += [most >= way * channel.of(command) for command in (graph.sent, graph.safe)]
    return Statement(elements_of(*ports_of(graph.system)), goals, given, cuts)


@claim("filter.assembled", premises="filter.sent", each=SIDES)
def assembled(mutation: Mutation, side: int, axis: int, told: Keys) -> Statement:
    """on each axis, forwards and backwards: E v + (1 - E) mean <= V under every command u that the
    whole filter admits.

    The exported filter, from odometry to command, keeps the base within V.

    Given: {ASSEMBLED}; u at most the step's limit (filter.sent), mean <= drive(u); exp(-T/tau_min)
    <= E <= 1.
    """
    step = AssembledStep(side, axis, told)
    u, E = step.free.u, step.free.E
    given = step.given(mutation, drive(u, step.bounds)), step.limit >= u
    end = E * step.way * step.free.v + (1 - E) * step.free.mean
    return Statement(step, end <= step.bounds.V, given, step.cuts)


def tight(side: int, axis: int) -> tuple[dict[str, Fraction], ...]:
    """Points at which the next stored bound is as low as it may be.

    They are, in this order: driven up and down from a stored bound, from odometry, from the limit
    after a late sample, and from a stored bound without odometry.
    """
    own, other, way = axis + 1, 2 - axis, WAYS[side]
    names = ("v_above", "v_below") if side == 0 else ("v_below", "v_above")
    V = 1 - Fraction(2) ** -26
    rows = (  # speed, its bounds on both sides, odometry and its age, target, share, elapsed
        ("1/2", "1/2", "-1/2", "1/2", -1, 1, "1/2", 0),
        ("1/2", "1/2", "-1/2", "1/2", -1, 0, "1/4", 0),
        ("1/2", "3/4", 1, "2/5", 0, 1, "1/2", 1),
        (V, 0, 0, V, -1, "1/4", "1/4", 8),
        ("1/2", "1/2", 1, -1, -1, 1, "1/2", 0),
    )
    known = {
        "clock.control.1": 1, "limits.v_max.1": 1, "limits.v_max.2": 1, "limits.v_min.1": -1,
        "limits.v_min.2": -1, "limits.v_u1.1": 1, "limits.v_u1.2": 1, "filter.odometry.1": "1/10",
        "filter.odometry.2": "1/10", "filter.d.1": "1/8", "filter.d.2": "1/8",
        **dict.fromkeys((f"filter.{key}.{i}" for key in ("tau", "gain") for i in range(1, 5)), 1),
        f"v_asked.{other}": 0,
        "kappa": 1, "1/(exp(T/tau_min) - 1)": 1, "gone": "-1/2", "-most": "-1/2", "-least": "-1/4",
        "E": "1/2", f"v_odometry.{other}": 0, f"v_above.{other}": 1, f"v_below.{other}": 1,
    }  # fmt: skip
    return tuple(
        {name: Fraction(str(value)) for name, value in (known | {
            "v": way * Fraction(str(v)), f"{names[0]}.{own}": up, f"{names[1]}.{own}": down,
            f"v_odometry.{own}": way * Fraction(str(y)), "odometry_age.1": age,
            "elapsed.1": elapsed, "mean": target, "driven towards": target, "share": share,
            **dict.fromkeys(
                (f"v_asked.{own}", "sent command"), way * (Fraction(str(target)) - Fraction(1, 8))
            ), "other command": 0,
        }).items()}
        for v, up, down, y, age, target, share, elapsed in rows
    )  # fmt: skip


@claim(
    "filter.carried",
    premises="filter.sent filter.drive",
    by=Z3(
        points=[point for side, axis in product(range(2), repeat=2) for point in tight(side, axis)]
    ),
    each=SIDES,
)
def carried(mutation: Mutation, side: int, axis: int, told: Keys) -> Statement:
    """on each axis, forwards and backwards: v + share (mean - v) <= the whole filter's next stored
    bound, for 1 - exp(-T/tau_max) <= share <= 1 - exp(-T/tau_min).

    The memory of the exported filter bounds the speed at the next sample.

    Given: {ASSEMBLED}; u, what is sent, at most the step's limit (filter.sent), mean <= drive(u).
    """
    step = AssembledStep(side, axis, told)
    v, share, (_, most, least) = step.way * step.free.v, step.free.share, step.cuts.values()
    sent, b = step.way * step.graph.safe[axis], step.bounds
    target = (drive, drive_back)[side](step.graph.safe[axis], b)
    within = step.limit >= sent, between(-least, share, -most)
    given = step.given(mutation, target), within, step.slow, highest(sent, b) >= target
    end = v + share * (step.free.mean - v)
    commands = {"sent command": step.graph.safe[axis], "other command": step.graph.safe[1 - axis]}
    cuts = step.cuts | commands | {"driven towards": target}
    return Statement(step, step.graph.following[side][axis] >= end, given, cuts)


@claim(
    "filter.step",
    premises="filter.drive filter.limits filter.sent filter.assembled filter.carried",
    each=SIDES,
)
def induced(mutation: Mutation, side: int, axis: int, told: Keys) -> Statement:
    """I at a sample implies I at the next one, for any request: on each axis, forwards and
    backwards, E v + (1 - E) mean <= V until then, and at that time it is at most the filter's next
    stored bound.

    One step of the induction over samples (filter.mean), with the command sent, the speed and the
    memory together.

    Given: I: {ASSEMBLED}; mean <= drive(u), u what is sent; exp(-T/tau_min) <= E <= 1, and E <=
    exp(-T/tau_max) at the next sample.
    """
    step = AssembledStep(side, axis, told)
    free, graph, share, least = step.free, step.graph, 1 - step.free.E, step.cuts["-least"]
    safe, kept = graph.safe[axis], graph.following[side][axis]
    values = {"u": step.way * safe, "share": share}
    taken, known = [], limits(CLAIMED, told)
    allowed, k = sent(CLAIMED, {}, told), 4 * side + 2 * axis
    for part in (
        replace(allowed, goals=listed(allowed.goals)[k : k + 2]),
        *(item(CLAIMED, side, axis, told) for item in (assembled, carried)),
        known,
    ):
        own = {name: step.symbols[name] for name in part.symbols if name in step.symbols}
        taken.append(instance(part, own | values if "u" in own else own))
    cuts = step.cuts | {"sent command": safe, "other command": graph.safe[1 - axis], "kept": kept}
    cuts |= {f"limit {s} {i}": graph.limits[s][i] for s, i in product(range(2), repeat=2)}
    end = free.E * step.way * free.v + share * free.mean
    sound_numbers = valued(known.given, known.symbols, own)  # the last part's
    target = (drive, drive_back)[side](safe, step.bounds)
    given = step.given(CLAIMED, target), step.slow, taken, sound_numbers
    goals = (mutation(1, 0.99) * step.bounds.V >= end, when(share >= -least, kept >= end))
    return Statement(step, goals, given, cuts)
