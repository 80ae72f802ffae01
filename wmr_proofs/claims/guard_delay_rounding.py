"""The guard's rounding behind a constant delay, with any number of commands under way.

As `guard_rounding`, but the speed that is counted is what v can have reached when the new command
starts to act.  The share ``kept`` of u1 that is kept back, (1 + n) 2^-44 with n commands, is
a symbol: every error is bounded by a part of it.  The sums over the commands are computed one
command after the other; what one of them adds is shown for any sum before it.
"""

from dataclasses import dataclass, replace

import casadi as ca

from wmr_ctrl.control.guard.delay import largest_force
from wmr_ctrl.control.guard.guard import floor
from wmr_proofs.claim import Claims, Mutation
from wmr_proofs.methods.spec import Z3
from wmr_proofs.statement import UNIT, Cuts, Relations, Statement, between, nonnegative, positive

from . import guard_delay_sums as sums
from .common import WAYS
from .guard_axis import DELAYED
from .guard_rounding import DOUBLE, ON_WHEELS, RoundedAxis

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

    ``share`` is what is left of u1, ``brakes`` and ``largest`` the computed caps.  ``waits`` is
    alpha delay, ``aim`` M_min alpha (u1 (1 - kept) - f_speed), ``over`` the error of the computed
    brakes' part of the sum, times 1 + alpha delay.
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
        need = (1 + self.waits) * (2 * ca.fmax(self.net, 0) + 8 * room)
        have = self.slope * (self.u1 - self.f_speed)
        brakes = self.brake >= abs(self.net) + 5 * room
        return have >= need, brakes, self.waits >= 2.0**-6, self.counts

    @property
    def bounded(self) -> Relations:
        """Bounds on the brakes and the largest command."""
        room, brakes, largest = 2 * self.held_back * self.reach, self.brakes, self["largest"]
        least = brakes >= 0, brakes >= abs(self.net) + room
        return least, largest >= 0, largest >= self.net + room

    def arrives(self, way: int) -> Relations:
        """arrived <= max(way v, f_speed) + the computed push under way, and <= u1."""
        fastest = ca.fmax(way * self.v, self.f_speed)
        most = fastest + self("", way) * (1 + self.held_back / 64) + self.u1 * self.held_back / 8
        return most >= self.arrived, self.u1 >= self.arrived

    def leaves(self, brakes: ca.SX) -> Relations:
        """Braking room beside both sums."""
        u1 = self.u1 * (1 - self.held_back * (1 - FAR))
        left = self.slope * (u1 - self.f_speed - self.ahead - self.back)
        return left >= ca.fmax(brakes + self.net, 0)


def _sum(a: QueuedAxis) -> tuple[ca.SX, ca.SX]:
    """Sum of braking and the largest command, and the rounding in it."""
    both = a.waits * (a["largest"] + a.net) + ca.fmax(a.brakes + a.net, 0)
    return both, (8 + 4 * a.waits) * UNIT * a.reach


claim = Claims(by=Z3(), premises="assumption.libm")


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
    computed = {"brakes": a.aimed.braking}
    return Statement(a, goals, (a.stated, a.met), computed=computed)


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
    """{caps}, and largest >= brakes but for (32 + 12 alpha delay) 2^-53 K/(alpha delay).

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

    Commands under way never take the room that braking needs, as computed.

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


@claim(
    "guard.delay.rounding.size",
    premises="assumption.libm guard.delay.rounding.caps",
)
def size(mutation: Mutation) -> Statement:
    """|F^| <= (K + max(-net, 0)) (1 + 2^-50), and |F^| <= max(largest, brakes).

    No computed force is large enough to make its rounding matter.

    Given: {RANGE}; {ROUNDED_CAPS}; brakes <= (K + max(-net, 0)) (1 + 2^-50){ROUNDS}.
    """
    a = QueuedAxis()
    reach = (a.reach + ca.fmax(-a.net, 0)) * (1 + mutation(DOUBLE.quicker, -0.01))
    caps = ca.fmax(a["largest"], a.brakes)
    given = a.stated, a.bounded, reach >= a.brakes
    goals = tuple(most >= way * a.hat for most in (reach, caps) for way in (1, -1))
    return Statement(a, goals, given, a.caps, computed=a.text(a.asked))


@claim(
    "guard.delay.rounding.anchor",
    premises="assumption.libm guard.delay.rounding.caps",
)
def anchor(mutation: Mutation) -> Statement:
    """the computed safe point is at most the computed brakes.

    What the wheels must keep in reserve is what the computed force keeps in reserve.

    Given: {RANGE}; {ROUNDED_CAPS}{ROUNDS}.
    """
    a = QueuedAxis()
    most = mutation(1, 0.99) * a.brakes
    goals = most >= a.hat, most >= -a.hat
    given = a.stated, a.bounded
    return Statement(a, goals, given, a.caps, computed=a.text(ca.SX(0)))


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
    kept/64) ahead + u1 kept/8 and v+ <= u1, back the same of -v; lo(y) = -hi(-y) is what this says
    ahead; guard.delay.rounding.room{ROUNDS}.
    """
    # Ahead, whatever lo is; back, lo being what hi is ahead, mirrored.
    a = QueuedAxis()
    b = a.aimed if mutation > 0 or way < 0 else a.bounds
    cuts = {"brakes": b.braking, "largest": largest_force(b), "lo": floor(a.y, b, a.coming)}
    given = [a.stated, a.measured]
    if way > 0:
        given += [a.arrives(way), a.brakes >= a.net + 2 * a.held_back * a.reach]
    else:
        left = a.leaves(mutation * a.brakes)
        given += [a.bounded, a.arrives(way), a.safe(way, a["lo"]), left]
    goal, text = a.safe(way, a.hat), a.text(a.asked, b)
    return Statement(a, goal, given, cuts, computed=text)


PARTS = " ".join(part.id for part in (*sums.claim.listed, *claim.listed))
WHEELS_ENTRIES = "guard.rounding.maps guard.rounding.torques"


@claim(
    "guard.delay.rounding",
    premises=f"{PARTS} guard.delay.rounding.kept {WHEELS_ENTRIES} guard.axes guard.lemma",
)
def together(mutation: Mutation) -> Statement:
    """v+ + t max(F + net, 0)/M <= u1 for all t in [0, T], F the exact force of the torques that the
    compiled text computes, v+ = max(v, f_speed) <= u1 where it starts to act; the same for -v.

    Behind a constant delay, too, the limit is kept by the exact robot to the last bit, with any
    number of commands under way; what they add up to is put together by hand.

    Given: {RANGE}; F <= the larger of two forces that are safe as in guard.delay.rounding.force, to
    288 2^-53 K; no overflow, no underflow.
    """
    # ``hat``: the exact force of the torques; ``asked`` and ``most``: the forces it is between.
    a = QueuedAxis()
    lost = mutation(1, 2) * a.on_wheels
    end = a.arrived + a.t * ca.fmax(a.hat + a.net, 0) / a.mass
    begins = a.u1 >= a.arrived, a.arrived >= a.f_speed
    lies = ca.fmax(a.asked, a.most) + lost >= a.hat, a.safe(1, a.asked), a.safe(1, a.most)
    given = a.stated, a.during(), begins, lies
    return Statement(a, a.u1 >= end, given)
