"""The guard's parts in controller and simulator: axes, flag, monitor, and what is simulated."""

import casadi as ca

from wmr_ctrl.guard.guard import Bounds, clipped, feasible, guarded
from wmr_ctrl.guard.lateness import AT_ONCE, Since
from wmr_ctrl.guard.monitor import LateMotion, least_push
from wmr_ctrl.model.dynamics import plant, rk4_step, wheel_to_force
from wmr_ctrl.proofs.claim import Claims, Mutation
from wmr_ctrl.proofs.claims.common import PRESET, scalars
from wmr_ctrl.proofs.claims.guard import NUMBERS_FREE, solver
from wmr_ctrl.proofs.claims.guard_axis import DELAYED, LATE, NUMBERS, GuardAxis
from wmr_ctrl.proofs.statement import Statement, above, at_least, equal, symbols
from wmr_ctrl.scenario import load_scenario

claim = Claims(by=solver)


@claim("guard.axes", given="T > 0")
def axes(mutation: Mutation) -> Statement:
    """guarded(F, y)_i = clip of F_i at y_i with the bounds of axis i, and the safe point likewise,
    i = 1, 2.

    What is proved for one axis holds for both.
    """
    one, two = GuardAxis(), GuardAxis()
    table = {f"{name}{k}": a[name] for k, a in ((1, one), (2, two)) for name in a.symbols}
    both = Bounds(**{name: ca.vertcat(one[name], two[name]) for name in NUMBERS.split()})
    result = guarded(ca.vertcat(one["asked"], two["asked"]), ca.vertcat(one["y"], two["y"]), both)
    goals = [
        goal
        for i, a in enumerate((one, two))
        for goal in (
            equal(result.force[i], clipped(mutation * a["asked"], a["y"], a.bounds)),
            equal(result.safe[i], clipped(ca.SX(0), a["y"], a.bounds)),
        )
    ]
    positive = tuple(above(a["period"]) for a in (one, two))
    return Statement(table, tuple(goals), positive)


@claim(
    "guard.{name}",
    given="{which}",
    over=(
        {"name": "promise", "a": GuardAxis(), "which": "without delay (delay = 0 in the claim)"},
        {"name": "promise-late", "a": GuardAxis(DELAYED), "which": "behind a delay"},
        {"name": "late.promise", "a": GuardAxis(LATE), "effort": 400,
         "which": "with jitter; and 2 net mixed <= M_min (u1 - 2 nbar)"},
    ),
)  # fmt: skip
def promise(mutation: Mutation, a: GuardAxis) -> Statement:
    """feasible = 1 implies 2 net (1 + alpha delay) <= M_min alpha (u1 - f_speed), 2 nbar <= u1,
    brake >= net, M_min <= M_max, f_speed < u1 and alpha T <= 1.

    The published flag implies the theorem's hypotheses, apart from signs.
    """
    b = a.bounds
    need = mutation(2, 2.01) * a.net * (1 + b.alpha * a.late)
    goals = (
        at_least(b.M_min * b.alpha * (b.u1 - b.f_speed), need),
        *([a.spread] if a.lateness == LATE else []),
        at_least(b.u1, 2 * b.nbar),
        at_least(b.brake, a.net),
        at_least(1, b.alpha * b.period),
        at_least(b.M_max, b.M_min),
        above(b.u1, b.f_speed),
    )
    return Statement(a.symbols, goals, (above(feasible(b)),))


@claim("guard.simulated", given="every mu >= 0, m, I, r, l, g, v_s, h > 0, all inputs")
def simulated(mutation: Mutation) -> Statement:
    """one Runge-Kutta step h of the plant ends at v1 <= max(v1 + h max(F, 0)/m, h (|F| + 2 mu m
    g)/m), F the sum of all pushes; omega ends at omega + h N/I.

    The simulated robot does not outrun the comparison that the guard relies on, except at speeds
    that friction alone reverses within a step. This is over the real numbers: the step's own
    rounding, some units in the last place of v a step, is not counted, so the simulated v may pass
    u1 by that much.
    """
    robot = plant(load_scenario(PRESET))
    t = {**scalars((*robot.inputs, *robot.state, *robot.params)), **symbols("step", "step")}
    m, inertia, mu, r, half, g, v_s = (
        t[f"robot.{name}"] for name in ("m", "I", "mu", "r", "l", "g", "v_s")
    )
    tau = ca.vertcat(t["tau_right"] + t["noise_right"], t["tau_left"] + t["noise_left"])
    push = wheel_to_force(r, half, tau) + ca.vertcat(t["thrust"], t["moment"])
    after = rk4_step(robot, t["step"])[3:5]
    friction = mu * m * g
    driven = t["v1"] + t["step"] * ca.fmax(push[0], 0) / m
    slow = t["step"] * (ca.fabs(push[0]) + mutation(2, -1) * friction) / m
    goals = (
        at_least(ca.fmax(driven, slow), after[0]),
        equal(after[1], t["omega"] + t["step"] * push[1] / inertia),
    )
    positive = tuple(above(item) for item in (m, inertia, r, half, g, v_s, t["step"]))
    given = (*positive, at_least(mu))
    return Statement(t, goals, given, {"thrust in all": push[0], "moment in all": push[1]})


@claim(
    "guard.monitor",
    given=f"{NUMBERS_FREE}; push of either sign; both measured velocities beyond nbar on the "
    "same side, friction against the motion",
)
def not_blamed(mutation: Mutation) -> Statement:
    """d_least is at most the mean disturbance of the sample in the direction of motion, or 0,
    driving forwards or backwards.

    The monitor reports bounds as broken only where they are.
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
    given = (*a.feasible(), *a.during(), *errors, *ahead)
    return Statement({**a.symbols, **t}, (at_least(ca.fmax(t["push"], 0), least),), given)


@claim("guard.monitor-quiet", given="any bounds, T > 0")
def quiet(mutation: Mutation) -> Statement:
    """d_least = 0 where the measured velocities are not both beyond nbar on the same side.

    At rest and at a change of direction it reports nothing.
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
"""Commands that may have acted: of mean either of two, then the older one; likewise of rest."""


@claim(
    "guard.monitor-late",
    given="mean: either of two commands for T/2, the older for T/4; rest: the newer for T/2, "
    "either for 3 T/4; no lag; M_min, T > 0, nbar, D >= 0; either axis",
)
def late(mutation: Mutation) -> Statement:
    """late velocities: d_least <= D where the velocity changed since the previous sample, either
    way, by no more than a push D and the commands that may have acted explain, in the mean or from
    rest.

    The monitor never reports bounds that explain the motion, not even behind a delay with jitter.
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
