"""The band of bases whose motors give only so much force: what its forecasts bound and admit.

Tables of one piece and the tail: every piece of longer ones is reckoned alike.
"""

from dataclasses import replace

import casadi as ca

from wmr_ctrl.filter import force_band
from wmr_ctrl.filter.forecast import Forecast
from wmr_ctrl.proofs.claim import Claims, Mutation, rows
from wmr_ctrl.proofs.claims.common import AXES, elements_of
from wmr_ctrl.proofs.claims.filter_band import WAYS, BandAxis, bound_of
from wmr_ctrl.proofs.ledger import HAND
from wmr_ctrl.proofs.methods.spec import Z3
from wmr_ctrl.proofs.relation import Relation, above, at_least, between, equal, positive
from wmr_ctrl.proofs.statement import Statement
from wmr_ctrl.proofs.symbols import Named, symbols
from wmr_ctrl.scenario import load_scenario

claim = Claims(by=Z3(effort=100))
FORCES = "low <= high on every piece, 0 < high on the first, left >= 0, fading in [0, 1]"


class ForceAxis(Named):
    """Symbols of one axis' force: tables, forecast, the new command ``to``, the base's response.

    f is the force that is left to change the speed.
    """

    def __init__(self) -> None:
        names = "above below over under past_over past_under left fading tail u to f F W"
        self.symbols = s = symbols(names)
        self.table = force_band.force_response(s.above, s.below, s.left, s.fading)
        self.forecast = Forecast(s.over, s.under, s.tail, s.u, s.past_over, s.past_under)

    @property
    def stated(self) -> tuple[Relation, ...]:
        """low <= high, 0 < high; left and tail are not negative; f > 0."""
        s = self.symbols
        signs = (above(s.above), at_least(s.above, -s.below), at_least(s.tail), above(s.f))
        return (*between(0, s.fading, 1), at_least(s.left), *signs)


@claim(
    "filter.band.force-{word}",
    given=f"{FORCES}; {{sign}}F <= {{word}}; low <= W <= high, the force behind a step",
    over=WAYS,
)
def forecast(mutation: Mutation, word: str, way: int) -> Statement:
    """{sign}(F + (to - u) W) <= {word} of the changed forecast.

    After a change of the command the forecast still bounds the force of every member.
    """
    a = ForceAxis()
    s, changed = a.symbols, a.forecast.changed(a.to, a.table)
    behind = between(a.table.low[0], s.W, mutation(1, 1.1) * a.table.high[0])
    given = (*a.stated, at_least(bound_of(a.forecast, way), way * s.F), *behind)
    goal = at_least(bound_of(changed, way), way * (s.F + (s.to - s.u) * s.W))
    return Statement(s, (goal,), given)


@claim(
    "filter.band.ramp-force",
    given=f"{FORCES}; F and -F within f before, on every piece and behind; to between what a fall "
    "and a rise are admitted",
)
def ramped_force(mutation: Mutation) -> Statement:
    """over, under of the changed forecast of the force <= f, on the piece and behind.

    A command that is admitted and held keeps the force within what the motors have left.
    """
    a = ForceAxis()
    s, f, to, u = a.symbols, a.f, a.to, a.u
    inverse = force_band.inverse_force_slopes(a.table.low, a.table.high)
    rise, fall = force_band.force_steps(a.forecast, f, inverse)
    before, after = (_parts(item) for item in (a.forecast, a.forecast.changed(to, a.table)))
    admitted = at_least(u + mutation(1, 1.2) * rise, to), at_least(to, u - fall)
    given = (*a.stated, *(at_least(f, part) for part, _ in before), *admitted)
    return Statement(s, tuple(at_least(f, part) for part, _ in after), given)


class DraggedAxis(Named):
    """Symbols of one axis' force and speed together, with the largest friction over speed.

    Those of the speed have a v behind; ``forecasts`` are of both, under one command u.
    """

    def __init__(self) -> None:
        self.force, self.speed = ForceAxis(), BandAxis()
        own = {f"{name} of v": item for name, item in self.speed.symbols.items()}
        self.symbols = self.force.symbols | own | symbols("drag friction")
        self.forecasts = self.force.forecast, replace(self.speed.forecast, u=self.u)

    def after(self, to: ca.SX) -> Forecast:
        """Forecast of the force with friction after a change of the command."""
        force, speed = self.forecasts
        changed = force.changed(to, self.force.table), speed.changed(to, self.speed.table)
        return force_band.with_drag(*changed, self.drag)

    @property
    def stated(self) -> tuple[Relation, ...]:
        """Hypotheses about both, with a drag that is not negative."""
        return (*self.force.stated, *self.speed.stated, at_least(self.drag))


@claim(
    "filter.band.drag-{word}",
    given="{sign}F <= {word} of the force, {sign}v <= {sign}u + {word} of the speed; 0 <= friction "
    "<= drag",
    over=WAYS,
)
def dragged(mutation: Mutation, word: str, way: int) -> Statement:
    """{sign}(F + friction v) <= the larger of {word} of the force and, with friction, {sign}drag u
    + {word} of both.

    Friction is counted at the speed that the base can have, not at its limit.
    """
    a = DraggedAxis()
    force, speed = a.forecasts
    s, both = a.symbols, force_band.with_drag(force, speed, a.drag)
    bounds = [bound_of(f, way) for f in (force, speed, both)]
    known = at_least(bounds[0], way * s.F), at_least(bounds[1] + way * s.u, way * s["v of v"])
    given = (*known, *between(0, s.friction, mutation(1, 1.1) * s.drag))
    most = ca.fmax(bounds[0], bounds[2] + way * both.u)
    return Statement(s, (at_least(most, way * (s.F + s.friction * s["v of v"])),), given)


@claim(
    "filter.band.drag-changed-{word}", given="any tables, forecasts, command and drag", over=WAYS
)
def drag_changed(mutation: Mutation, way: int) -> Statement:
    """{sign}drag to + {word} of force and friction = {sign}drag u + {word} before + what a change
    of one command adds by the tables of both, on the piece and behind.

    A command changes force plus friction as it would change one force with the sum of both tables.
    """
    a = DraggedAxis()
    s, (force, speed) = a.symbols, a.forecasts
    drag, to, u = s.drag, s.to, s.u
    before, after = force_band.with_drag(force, speed, drag), a.after(to)
    low, high = force_band.dragging(a.force.table, a.speed.table, drag)
    ahead, back = ca.fmax(way * (to - u), 0), ca.fmax(way * (u - to), 0)
    goals = []
    for k, (old, new) in enumerate(zip(_bounds(before, way), _bounds(after, way), strict=True)):
        added = ahead * high[k] - back * low[k]
        changed = new + way * drag * to - (old + way * mutation(1, 1.1) * drag * u)
        goals += [*between(added, changed, added)]
    return Statement(s, tuple(goals), a.stated)


PARTS = rows(behind=(0, 1), part=("piece", "tail"), told=("the piece", "what is behind"))
HOW = "u <= to <= u + rise", "u - fall <= to <= u"
TURNS = rows(rises=(True, False), turn=("rise", "fall"), how=HOW)
RAMPED = tuple(way | part | turn for way in WAYS for part in PARTS for turn in TURNS)


@claim(
    "filter.band.ramp-drag-{word}-{part}-{turn}",
    given="low <= high on every piece and behind, 0 < high on the first; {sign}held + {word} <= f "
    "before; {how}, what a fall and a rise are admitted",
    over=RAMPED,
)
def ramped_drag(mutation: Mutation, way: int, behind: int, rises: bool) -> Statement:
    """{sign}held + {word} + what the change adds <= f, on {told}.

    A command that is admitted and held keeps the force, friction included, within what the motors
    have left.
    """
    s = symbols("low high low_behind high_behind over under tail past_over past_under u held to f")
    low, high = (ca.vertcat(s[name], s[f"{name}_behind"]) for name in ("low", "high"))
    past, f, change = (s.past_over, s.past_under), s.f, s.to - s.u
    known = Forecast(s.over, s.under, s.tail, s.u, *past)
    inverse = force_band.inverse_force_slopes(low, high)
    rise, fall = force_band.force_steps(known, f, inverse, s.held)
    before = _bounds(known, way)[behind] + way * s.held
    size, most = (change, rise) if rises else (-change, fall)
    stated = *positive(s.high, f), at_least(high[behind], low[behind]), at_least(f, before)
    given = (*stated, *between(0, size, mutation(1, 1.2) * most))
    added = change * (high if (way > 0) == rises else low)[behind]
    return Statement(s, (at_least(f, before + way * added),), given)


def _bounds(known: Forecast, way: int) -> tuple[ca.SX, ca.SX]:
    """Bounds of a quantity (way 1) or of its negative, on the piece and behind it."""
    return bound_of(known, way), bound_of(known, way, -1)


def _parts(known: Forecast) -> list[tuple[ca.SX, int]]:
    """Bounds on the piece and behind it, of the quantity (1) and of its negative (-1)."""
    return [(bound, way) for way in (1, -1) for bound in _bounds(known, way)]


WEAK = {
    "filter.kind": "band", "filter.loop": "pi", "filter.mass": (50, 65), "filter.inertia": (4, 6),
    "filter.kp": (135, 165), "filter.ki": (270, 330), "filter.force": (300, 100),
    "clock.control": 0.5,
}  # fmt: skip
"""Settings for the structure of the band's graph; its numbers are symbols."""


@claim(
    "filter.band.ramp-sent-{id}",
    given="every command (NaN included), parameters that are sound; 0 <= what a fall and a rise "
    "are admitted",
    over=AXES,
)
def sent(mutation: Mutation, axis: int) -> Statement:
    """u_before - fall <= u <= u_before + rise, u what the whole band sends on the {id} axis.

    Nothing bypasses the filter: no command, not even NaN, and no scaling of the other axis.
    """
    graph = force_band.ForceBand(load_scenario("paper-simulation", WEAK))
    named = elements_of(*graph.system.inputs)
    cuts = {f"end {i} {k}": end for i, pair in enumerate(graph.ends) for k, end in enumerate(pair)}
    (least, most), u = graph.ends[axis], mutation(1, 1.1) * graph.sent[axis]
    ordered = tuple(at_least(high, low) for low, high in graph.ends)
    given = (*ordered, equal(graph.sound, 1))
    goals = at_least(most, u), at_least(u, least)
    return Statement(named, goals, given, cuts | {"sound": graph.sound})


@claim(
    "filter.band.force",
    given="a PI loop of the family, its numbers constant, at rest at the start, whose motors give "
    "what it asks for; commands take over within their jitter of a beat; |d| <= dbar",
    by=HAND,
    premises="filter.band.force-over filter.band.force-under filter.band.drag-over "
    "filter.band.drag-under filter.peak-gain",
)
def force() -> None:
    """F = sum of Delta_j M S'(age_j) + c v_u + the response to pushes, at most N dbar, with v_u the
    speed due to commands alone; each |M S'| <= reach exp(-rate age).

    Forecasts that bound the sum, and the sum with c_max v_u, by f = F_max - N dbar bound what the
    loop asks for.
    """


@claim(
    "filter.band.ramp",
    given="a PI loop of the family, its numbers constant, at rest at the start; motors that give "
    "F_max; commands take over a constant delay after they were sent, at any time that the filter "
    "is told; |d| <= dbar",
    by=HAND,
    premises="filter.band.superposition filter.band.force filter.band.held-rise "
    "filter.band.held-fall filter.band.fading filter.band.past-over filter.band.past-under "
    "filter.band.ramp-force filter.band.ramp-drag-over-piece-rise "
    "filter.band.ramp-drag-over-piece-fall filter.band.ramp-drag-over-tail-rise "
    "filter.band.ramp-drag-over-tail-fall filter.band.ramp-drag-under-piece-rise "
    "filter.band.ramp-drag-under-piece-fall filter.band.ramp-drag-under-tail-rise "
    "filter.band.ramp-drag-under-tail-fall filter.band.drag-changed-over "
    "filter.band.drag-changed-under filter.band.ramp-sent-linear "
    "filter.band.ramp-sent-angular",
)
def ramp() -> None:
    """|v| <= c + delta <= V and |F| <= F_max at every instant: the command before may be held for
    ever, and one that takes its place may, too, since its forecasts are within c and f.

    The band keeps a loop that overshoots within its limit, however weak its motors are.
    """
