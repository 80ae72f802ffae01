"""Around the exported guard: runs without it, what is kept as applied, what is kept back."""

import casadi as ca

from wmr_ctrl.control.controller import asking_controller, guard
from wmr_ctrl.guard.guard import MAPS, bounds_of
from wmr_ctrl.model.dynamics import force_to_wheel
from wmr_ctrl.model.system import Parameters
from wmr_ctrl.proofs.claim import Claims, Mutation
from wmr_ctrl.proofs.claims.common import scalars
from wmr_ctrl.proofs.claims.guard import solver
from wmr_ctrl.proofs.claims.guard_delay_rounding import QueuedAxis
from wmr_ctrl.proofs.claims.guard_exported import PERIOD, Assembled, setup
from wmr_ctrl.proofs.claims.guard_rounding import DOUBLE
from wmr_ctrl.proofs.statement import (
    Relation,
    Statement,
    above,
    at_least,
    equal,
    every,
    positive,
    symbols,
    valued,
)
from wmr_ctrl.world.lag import ACTING, LAG

claim = Claims(by=solver)


@claim(
    "guard.assembled.watched",
    given="any parameters with r, l, T, alpha, M_min, M_max > 0; any force that is asked for",
    premises="wheels.linear-first",
)
def watched(mutation: Mutation) -> Statement:
    """without the guard, the whole controller's torques are what linear-first makes of the force
    that the law asks for; the flag, the torque that is remembered as applied and each d_least are
    as with the guard.

    A run without the guard is monitored with the bounds that the guard would use.
    """
    e = Assembled(asking_controller, "linear-first", 0, guarded=False)
    (r, half), asked = e.wheels, mutation(1, 0.9) * e.asked
    return e.consists(force_to_wheel(r, half, MAPS["linear-first"](asked, e.phi, half)))


@claim(
    "guard.assembled.applied",
    given="0 < e < 1, e = exp(-h/lag); four plant steps in a period, delay of one period and three "
    "steps",
    premises="world.lag.applied",
)
def applied(mutation: Mutation) -> Statement:
    """on the guard's own graph, the torque that is remembered as applied is the mean, over the
    plant steps of the sample, of the lag's response to the commands that the delay lets through,
    and the torque that is remembered as acting is that response's last value; each command moves on
    by one place.

    Guard, monitor and observer use the torque that the simulated drives produced.
    """
    steps, part, h = 4, 3, PERIOD / 4
    late = {"clock.plant": h, "actuator.delay": PERIOD + part * h, "actuator.lag": 0.02}
    drives = setup("linear-first", 0, True, **late)
    e, lag = Assembled(lambda _: guard(drives), "linear-first", 0), LAG.build(drives.scenario)
    commands = [e.torque, e.p["tau_sent1"], e.p["tau_sent2"]]
    held = {port.signal.name: port.sym for port in (*lag.inputs, *lag.state, *lag.params)}
    acting, total = e.p["tau_acting"], ca.SX.zeros(2)
    for step in range(steps):
        told = commands[2 if step < part else 1]
        put = {name: e.p[name] for name in ("clock.plant", "actuator.lag")}
        put |= {"tau_right": told[0], "tau_left": told[1], ACTING.name: acting}
        acting = ca.substitute([lag.update], [held[n] for n in put], [*put.values()])[0]
        total = total + acting
    share = ca.exp(-e.p["clock.plant"] / e.p["actuator.lag"])
    free = symbols("e")
    goals = (
        *every(e.later["tau_applied"], mutation * total / steps),
        *every(e.later["tau_acting"], acting),
        *every(e.later["tau_sent1"], commands[0]), *every(e.later["tau_sent2"], commands[1]),
    )  # fmt: skip
    cuts = {"e": share, "right": commands[0][0], "left": commands[0][1]}
    table = {**e.symbols, **free, **symbols("right left")}
    return Statement(table, goals, (above(free["e"]), above(1, free["e"])), cuts)


@claim(
    "guard.delay.rounding.kept",
    by=solver(100),
    given="n = 1 to 5 commands under way; alpha T <= 1 + 2^-50, v_u1, T, alpha > 0; both axes",
)
def kept(mutation: Mutation) -> Statement:
    """the bounds that the exported guard is built with have u1 = v_u1 (1 - kept), kept = (1 + n)
    2^-44 and alpha delay <= n (1 + 2^-50).

    The exported guard keeps back the margin that these entries assume.
    """
    a, table, goals, given = QueuedAxis(), dict[str, ca.SX](), list[Relation](), list[Relation]()
    for n in range(1, 6):
        guarded = setup("linear-first", n)
        p = Parameters(guarded)
        both = bounds_of(p, guarded.guard.lateness(guarded.scenario.clock))
        table |= {f"{name} {n}": symbol for name, symbol in scalars(p.ports).items()}
        for axis, b in enumerate(map(both.axis, (0, 1))):
            u1 = p.take("limits.v_u1")[axis]
            assert b.delay is not None
            goals.append(equal(b.u1, u1 * (1 - (1 + n) * 2.0**-44)))
            put = {"share": b.u1 / u1, "alpha": b.alpha, "delay": b.delay}
            goals += valued([*a.sized, a.counts], a.symbols, put)
            given += positive(b.period, b.alpha, u1)
            given.append(at_least(mutation(1 + DOUBLE.quicker, 2), b.alpha * b.period))
    return Statement(table, tuple(goals), tuple(given))
