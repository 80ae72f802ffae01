"""One axis of the guard in one sample: its symbols and hypotheses, for any kind of lateness.

Lateness changes the knowledge of v when the new command takes over, and the inputs of the guard's
graph; the map from the room to a force is always the same function.  Effects of commands in transit
are free sums, so that a statement is valid for any number of them.  Exponentials are symbols.
"""

from dataclasses import dataclass

from casadi import SX, fmax, vertcat

from wmr_ctrl.control.guard.delay import InFlight, Lagging, in_flight, largest_force
from wmr_ctrl.control.guard.guard import Bounds, ceiling, clipped, floor, room
from wmr_proofs.statement import (
    Cuts,
    Named,
    Number,
    Relations,
    between,
    nonnegative,
    positive,
    symbols,
)

AT_ONCE, DELAYED, LATE, LAGGING = range(4)
NUMBERS = "u1 period M_min M_max dbar nbar alpha brake f_min f_speed"
PARAMETERS = (
    f"{NUMBERS} delay jitter mixed usual fast slow falls rises_by rise_J rise rise_late most share"
)
FREE = (
    "v y asked mass t ahead back rest_ahead rest_back arrived sent other periods since extra "
    "z_ahead z_back after_ahead after_back again_ahead again_back room_ahead room_back room "
    "beyond brakes largest hat more lo chosen arrived_ahead arrived_back"
)


@dataclass(eq=False)
class GuardAxis(Named):
    """The guard's numbers, and what happens in one sample.

    ``lateness``: none; behind a delay, with ``arrived`` a bound of v+ when the new command takes
    over; late in any way, with ``sent`` the last command; the same behind a lag in [fast, slow].
    ``varies``: with jitter, or J = mixed = 0 and the graph for that. ``way`` is 1 forwards and -1
    backwards. Results of the guard's graph are computed anew at each use.

    ``net`` is dbar - f_min, calculated here independently of the guard.  Times: that for which sent
    commands matter (``late``), the delay's range J, and the time in which either of two commands
    may act (``both_act``).
    """

    lateness: int = AT_ONCE
    varies: bool = True

    def __post_init__(self) -> None:
        self.symbols = symbols(f"{PARAMETERS} {FREE}", PARAMETERS)
        self.net = self.dbar - self.f_min
        self.late = self.delay if self.lateness else SX(0)
        self.J = self.jitter if self.varies else SX(0)
        varies = self.lateness >= LATE and self.varies
        mixed = varies or self.lateness == LAGGING
        self.both_act = self.mixed if mixed else SX(0)
        late = ["delay"] * (self.lateness >= DELAYED) + ["jitter"] * varies + ["mixed"] * mixed
        self.bounds = Bounds(**{name: self[name] for name in (*NUMBERS.split(), *late)})

    def __call__(self, name: str, way: int) -> SX:
        """The symbol of one direction."""
        return self[name + ("ahead" if way > 0 else "back")]

    @property
    def again(self) -> InFlight:
        """Push of the last command if the new one comes as late as possible."""
        if self.lateness == LAGGING:
            return InFlight(self.again_ahead, self.again_back)
        return in_flight([(vertcat(self.sent, self.other), self.J / self.period)], 0, self.bounds)

    @property
    def coming(self) -> InFlight | None:
        """Push of commands in transit; None if nothing is late."""
        return self.sums if self.lateness else None

    @property
    def sums(self) -> InFlight:
        """Sums of the push of commands in transit, and its part that acts then and later."""
        if self.lateness < LATE:
            return InFlight(self.ahead, self.back)
        rest = InFlight(self.rest_ahead, self.rest_back)
        felt = None
        if self.lateness == LAGGING:
            now, after = ((self[f"{z}_ahead"], self[f"{z}_back"]) for z in ("z", "after"))
            felt = Lagging(now, after if self.varies else now, self.rise, self.rise_late)
        return InFlight(self.ahead, self.back, rest, self.again if self.varies else None, felt)

    @property
    def largest(self) -> SX:
        """Largest command."""
        return largest_force(self.bounds)

    @property
    def S(self) -> SX:
        """Largest push of any command."""
        return self.largest + self.net

    @property
    def left(self) -> tuple[SX, SX]:
        """Room to the limit ahead, and behind."""
        b, coming = self.bounds, self.coming
        return room(self.y, b, coming), room(-self.y, b, coming and coming.mirrored)

    @property
    def cuts(self) -> Cuts:
        """Caps as free numbers that satisfy `capped`."""
        return {"brakes": self.bounds.braking, "largest": self.largest} if self.lateness else {}

    @property
    def rooms(self) -> Cuts:
        """Caps and, if the room has several lines, rooms as free numbers."""
        rooms = dict(zip(("room_ahead", "room_back"), self.left, strict=True))
        return self.cuts if self.lateness < LATE else self.cuts | rooms

    def force(self, asked: SX) -> SX:
        """Force after the guard."""
        return clipped(asked, self.y, self.bounds, self.coming)

    @property
    def hi(self) -> SX:
        """Largest safe force."""
        return ceiling(self.y, self.bounds, self.coming)

    @property
    def lo(self) -> SX:
        """Smallest safe force."""
        return floor(self.y, self.bounds, self.coming)

    def push(self, way: int) -> SX:
        """Largest push while the new command acts."""
        return way * self.force(self.asked) + self.net

    @property
    def signs(self) -> Relations:
        """Signs of the numbers."""
        b, late = self.bounds, [self.delay] if self.lateness else []
        others = nonnegative(b.dbar, b.nbar, b.brake, b.f_min, b.f_speed)
        return positive(b.u1, b.period, b.M_min, b.alpha, *late), others

    @property
    def _ordered_signs(self) -> Relations:
        b = self.bounds
        return self.signs, b.M_max >= b.M_min, b.u1 > b.f_speed

    @property
    def _times(self) -> Relations:
        if self.lateness < LATE:
            return ()
        late, J, mixed = self.delay >= self.usual, self.J, self.both_act
        jitter = (J > 0, self.period >= J, mixed >= J)
        return (jitter, self.usual >= mixed, late) if self.varies else (late,)

    def sound(self, faster: float = 1) -> Relations:
        """Signs, M_min <= M_max, 2 nbar <= u1, alpha T <= 1, order of times; nothing on dbar."""
        b = self.bounds
        quick = SX(faster) >= b.alpha * b.period
        return self._ordered_signs, quick, b.u1 >= 2 * b.nbar, self._times

    def feasible(self, pushed: float = 1, faster: float = 1) -> Relations:
        """The theorem's hypotheses; factors above 1 relax the first and alpha T <= 1."""
        b = self.bounds
        have = b.M_min * b.alpha * (b.u1 - b.f_speed)
        need = 2 * self.net * (1 + b.alpha * self.late)
        known = SX(faster) >= b.alpha * b.period, pushed * have >= need
        brakes = b.u1 >= 2 * b.nbar, b.brake >= self.net
        spread = [] if self.both_act.is_zero() else [self.spread]
        return self._ordered_signs, known, brakes, self._times, spread

    @property
    def spread(self) -> Relations:
        """The inequality that jitter brings: 2 net mixed <= M_min (u1 - 2 nbar)."""
        b = self.bounds
        return b.M_min * (b.u1 - 2 * b.nbar) >= 2 * self.net * self.both_act

    @property
    def capped(self) -> Relations:
        """Facts of guard.delay.caps on the caps, except their sum."""
        brakes = self.bounds.braking
        return brakes >= 0, between(self.net, brakes, self.largest)

    def shared(self, more: float = 1) -> Relations:
        """The caps' sum: both directions together leave the room that braking needs."""
        b = self.bounds
        needed = fmax(b.braking + self.net, 0) / (b.M_min * b.alpha)
        return b.u1 - b.f_speed >= self.late * self.S / b.M_min + more * needed

    def apart(self, more: float = 1) -> Relations:
        """mixed (largest + net) <= M_min (u1 - 2 nbar), a cap's share."""
        b = self.bounds
        return more * b.M_min * (b.u1 - 2 * b.nbar) >= self.both_act * self.S

    @property
    def stated(self) -> Relations:
        """Hypotheses on numbers and caps."""
        return (self.sound(), self.capped) if self.lateness else self.feasible()

    def enough(self, rooms: tuple[SX, SX], more: float = 1) -> Relations:
        """Room for braking in addition to the push in transit, ahead or behind or both together."""
        b = self.bounds
        need = fmax(b.braking + self.net, 0)
        if self.lateness < LATE:
            left = more * (b.u1 - b.f_speed) - self.ahead - self.back
            return b.M_min * b.alpha * left >= need
        return more * b.M_min * b.alpha * fmax(fmax(*rooms), rooms[0] + rooms[1]) >= need

    def can_brake(self, more: float = 1) -> Relations:
        """Condition for a safe force to exist; a factor above 1 relaxes it."""
        if not self.lateness:
            return self.feasible(more)
        sums = self.moving if self.lateness < LATE else ()
        return self.stated, sums, self.enough((self.room_ahead, self.room_back), more)

    @property
    def measured(self) -> Relations:
        """|y - v| <= nbar."""
        gap = self.y - self.v
        return self.nbar >= gap, self.nbar >= -gap

    @property
    def inside(self) -> Relations:
        """|v| <= u1."""
        return self.u1 >= self.v, self.v >= -self.u1

    def exceeded(self, share: float) -> SX:
        """Speed reached under a push that exceeds its bound by a share of ``extra``."""
        return self.u1 + share * self.extra * (self.period + self.late) / self.M_min

    @property
    def moving(self) -> Relations:
        """No sum is negative."""
        names = ("ahead", "back", "rest_ahead", "rest_back")
        return tuple(self[name] >= 0 for name in names[: 2 if self.lateness < LATE else 4])

    def during(self, longer: float = 1) -> Relations:
        """Hypotheses 0 <= t <= T, M_min <= M <= M_max, late 0 <= since <= J, t <= T + J - since."""
        b, since, t = self.bounds, self.since, self.t
        masses = between(b.M_min, self.mass, b.M_max)
        if self.lateness < LATE:
            return between(0, t, b.period), masses
        return between(0, since, self.J), t >= 0, longer * (b.period + self.J) - since >= t, masses

    def reached(self, way: int) -> SX:
        """v+ when the new command may first take over; ``v`` is measured, or its mean."""
        speed = self.f_speed
        mean = fmax(way * self.v, speed) + self("", way)
        return mean if self.lateness < LATE else fmax(mean, speed + self("rest_", way))

    def seen(self, way: int, more: Number = 0, during: Relations = ()) -> Relations:
        """Hypotheses on `start`; ``more``: the addition by a broken bound until then."""
        if not self.lateness:
            return self.measured, during
        most, arrived = self.reached(way) + more, self.arrived
        return self.measured, during, self.moving, most >= arrived, arrived >= self.f_speed

    def start(self, way: int, more: Number = 0) -> SX:
        """v+ when the new command takes over, ``since`` later; way v if nothing is late."""
        if self.lateness < LATE:
            return self.arrived if self.lateness else way * self.v
        return self.arrived + self.since * fmax(way * self.sent + self.net + more, 0) / self.mass

    def then(self, way: int, more: Number = 0) -> SX:
        """Comparison bound of v+ t after the new command has taken over."""
        start = self.start(way, more)
        start = start if self.lateness else fmax(start, self.f_speed)
        return start + self.t * fmax(self.push(way) + more, 0) / self.mass

    def kept(self, way: int, longer: float) -> Relations:
        """Goal: inside stays inside; a factor above 1 enlarges alpha T or the acting force."""
        if not self.lateness:
            return self.feasible(1, longer), self.measured, self.inside, self.during()
        u1, arrived, brakes = self.u1, self.arrived, self.bounds.braking >= self.net
        limits = (u1 >= self.start(way), self.hi >= self.lo)
        if self.lateness < LATE:
            return self.sound(longer), brakes, self.seen(way, 0, self.during()), limits
        lines = self.lines(way, self("room_", way), u1 - arrived)
        return self.sound(), brakes, self.during(longer), arrived >= self.f_speed, lines, limits

    def beyond(self, way: int) -> SX:
        """Excess of v+ over u1 when the new command takes over."""
        return self["beyond"] if self.lateness == LAGGING else self.start(way) - self.u1

    def outside(self, way: int, during: Relations = ()) -> Relations:
        """Hypotheses past u1."""
        beyond, ordered = self.beyond(way), self.ordered(way)
        if self.lateness < LATE:
            return self.stated, self.seen(way, 0, during), beyond > 0, ordered
        if self.lateness < LAGGING:
            return self.stated, self.seen(way), self.during(), beyond > 0, ordered
        u1, most, again = self.u1, self.arrived, self.lasts(way)[2] / self.M_min
        left = u1 - most - again >= self("room_", way), self.hi >= self.lo
        return self.stated, beyond > 0, most + again - u1 >= beyond, left

    def ordered(self, way: int) -> Relations:
        """lo <= hi; the forward direction does not need it, since the clip to hi is the last."""
        return (self.hi >= self.lo,) if self.lateness and way < 0 else ()

    def withstands(self, extra: SX) -> Relations:
        """The brakes withstand a push that is too large by ``extra``."""
        b, spare = self.bounds, self.bounds.braking - self.net
        lightest, heaviest = (1, 1) if self.lateness else (b.M_min, b.M_max)
        return spare * lightest >= heaviest * extra

    def lasts(self, way: int) -> tuple[SX, SX, SX]:
        """For one direction: Z now and later, and M_min times the last command's contribution."""
        z = self("z_", way)
        if not self.varies:
            return z, z, SX(0)
        return z, self("after_", way), self("again_", way) * self.bounds.M_min

    def lines(self, way: int, left: SX, spare: SX) -> list[Relations]:
        """Each line of the room left; ``spare`` is u1 less what is reached."""
        b, J, rise, late = self.bounds, self.J, self.rise, self.rise_late
        whole = spare >= (1 + b.alpha * J) * left
        if self.lateness < LAGGING:
            again = self.again.ahead if way > 0 else self.again.back
            return [spare >= left + again, whole]
        z, after, again = (item / b.M_min for item in self.lasts(way))
        return [
            spare - again >= left, whole,
            spare - again + rise * after >= (1 + b.alpha * rise) * left,
            spare + late * z >= (1 + b.alpha * (J + late)) * left,
        ]  # fmt: skip


EACH = {
    "at-once": {"a": GuardAxis()}, "delay": {"a": GuardAxis(DELAYED)},
    "jitter": {"a": GuardAxis(LATE)},
}  # fmt: skip
"""For claims at once, behind a delay and with jitter."""
