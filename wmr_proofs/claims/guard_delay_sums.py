"""Rounding in the sums over commands in transit, one command after the other.

Results before the last command are replaced by free numbers, so what is proved for one more command
is true for any queue.
"""

import casadi as ca

from wmr_ctrl.control.guard.delay import InFlight, in_flight
from wmr_ctrl.control.guard.guard import Bounds
from wmr_ctrl.world.model.dynamics import wheel_to_force
from wmr_proofs.claim import Claims, Mutation
from wmr_proofs.methods.spec import Z3
from wmr_proofs.statement import (
    UNIT,
    Named,
    Relations,
    Statement,
    between,
    column,
    nonnegative,
    positive,
    symbols,
)

from .common import BOTH_AXES, WAYS

SENT = 5
"""Commands of the queue that is written out."""


class Queue(Named):
    """Commands under way on one axis, their sums without the factor T/M_min.

    Results before the last command are free numbers (``before``), so the queue may have any length,
    also 0. ``last``: force and time of the last command.
    """

    def __init__(self, axis: int) -> None:
        self.axis = axis
        sums = "front rear exact off grown lost ahead back counted most"
        listed = column("F", SENT) | column("N", SENT) | column("time", SENT)
        self.symbols = listed | symbols(f"dbar f_min {sums}", "dbar f_min")
        self.net = self.dbar - self.f_min
        self.last = self[f"{'FN'[axis]}{SENT}"], self[f"time{SENT}"]
        sums_before = self.sums(SENT - 1)
        self.before = {"front": sums_before.ahead, "rear": sums_before.back}

    def sums(self, count: int) -> InFlight:
        """Sums over the first ``count`` commands."""
        one, none = ca.SX(1), ca.SX(0)
        b = Bounds(one, one, one, one, self.dbar, none, one, none, self.f_min, none)
        listed = range(1, count + 1)
        sent = [(ca.vertcat(self[f"F{j}"], self[f"N{j}"]), self[f"time{j}"]) for j in listed]
        return in_flight(sent, self.axis, b)

    def known(self, *names: str) -> Relations:
        """Signs of the sums before, and how far they have grown."""
        _, time = self.last
        grown = between(3 * UNIT, self.grown, 2.0**-24)
        return time >= 0, grown, nonnegative(*(self[name] for name in names))


claim = Claims(by=Z3(), premises="assumption.libm")


@claim("guard.delay.rounding.read")
def read(mutation: Mutation) -> Statement:
    """the force that the guard reads back from a sent command differs from the exact force of its
    torques by at most 5 2^-53 of it, on either axis.

    Commands under way are remembered as torques and read back as forces.

    Given: any torques, r, l > 0{ROUNDS}.
    """
    t = symbols("right left thrust moment r half", "r half")
    exact = wheel_to_force(t.r, t.half, ca.vertcat(t.right, t.left))
    goals = []
    for place, name in enumerate(("thrust", "moment")):
        lost = mutation(5, 1) * UNIT * abs(exact[place])
        goals += [lost >= exact[place] - t[name], lost >= t[name] - exact[place]]
    computed = {"thrust": exact[0], "moment": exact[1]}
    return Statement(t, goals, positive(t.r, t.half), computed=computed)


@claim(
    "guard.delay.rounding.queue",
    each={f"{way}-{axis}": WAYS[way] | BOTH_AXES[axis] for way in WAYS for axis in BOTH_AXES},
)
def queue(mutation: Mutation, way: int, axis: int) -> Statement:
    """one command more: sum tau_j max(F_j + lost + net, 0) <= (1 + g + 3 2^-53) computed sum + off,
    off growing by tau_j (lost + 2^-52 |net|); and the same of -F_j, on each axis.

    The computed sum over the commands is too small by no more than this.

    Given: the same with g of the sum before, 3 2^-53 <= g <= 2^-24; any F_j; tau_j >= 0{ROUNDS}.
    """
    q = Queue(axis)
    name = "front" if way > 0 else "rear"
    whole = q.sums(SENT)
    computed = {"ahead": whole.ahead if way > 0 else whole.back}
    force, time = q.last
    exact = q.exact + time * ca.fmax(way * force + q.lost + q.net, 0)
    off = q.off + time * (q.lost + 2 * UNIT * abs(q.net))
    grown = 1 + q.grown + mutation(3, -9) * UNIT
    before = (1 + q.grown) * q[name] + q.off >= q.exact
    given = q.known("front", "rear", "off", "lost"), before
    goal = grown * q.ahead + off >= exact
    return Statement(q, goal, given, q.before, computed=computed)


@claim(
    "guard.delay.rounding.both",
    each=BOTH_AXES,
)
def both(mutation: Mutation, axis: int) -> Statement:
    """one command more: both computed sums together <= (1 + g + 3 2^-53) sum tau_j (most + net + 3
    2^-53 |net|); on each axis.

    The computed sum is never so large that no room is left for braking.

    Given: the same with g of the sums before; |F_j|, |net| <= most; tau_j >= 0{ROUNDS}.
    """
    q = Queue(axis)
    whole = q.sums(SENT)
    force, time = q.last
    most = q.counted + time * (q.most + q.net + 3 * UNIT * abs(q.net))
    grown = 1 + q.grown + mutation(3, -9) * UNIT
    sizes = [q.most >= size for size in (abs(q.net), force, -force)]
    before = (1 + q.grown) * q.counted >= q.front + q.rear
    given = q.known("front", "rear", "counted"), sizes, before
    computed = {"ahead": whole.ahead, "back": whole.back}
    goal = grown * most >= q.ahead + q.back
    return Statement(q, goal, given, q.before, computed=computed)


@claim("guard.delay.rounding.scaled")
def scaled(mutation: Mutation) -> Statement:
    """the sums in m/s or rad/s are those in N or N m, times T/M_min, to 4 2^-53 of that.

    The factor that is multiplied at the end.

    Given: sums >= 0, T, M_min > 0{ROUNDS}.
    """
    t = symbols("F N time period M_min dbar f_min front rear ahead back", "period M_min dbar f_min")
    one, none = ca.SX(1), ca.SX(0)
    sent = [(ca.vertcat(t.F, t.N), t.time)]

    def sums(period: ca.SX, mass: ca.SX) -> InFlight:
        numbers = (t.dbar, none, one, none, t.f_min, none)
        return in_flight(sent, 0, Bounds(one, period, mass, one, *numbers))

    raw, whole = sums(one, one), sums(t.period, t.M_min)
    goals = []
    for before, after in (("front", "ahead"), ("rear", "back")):
        exact = t[before] * t.period / t.M_min
        lost = mutation(4, 1) * UNIT * exact
        goals += [lost >= exact - t[after], lost >= t[after] - exact]
    signs = positive(t.period, t.M_min), nonnegative(t.front, t.rear)
    cuts, computed = (
        {names[0]: sums.ahead, names[1]: sums.back}
        for names, sums in ((("front", "rear"), raw), (("ahead", "back"), whole))
    )
    return Statement(t, goals, signs, cuts, computed=computed)
