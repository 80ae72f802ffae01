"""Arguments by hand, in pieces: steps of sums, motions in pieces, logarithm, sine by derivatives.

The integrals, means and inductions themselves are in docs/lemmas.md.  Of the functions the solver
knows (sin t)^2 + (cos t)^2 = 1 at most; from a derivative's sign to the inequality leads
`lemma.integration`.
"""

import casadi as ca

from wmr_ctrl.guard.delay import Tails, delayed_push, push
from wmr_ctrl.guard.lateness import Times, lateness
from wmr_ctrl.proofs.claim import Claims, Mutation
from wmr_ctrl.proofs.claims.guard_axis import DELAYED, GuardAxis
from wmr_ctrl.proofs.claims.guard_sent import only
from wmr_ctrl.proofs.methods.spec import Z3
from wmr_ctrl.proofs.statement import (
    Relation,
    Statement,
    above,
    at_least,
    equal,
    symbols,
    when,
    within,
)

claim = Claims(by=Z3(effort=150))


@claim(
    "guard.lemma.piece",
    given="v linear over the piece: friction f, push d and F constant; v on one side of f_speed, f "
    ">= f_min above it, |d| <= dbar, M >= M_min",
)
def lemma_piece(mutation: Mutation) -> Statement:
    """max(v, f_speed) rises by at most t max(F + dbar - f_min, 0)/M_min over a piece of time t.

    guard.lemma for motions in pieces; its integrals are the limit of these.
    """
    a, t = GuardAxis(), symbols("end drag push")
    v, end, edge = a["v"], t["end"], a["f_speed"]
    above_edge = ca.logic_or(v > edge, end > edge)
    given = (
        *a.sound(), at_least(a["mass"], a["M_min"]), at_least(a["t"]),
        *within(t["push"], a["dbar"]), at_least((v - edge) * (end - edge)),
        when(above_edge, at_least(t["drag"], a["f_min"])),
        equal(a["mass"] * (end - v), a["t"] * (a["asked"] - t["drag"] + t["push"])),
    )  # fmt: skip
    most = (
        ca.fmax(v, edge) + mutation(1, 0.9) * a["t"] * push([a["asked"]], a.bounds, 1) / a["M_min"]
    )
    return Statement({**a.symbols, **t}, (at_least(most, ca.fmax(end, edge)),), given)


@claim("guard.delay.step", given="guard.lemma over the piece; it acts for s <= tau, M >= M_min")
def delay_step(mutation: Mutation) -> Statement:
    """v+ is at most y + nbar or f_speed, and what the commands before have added: after the next
    one it is at most that and tau max(F + net, 0)/M_min more, as the guard sums it; so is -v.

    One step of the sum over commands under way, for whatever was summed before.
    """
    a = GuardAxis(DELAYED)
    more, goals = only(a), []
    for way, sum_of in ((1, more.ahead), (-1, more.back)):
        most = ca.fmax(way * a["y"] + a["nbar"], a["f_speed"]) + a("", way)
        gained = a["since"] * ca.fmax(way * a["sent"] + a.net, 0) / a["mass"]
        reached = ca.fmin(a["arrived"], most) + gained
        goals.append(at_least(most + mutation(1, 0.9) * sum_of, reached))
    given = (
        *a.sound(), at_least(a["mass"], a["M_min"]), at_least(a["since"]),
        at_least(a["periods"] * a["period"], a["since"]),
    )  # fmt: skip
    return Statement(a.symbols, tuple(goals), given)


@claim(
    "guard.late.mean-piece",
    given="a window of two periods, v linear in each: y is (v_0 + 2 v_1 + v_2)/4 to within nbar; "
    "guard.lemma over each period",
)
def mean_piece(mutation: Mutation) -> Statement:
    """v+ now is at most what the guard counts from y with the commands of both periods, in the mean
    and from rest; so is -v.

    guard.late.mean for motions in pieces; its integrals are the limit of these.
    """
    a, t = GuardAxis(DELAYED), symbols("v0 v1 v2")
    b, v = a.bounds, [*t.values()]
    late = lateness(Times(period=1.0, step=1.0, window=2.0))
    sent = [ca.vertcat(a[name], 0) for name in ("sent", "other")]
    coming = delayed_push(sent, late, 0, b, Tails("tail", (late, late)))
    assert coming is not None
    goals, given = [], [*a.sound()]
    mean = (v[0] + mutation(2, 1.5) * v[1] + v[2]) / 4
    given += within(a["y"] - mean, b.nbar)
    for way, seen in ((1, coming), (-1, coming.mirrored)):
        speeds = [ca.fmax(way * item, b.f_speed) for item in v]
        for k, name in enumerate(("other", "sent")):
            gain = b.period * ca.fmax(way * a[name] + a.net, 0) / b.M_min
            given.append(at_least(speeds[k] + gain, speeds[k + 1]))
        reached = seen.reached(ca.fmax(way * a["y"] + b.nbar, b.f_speed), b)
        goals.append(at_least(reached, speeds[2]))
    return Statement({**a.symbols, **t}, tuple(goals), tuple(given))


@claim("guard.late.convex", given="0 <= w <= 1; any two forces, any dbar - f_min")
def convex(mutation: Mutation) -> Statement:
    """p(w F + (1 - w) F') <= w p(F) + (1 - w) p(F'), p what the guard counts of a force; either
    way.

    Jensen's inequality of two forces, and so of any weights on finitely many.
    """
    a, w = GuardAxis(DELAYED), ca.SX.sym("w")
    forces, goals = (a["sent"], a["other"]), []
    for way in (1, -1):
        mixed, first, second = (
            push([force], a.bounds, way) for force in (w * forces[0] + (1 - w) * forces[1], *forces)
        )
        goals.append(at_least(w * first + mutation(1 - w, w) * second, mixed))
    return Statement({**a.symbols, "w": w}, tuple(goals), (at_least(w), at_least(1, w)))


def vanishes(value: ca.SX, t: ca.SX, where: float) -> Relation:
    """The value is 0 at one point."""
    return equal(ca.substitute(value, t, ca.SX(where)))


@claim("lemma.log", (15,), given="t > 0", by=Z3(), premises="lemma.integration")
def logarithm(mutation: Mutation) -> Statement:
    """ln t <= t - 1: the difference is 0 at t = 1, and its derivative has the sign of t - 1.

    The one fact about the logarithm that the exact algebra uses.
    """
    t = ca.SX.sym("t")
    gap = t - 1 - mutation(1, 2) * ca.log(t)
    goals = vanishes(gap, t, 1), at_least(ca.gradient(gap, t) * (t - 1))
    return Statement({"t": t}, goals, (above(t),))


@claim(
    "lemma.sine",
    (40, 46, 55),
    given="sin t >= 0 for 0 <= t <= pi",
    by=Z3(),
    premises="lemma.integration",
)
def sine(mutation: Mutation) -> Statement:
    """|sin t| <= |t|, 1 - cos t <= t^2/2, and |sin t| >= (2/pi) |t| for |t| <= pi/2: t - sin t is
    odd and does not fall; t^2/2 - 1 + cos t has the derivative t - sin t; (sin t)/t has the
    derivative n/t^2, n = t cos t - sin t, and n does not rise from 0 on; each is 0 at 0.

    What the window argument uses about the angle.
    """
    names = symbols("t")
    t = names["t"]
    gap, rise = t - ca.sin(t), t**2 / 2 - 1 + ca.cos(t)
    slope, share = t * ca.cos(t) - ca.sin(t), ca.sin(t) / t
    goals = (
        *(vanishes(value, t, 0) for value in (gap, rise, slope)),
        at_least(ca.gradient(gap, t)),
        equal(ca.gradient(rise, t), gap),
        equal(t**2 * ca.gradient(share, t), mutation * slope),
        at_least(-ca.gradient(slope, t)),
    )
    return Statement(names, goals, (above(t), at_least(ca.sin(t))))
