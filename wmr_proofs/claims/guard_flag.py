"""The exported guard's flag with rounding, and the parts around the guard.

The flag has no tolerance, so only its own rounding separates the published 1 from the theorem's
conditions.  Parts around the guard: runs without it, the torque stored as applied, and the reserved
margin.
"""

import casadi as ca

from wmr_ctrl.control.controller import asking_controller, guard
from wmr_ctrl.control.guard.guard import MAPS, Bounds, bounds_of
from wmr_ctrl.world.lag import ACTING, LAG
from wmr_ctrl.world.model.dynamics import force_to_wheel
from wmr_ctrl.world.model.system import Parameters
from wmr_proofs.claim import Claims, Mutation
from wmr_proofs.statement import (
    Cuts,
    Group,
    Relations,
    Statement,
    Symbols,
    every,
    nonnegative,
    positive,
    symbols,
    valued,
    within,
)

from .common import ports_of, scalars
from .exported import PERIOD, Assembled, setup
from .guard_delay_rounding import QueuedAxis
from .guard_rounding import DOUBLE

NEAR = 2.0**-50

DELAYS = {"at-once": {"n": 0}, "delay": {"n": 2}}
claim = Claims(given="{FLAG_SIGNS}")


class Flag(Assembled):
    """The exported flag, exact bounds of ``both`` axes, and conditions on its numbers."""

    def __init__(self, delay: int) -> None:
        super().__init__(guard, setup("linear-first", delay))
        self.both = [b for _, b, _ in self.axes]

    @property
    def signs(self) -> Relations:
        """Signs of the guard's numbers, and of the wheels'."""
        own = [item for b in self.both for item in (b.M_min, b.u1)]
        shared = ("clock.control", "guard.alpha", "actuator.tau_max")
        less = [n for b in self.both for n in (b.f_speed, b.dbar, b.f_min, b.brake)]
        numbers = (*self.wheels, *(self.p[name] for name in shared), *own)
        return positive(*numbers), nonnegative(*less)

    def authority(self, b: Bounds, share: float = 2) -> Relations:
        """The theorem's first condition, to within the flag's rounding."""
        late = 1 if b.delay is None else 1 + b.alpha * b.delay
        room = b.u1 - b.f_speed + (1 + len(self.sent)) * NEAR * b.u1
        return b.M_min * b.alpha * room >= share * b.net * late

    def computes(self, texts: Cuts, free: Symbols, goals: Relations, given: Relations) -> Statement:
        """The statement about what doubles compute for ``texts``."""
        whole = self.symbols | free, goals, (given, self.signs), self.cuts
        return Statement(*whole, computed=texts)


def size(b: Bounds) -> ca.SX:
    """S = M_min alpha u1 + |net|: the guard's forces are of this size at most."""
    return b.M_min * b.alpha * b.u1 + abs(b.net)


@claim("guard.flag.conditions", premises="assumption.libm", each=DELAYS)
def conditions(mutation: Mutation, n: int) -> Statement:
    """feasible = 1 as doubles compute it implies on each axis, with d = 2^-50: 2 net (1 + alpha
    delay) <= M_min alpha (u1 - f_speed + (1 + n) d u1), brake >= net - d |net|, alpha T <= 1 + d,
    2 nbar <= u1 (1 + d), f_speed < u1 (1 + d), M_min <= M_max; n = 0 and 2.

    The compiled guard's flag implies the theorem's conditions to within some roundings of its own
    numbers.
    """
    e, free, near = Flag(n), symbols("flag"), 1 + NEAR
    goals = Group()
    for b in e.both:
        goals += e.authority(b, mutation(2, 2.01)), b.brake + NEAR * abs(b.net) >= b.net
        goals += near >= b.alpha * b.period, b.u1 * near >= 2 * b.nbar
        goals += b.u1 * near > b.f_speed, b.M_max >= b.M_min
    return e.computes({"flag": e.told["feasible"]}, free, goals, free.flag > 0)


@claim("guard.flag.braking", premises="guard.flag.conditions assumption.libm", each=DELAYS)
def braking(mutation: Mutation, n: int) -> Statement:
    """each axis' brakes as doubles compute them have an error of at most 4 (1 + n) 2^-50 S, and are
    at most S in size, S = M_min alpha u1 + |net|; n = 0 and 2.

    The flag compares the wheels' reach with the force with which the guard may brake.

    Given: {FLAG_SIGNS}; as guard.flag.conditions has it.
    """
    e, free = Flag(n), symbols("first second")
    share = mutation(4, 0.01) * (1 + n) * NEAR
    goals, given, computed = Group(), Group(), Cuts()
    for name, b in zip(free, e.both, strict=True):
        computed[name] = b.braking
        goals += within(free[name] - b.braking, share * size(b)), within(b.braking, size(b))
        given += e.authority(b), b.u1 * (1 + NEAR) > b.f_speed
    given += [b.brake + NEAR * abs(b.net) >= b.net for b in e.both]
    return e.computes(computed, free, goals, given)


@claim("guard.flag.reach", premises="guard.flag.braking assumption.libm", each=DELAYS)
def reach(mutation: Mutation, n: int) -> Statement:
    """feasible = 1 as doubles compute it implies FB1 + FB2/l <= phi (1 + 2^-47) + 8 (1 + n) 2^-50
    (S1 + S2/l), FB the exact brakes; n = 0 and 2.

    If the compiled guard says so, both axes can brake at the same time, to within some roundings.

    Given: {FLAG_SIGNS}; the brakes as guard.flag.braking has them.
    """
    e, free = Flag(n), symbols("flag first second exact1 exact2 size1 size2")
    share, half = 4 * (1 + n) * NEAR, e.wheels[1]
    given: list[Relations] = [free.flag > 0]
    for k, (name, b) in enumerate(zip(("first", "second"), e.both, strict=True), 1):
        exact, most = free[f"exact{k}"], free[f"size{k}"]
        given += [within(free[name] - exact, share * most), within(exact, most)]
        given += [most == size(b), exact == b.braking]
    off = 2 * share * (free.size1 + free.size2 / half)
    braked = free.exact1 + free.exact2 / half
    computed = {"flag": e.told["feasible"], "first": e.both[0].braking, "second": e.both[1].braking}
    return e.computes(computed, free, e.phi * (1 + 8 * NEAR) + mutation * off >= braked, given)


watched_claim = Claims()


@watched_claim("guard.assembled.watched", premises="wheels.linear-first")
def watched(mutation: Mutation) -> Statement:
    """without the guard, the whole controller's torques are those of linear-first for the force
    that the law requests; the flag, the torque stored as applied and each d_least are as with the
    guard.

    A run without the guard is monitored with the bounds that the guard would use.

    Given: any parameters with r, l, T, alpha, M_min, M_max > 0; any requested force.
    """
    e = Assembled(asking_controller, setup("linear-first", 0, **{"guard.enabled": False}))
    (r, half), asked = e.wheels, mutation(1, 0.9) * e.asked
    return e.consists(force_to_wheel(r, half, MAPS["linear-first"](asked, e.phi, half)))


@watched_claim("guard.assembled.applied", premises="world.lag.applied")
def applied(mutation: Mutation) -> Statement:
    """on the guard's own graph, the torque stored as applied is the mean, over the plant steps of
    the sample, of the lag's response to the delayed commands, and the torque stored as acting is
    that response's last value; each stored command moves by one place.

    Guard, monitor and observer use the torque that the simulated drives produced.

    Given: 0 < e < 1, e = exp(-h/lag); four plant steps in a period, delay of one period and three
    steps.
    """
    steps, part, h = 4, 3, PERIOD / 4
    late = {"clock.plant": h, "actuator.delay": PERIOD + part * h, "actuator.lag": 0.02}
    drives = setup("linear-first", 0, **late)
    e, lag = Assembled(guard, drives), LAG.build(drives.scenario)
    commands = [e.torque, e.p["tau_sent1"], e.p["tau_sent2"]]
    held = {port.signal.name: port.sym for port in ports_of(lag)}
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
        every(e.later["tau_applied"], mutation * total / steps),
        every(e.later["tau_acting"], acting),
        every(e.later["tau_sent1"], commands[0]), every(e.later["tau_sent2"], commands[1]),
    )  # fmt: skip
    cuts = {"e": share, "right": commands[0][0], "left": commands[0][1]}
    table = e | free | symbols("right left")
    return Statement(table, goals, (free.e > 0, free.e < 1), cuts)


@watched_claim("guard.delay.rounding.kept")
def kept(mutation: Mutation) -> Statement:
    """the bounds that the exported guard is built with have u1 = v_u1 (1 - kept), kept = (1 + n)
    2^-44 and alpha delay <= n (1 + 2^-50).

    The exported guard reserves the margin that these entries assume.

    Given: n = 1 to 5 commands in transit; alpha T <= 1 + 2^-50, v_u1, T, alpha > 0; both axes.
    """
    a, table, goals, given = QueuedAxis(), Cuts(), Group(), Group()
    for n in range(1, 6):
        guarded = setup("linear-first", n)
        p = Parameters(guarded)
        both = bounds_of(p, guarded.guard.lateness(guarded.scenario.clock), guarded.scenario.limits)
        table |= {f"{name} {n}": symbol for name, symbol in scalars(p.ports).items()}
        for axis, b in enumerate(map(both.axis, (0, 1))):
            u1 = p.take("limits.v_u1")[axis]
            assert b.delay is not None
            goals.append(b.u1 == u1 * (1 - (1 + n) * 2.0**-44))
            put = {"share": b.u1 / u1, "alpha": b.alpha, "delay": b.delay}
            goals += valued([a.sized, a.counts], a, put)
            given += positive(b.period, b.alpha, u1)
            given.append(mutation(1 + DOUBLE.quicker, 2) >= b.alpha * b.period)
    return Statement(table, goals, given)
