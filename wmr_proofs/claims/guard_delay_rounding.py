"""The guard's rounding behind a constant delay, with any number of commands in transit.

As in `guard_rounding`, but the speed is the one that v can have reached when the new command starts
to act.  The share ``kept`` of u1 that is reserved, (1 + n) 2^-44 with n commands, is a symbol:
every error is bounded by a part of it.  The sums over the commands are computed one command after
the other; the contribution of one of them is shown for any earlier sum.
"""

from dataclasses import dataclass, replace

from casadi import SX, fmax, vertcat

from wmr_ctrl.control.guard.delay import InFlight, in_flight, largest_force
from wmr_ctrl.control.guard.guard import Bounds, floor
from wmr_ctrl.world.model.dynamics import wheel_to_force
from wmr_proofs.claim import Claims, Mutation
from wmr_proofs.methods.spec import Z3
from wmr_proofs.statement import (
    UNIT,
    Cuts,
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
from .guard_axis import DELAYED
from .guard_rounding import DOUBLE, ON_WHEELS, RoundedAxis

SENT = 5
"""Commands of the queue that is written out."""


class Queue(Named):
    """Commands in transit on one axis, their sums without the factor T/M_min.

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
        one, none = SX(1), SX(0)
        b = Bounds(one, one, one, one, self.dbar, none, one, none, self.f_min, none)
        listed = range(1, count + 1)
        sent = [(vertcat(self[f"F{j}"], self[f"N{j}"]), self[f"time{j}"]) for j in listed]
        return in_flight(sent, self.axis, b)

    def known(self, *names: str) -> Relations:
        """Signs and bounds of the earlier sums."""
        _, time = self.last
        grown = between(3 * UNIT, self.grown, 2.0**-24)
        return time >= 0, grown, nonnegative(*(self[name] for name in names))


claim = Claims(premises="assumption.libm")


@claim("guard.delay.rounding.read")
def read(mutation: Mutation) -> Statement:
    """the force that the guard reads back from a sent command differs from the exact force of its
    torques by at most 5 2^-53 of it, on either axis.

    Commands in transit are remembered as torques and read back as forces.

    Given: any torques, r, l > 0{ROUNDS}.
    """
    t = symbols("right left thrust moment r half", "r half")
    exact = wheel_to_force(t.r, t.half, vertcat(t.right, t.left))
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
    exact = q.exact + time * fmax(way * force + q.lost + q.net, 0)
    off = q.off + time * (q.lost + 2 * UNIT * abs(q.net))
    grown = 1 + q.grown + mutation(3, -9) * UNIT
    before = (1 + q.grown) * q[name] + q.off >= q.exact
    given = q.known("front", "rear", "off", "lost"), before
    return Statement(q, grown * q.ahead + off >= exact, given, q.before, computed=computed)


@claim("guard.delay.rounding.both", each=BOTH_AXES)
def both(mutation: Mutation, axis: int) -> Statement:
    """one command more: both computed sums together <= (1 + g + 3 2^-53) sum tau_j (most + net + 3
    2^-53 |net|); on each axis.

    The computed sum always leaves room for braking.

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
    goal = grown * most >= q.ahead + q.back
    return Statement(q, goal, given, q.before, computed={"ahead": whole.ahead, "back": whole.back})


@claim("guard.delay.rounding.scaled")
def scaled(mutation: Mutation) -> Statement:
    """the sums in m/s or rad/s are those in N or N m, times T/M_min, to 4 2^-53 of that.

    The factor at the end of the sums.

    Given: sums >= 0, T, M_min > 0{ROUNDS}.
    """
    t = symbols("F N time period M_min dbar f_min front rear ahead back", "period M_min dbar f_min")
    one, none = SX(1), SX(0)
    sent = [(vertcat(t.F, t.N), t.time)]

    def sums(period: SX, mass: SX) -> InFlight:
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


SPREAD = 16
"""Largest (G1 + G2/l)/K1 max(1, alpha delay), and the same for the second axis: the range."""
WHEELS = ON_WHEELS * SPREAD
READ = 5 * SPREAD
"""Units of K that the wheels' rounding takes, and that reading a command back from torques does."""
FAR = 15 / 32
"""Share of ``kept`` by which both sums together may be more than the caps allow."""


@dataclass(eq=False)
class QueuedAxis(RoundedAxis):
    """One axis; ``arrived`` bounds v (or -v) where the new command starts to act.

    ``share`` is the remaining share of u1, ``brakes`` and ``largest`` are the computed caps.
    ``waits`` is alpha delay, ``aim`` M_min alpha (u1 (1 - kept) - f_speed), ``over`` the error of
    the computed brakes' part of the sum, times 1 + alpha delay.
    """

    lateness: int = DELAYED
    widest: int = SPREAD

    def __post_init__(self) -> None:
        super().__post_init__()
        self.held_back, self.waits = 1 - self.share, self.alpha * self.delay
        self.aimed = replace(self.bounds, u1=self.u1 * self.share)
        self.aim = self.slope * (self.u1 * self.share - self.f_speed)
        self.over = (16 + 8 * (1 + self.waits)) * UNIT * self.reach

    @property
    def caps(self) -> Cuts:
        """The computed caps, as free numbers that satisfy `bounded`."""
        return {"brakes": self.aimed.braking, "largest": largest_force(self.aimed)}

    @property
    def stated(self) -> Relations:
        """Hypotheses of the theorem with room for rounding, without those on the caps."""
        b, less = self.bounds, self.u1 * (1 - 4 * self.held_back)
        counted = (b.dbar, b.nbar, b.f_min, b.f_speed, self.ahead, self.back)
        return (
            positive(b.u1, b.period, b.M_min, b.alpha, self.delay), nonnegative(*counted),
            b.M_max >= b.M_min,
            1 + DOUBLE.quicker >= b.alpha * b.period, self.sized,
            less >= 2 * b.nbar, less >= b.f_speed, self.reach >= self.net,
            self.reach >= -self.net,
        )  # fmt: skip

    @property
    def sized(self) -> Relations:
        """kept is that of one command or more, and small."""
        return between(1024 * UNIT, self.held_back, 2.0**-20)

    @property
    def counts(self) -> Relations:
        """kept = (1 + n) 2^-44 with alpha delay <= n, n commands."""
        return self.held_back * (1 + 2.0**-40) >= 512 * UNIT * (1 + self.waits)

    @property
    def met(self) -> Relations:
        """The conditions of the caps."""
        room = self.held_back * self.reach
        need = (1 + self.waits) * (2 * fmax(self.net, 0) + 8 * room)
        have = self.slope * (self.u1 - self.f_speed)
        brakes = self.brake >= abs(self.net) + 5 * room
        return have >= need, brakes, self.waits >= 2.0**-6, self.counts

    @property
    def bounded(self) -> Relations:
        """Bounds on the brakes and the largest command."""
        room, brakes, largest = 2 * self.held_back * self.reach, self.brakes, self["largest"]
        return brakes >= 0, brakes >= abs(self.net) + room, largest >= 0, largest >= self.net + room

    def arrives(self, way: int) -> Relations:
        """arrived <= max(way v, f_speed) + the computed push in transit, and <= u1."""
        fastest = fmax(way * self.v, self.f_speed)
        most = fastest + self("", way) * (1 + self.held_back / 64) + self.u1 * self.held_back / 8
        return most >= self.arrived, self.u1 >= self.arrived

    def leaves(self, brakes: SX) -> Relations:
        """Braking room beside both sums."""
        u1 = self.u1 * (1 - self.held_back * (1 - FAR))
        left = self.slope * (u1 - self.f_speed - self.ahead - self.back)
        return left >= fmax(brakes + self.net, 0)


def _sum(a: QueuedAxis) -> tuple[SX, SX]:
    """Sum of braking and the largest command, and the rounding in it."""
    both = a.waits * (a["largest"] + a.net) + fmax(a.brakes + a.net, 0)
    return both, (8 + 4 * a.waits) * UNIT * a.reach


@claim("guard.delay.rounding.brakes", aim="{AIM}")
def brakes(mutation: Mutation) -> Statement:
    """computed brakes >= |net| + 5 kept K, (brakes + net) (1 + alpha delay) <= {aim} + (24 + 8
    alpha delay) 2^-53 K.

    The computed braking force is right to within a few roundings.

    Given: {RANGE}; {MET}{ROUNDS}.
    """
    a = QueuedAxis()
    least = abs(a.net) + mutation(5, 5.1) * a.held_back * a.reach
    share = (a.brakes + a.net) * (1 + a.waits)
    goals = a.brakes >= least, a.aim + a.over >= share
    return Statement(a, goals, (a.stated, a.met), computed={"brakes": a.aimed.braking})


@claim("guard.delay.rounding.largest", aim="{AIM}")
def largest(mutation: Mutation) -> Statement:
    """alpha delay (largest + net) + max(brakes + net, 0), both as computed, is {aim} to (8 + 4
    alpha delay) 2^-53 K.

    The computed largest command is right to within a few roundings.

    Given: {RANGE}; {MET}{ROUNDS}.
    """
    a = QueuedAxis()
    both, off = _sum(a)
    off = mutation(1, 0.1) * off
    computed = {"brakes": a.aimed.braking, "largest": largest_force(a.aimed)}
    goals = a.aim + off >= both, both >= a.aim - off
    return Statement(a, goals, (a.stated, a.met), computed=computed)


@claim(
    "guard.delay.rounding.caps",
    premises="guard.delay.rounding.brakes guard.delay.rounding.largest",
    caps="{ROUNDED_CAPS}",
)
def caps(mutation: Mutation) -> Statement:
    """{caps}, and largest >= brakes, except for (32 + 12 alpha delay) 2^-53 K/(alpha delay).

    The computed caps keep their order.

    Given: {RANGE}; {MET}.
    """
    a = QueuedAxis()
    both, off = _sum(a)
    braked = a.brakes >= abs(a.net) + 5 * a.held_back * a.reach
    part = a.aim + a.over >= (a.brakes + a.net) * (1 + a.waits)
    more = (a.over + off) * mutation(1, 0.1)
    goals = a.bounded, more >= a.waits * (a.brakes - a["largest"])
    given = a.stated, a.met, braked, part, both >= a.aim - off
    return Statement(a, goals, given)


@claim(
    "guard.delay.rounding.room",
    premises="guard.delay.rounding.largest guard.delay.rounding.caps guard.delay.rounding.both",
)
def room(mutation: Mutation) -> Statement:
    """M_min alpha (u1 (1 - 17/32 kept) - f_speed - ahead - back) >= max(brakes + net, 0).

    Commands in transit never use the room that braking needs, as computed.

    Given: {RANGE}; {ROUNDED_CAPS}; M_min (ahead + back) <= (1 + kept/64) delay (largest + net +
    more), alpha delay more <= (400 + 20 alpha delay) 2^-53 K.
    """
    a = QueuedAxis()
    both, off = _sum(a)
    extra = (WHEELS + READ + 32 + 20 * a.waits) * UNIT * a.reach
    counted = a.delay * (a["largest"] + a.net + a.more)
    more = a.more >= 0, extra * mutation(1, 100) >= a.waits * a.more
    sums = (1 + a.held_back / 64) * counted >= a.M_min * (a.ahead + a.back)
    given = a.stated, a.counts, a.bounded, a.aim + off >= both, more, sums
    return Statement(a, a.leaves(a.brakes), given)


@claim("guard.delay.rounding.size", premises="assumption.libm guard.delay.rounding.caps")
def size(mutation: Mutation) -> Statement:
    """|F^| <= (K + max(-net, 0)) (1 + 2^-50), and |F^| <= max(largest, brakes).

    No computed force is large enough to make its rounding matter.

    Given: {RANGE}; {ROUNDED_CAPS}; brakes <= (K + max(-net, 0)) (1 + 2^-50){ROUNDS}.
    """
    a = QueuedAxis()
    reach = (a.reach + fmax(-a.net, 0)) * (1 + mutation(DOUBLE.quicker, -0.01))
    caps = fmax(a["largest"], a.brakes)
    given = a.stated, a.bounded, reach >= a.brakes
    goals = tuple(most >= way * a.hat for most in (reach, caps) for way in (1, -1))
    return Statement(a, goals, given, a.caps, computed=a.text(a.asked))


@claim("guard.delay.rounding.anchor", premises="assumption.libm guard.delay.rounding.caps")
def anchor(mutation: Mutation) -> Statement:
    """the computed safe point is at most the computed brakes.

    The computed force keeps the reserve that the wheels need.

    Given: {RANGE}; {ROUNDED_CAPS}{ROUNDS}.
    """
    a = QueuedAxis()
    most = mutation(1, 0.99) * a.brakes
    goals = most >= a.hat, most >= -a.hat
    given = a.stated, a.bounded
    return Statement(a, goals, given, a.caps, computed=a.text(SX(0)))


@claim(
    "guard.delay.rounding.force",
    by=Z3(first=("Brown's order",)),
    premises="assumption.libm guard.delay.rounding.caps guard.delay.rounding.room",
    each=WAYS,
)
def force(mutation: Mutation, way: int) -> Statement:
    """the computed force F^ has F^ + net + 288 2^-53 K <= max(M_min alpha (u1 (1 - kept/32) - v+),
    0), v+ being v or f_speed where the new command starts to act; and the same of -F^ and -v.

    The computed force keeps the limit ahead and back, with room for the rounding of the wheels'
    torques.

    Given: {RANGE}; {ROUNDED_CAPS}; |y - v| <= nbar + 2^-53 |v|; v+ <= max(v, f_speed) + (1 +
    kept/64) ahead + u1 kept/8 and v+ <= u1, back the same of -v; this claim ahead also covers lo(y)
    = -hi(-y); guard.delay.rounding.room{ROUNDS}.
    """
    # Ahead, whatever lo is; back, lo being what hi is ahead, mirrored.
    a = QueuedAxis()
    b = a.aimed if mutation > 0 or way < 0 else a.bounds
    cuts = {"brakes": b.braking, "largest": largest_force(b), "lo": floor(a.y, b, a.coming)}
    given = [a.stated, a.measured]
    if way > 0:
        given += [a.arrives(way), a.brakes >= a.net + 2 * a.held_back * a.reach]
    else:
        given += [a.bounded, a.arrives(way), a.safe(way, a["lo"]), a.leaves(mutation * a.brakes)]
    return Statement(a, a.safe(way, a.hat), given, cuts, computed=a.text(a.asked, b))


PARTS = " ".join(part.id for part in claim.listed)


@claim(
    "guard.delay.rounding",
    premises=f"{PARTS} guard.delay.rounding.kept guard.rounding.maps guard.rounding.torques "
    "guard.axes guard.lemma",
)
def together(mutation: Mutation) -> Statement:
    """v+ + t max(F + net, 0)/M <= u1 for all t in [0, T], F the exact force of the torques that the
    compiled text computes, v+ = max(v, f_speed) <= u1 where it starts to act; the same for -v.

    Behind a constant delay, too, the exact robot keeps the limit to the last bit, with any number
    of commands in transit; their sum is composed by hand.

    Given: {RANGE}; F <= the larger of two forces that are safe as in guard.delay.rounding.force, to
    288 2^-53 K; no overflow, no underflow.
    """
    # ``hat``: the exact force of the torques; ``asked`` and ``most``: the forces it is between.
    a = QueuedAxis()
    lost = mutation(1, 2) * a.on_wheels
    end = a.arrived + a.t * fmax(a.hat + a.net, 0) / a.mass
    lies = fmax(a.asked, a.most) + lost >= a.hat, a.safe(1, a.asked), a.safe(1, a.most)
    given = a.stated, a.during(), a.u1 >= a.arrived, a.arrived >= a.f_speed, lies
    return Statement(a, a.u1 >= end, given)
