"""What the monitor accuses: never bounds that hold, and the push itself where nothing is unsure."""

from __future__ import annotations

import casadi as ca

from wmr_ctrl.guard.lateness import AT_ONCE, Since
from wmr_ctrl.guard.monitor import LateMotion, least_push
from wmr_ctrl.proofs.claim import Claims, Mutation
from wmr_ctrl.proofs.claims.guard import ALL, FEASIBLE
from wmr_ctrl.proofs.claims.guard_axis import GuardAxis
from wmr_ctrl.proofs.methods.spec import Z3
from wmr_ctrl.proofs.statement import Statement, above, at_least, equal, symbols

claim = Claims(by=Z3(effort=150))


@claim(
    "guard.monitor",
    given=f"{ALL}: {FEASIBLE}; push of either sign; both measured velocities beyond nbar on the "
    "same side, friction against the motion",
)
def not_blamed(mutation: Mutation) -> Statement:
    """d_least is at most the mean disturbance of the sample in the direction of motion, or 0,
    driving forwards or backwards.

    The monitor accuses the bounds only where they are wrong.
    """
    a = GuardAxis()
    b, t = a.bounds, symbols("old push drag e_new e_old way")
    way = ca.if_else(t["way"] > 0, 1, -1)
    mean = (a["asked"] + way * (t["push"] - mutation * t["drag"])) / a["mass"]
    new = t["old"] + b.period * mean
    y, before = new + t["e_new"], t["old"] + t["e_old"]
    errors = [at_least(b.nbar, side * t[name]) for side in (1, -1) for name in ("e_new", "e_old")]
    ahead = (above(ca.fmin(way * y, way * before), b.nbar), at_least(t["drag"]))
    least = least_push(y, before, a["asked"], b)
    given = (*a.feasible(), *a.during, *errors, *ahead)
    return Statement({**a.symbols, **t}, (at_least(ca.fmax(t["push"], 0), least),), given)


@claim("guard.monitor-quiet", given="any bounds, T > 0")
def quiet(mutation: Mutation) -> Statement:
    """d_least = 0 where the measured velocities are not both beyond nbar on the same side.

    At rest and at a change of direction nothing is accused.
    """
    a = GuardAxis()
    b, old = a.bounds, ca.SX.sym("old")
    least = least_push(a["y"], old, a["asked"], b)
    same = ca.fmax(ca.fmin(a["y"], old), -ca.fmax(a["y"], old)) - mutation(0, 1)
    given = (above(b.period), above(b.M_min), at_least(b.nbar), at_least(b.nbar, same))
    return Statement({**a.symbols, "old": old}, (equal(least),), given)


@claim(
    "guard.monitor-sharp",
    given="nbar = 0, M_min = M_max = M, no friction, push >= 0 in the direction of motion",
)
def sharp(mutation: Mutation) -> Statement:
    """d_least is the push of the sample, forwards and backwards.

    Where nothing is uncertain the monitor measures the disturbance.
    """
    a = GuardAxis()
    b, t = a.bounds, symbols("old push way")
    way = ca.if_else(t["way"] > 0, 1, -1)
    y = t["old"] + b.period * (a["asked"] + way * t["push"]) / b.M_min
    least = least_push(y, t["old"], a["asked"], b)
    exact = (equal(b.nbar), equal(b.M_max, b.M_min), above(b.M_min), above(b.period))
    ahead = (above(ca.fmin(way * y, way * t["old"])), at_least(t["push"]))
    return Statement({**a.symbols, **t}, (equal(least, mutation * t["push"]),), (*exact, *ahead))


SINCE = Since(
    mean=(((1, 2), 0.5), ((2,), 0.25)),
    rest=(((1,), 0.5), ((1, 2), 0.75)),
    mean_time=0.75, rest_time=1.25, older=AT_ONCE,
)  # fmt: skip
"""What may have acted: of the mean either of two commands, then the older one; likewise of rest."""


@claim(
    "guard.monitor-late",
    given="mean: either of two commands for T/2, the older for T/4; rest: the newer for T/2, "
    "either for 3 T/4; no lag; M_min, T > 0, nbar, D >= 0; either axis",
)
def late(mutation: Mutation) -> Statement:
    """late velocities: d_least <= D where each way the velocity moved since the previous sample by
    no more than the commands that may have acted and a push D explain, as mean or from rest.

    The monitor accuses no bounds that explain the motion, behind a delay and jitter either.
    """
    a = GuardAxis()
    b, t = a.bounds, symbols("old D F1 F2 N1 N2")
    sent = [ca.vertcat(t[f"F{j}"], t[f"N{j}"]) for j in (1, 2)]
    motion, old, D = LateMotion((SINCE, SINCE), sent, sent[0]), t["old"], t["D"]
    goals, given = [], [above(b.M_min), above(b.period), at_least(b.nbar), at_least(D)]
    for axis, name in enumerate("FN"):
        least = motion.least_push(axis, a["y"], old, b)
        goals.append(at_least(D, mutation(1, 1.01) * least))
        for way in (1, -1):
            newer, older = (ca.fmax(way * t[f"{name}{j}"], 0) for j in (1, 2))
            either = ca.fmax(newer, older)
            mean = 0.5 * either + 0.25 * older + 0.75 * D
            rest = 0.5 * newer + 0.75 * either + 1.25 * D
            moved = b.M_min * (way * (a["y"] - old) - 2 * b.nbar) / b.period
            begun = b.M_min * (way * a["y"] - b.nbar) / b.period
            given.append(at_least(ca.fmax(mean - moved, rest - begun)))
    return Statement({**a.symbols, **t}, tuple(goals), tuple(given))
