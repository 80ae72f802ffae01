"""Symbols, hypotheses and words of the guard's claims with late velocities, jitter and lag.

One sample of one axis, all parameters symbols, for any number of commands: what those under way
count for are free sums.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import casadi as ca

from wmr_ctrl.guard.delay import InFlight, in_flight
from wmr_ctrl.guard.guard import Bounds, room
from wmr_ctrl.proofs.claims.guard_axis import LATE, NUMBERS, PRESENT, LateAxis
from wmr_ctrl.proofs.statement import Relation, above, at_least, symbols

SUMS = "ahead back rest_ahead rest_back"
TIMES = "jitter mixed usual"
CAPS = (
    "0 <= brakes, net <= brakes <= largest, late (largest + net) + max(brakes + net, 0)/alpha <= "
    "M_min (u1 - f_speed), mixed (largest + net) <= M_min (u1 - 2 nbar) (guard.late.caps)"
)
COUNTED = (
    "the sums are at most what commands of at most largest count for (guard.late.piece): rest <= "
    "(late - J) S/M_min each way, mean both ways <= (usual + mixed - 2 J) S/M_min, the last "
    "command <= J S/M_min both ways, S = largest + net, usual <= late, J <= mixed"
)


@dataclass(frozen=True)
class LatestAxis(LateAxis):
    """One axis with all that may be late; the last command sent is ``sent``.

    ``varies``: with jitter; else the graph of a delay that does not vary, J = mixed = 0.
    """

    varies: bool = True

    @property
    def J(self) -> ca.SX:
        """By how much the delay varies."""
        return self["jitter"] if self.varies else ca.SX(0)

    @property
    def mixed(self) -> ca.SX:
        """Time in which either of two commands may act."""
        return self["mixed"] if self.varies else ca.SX(0)

    @cached_property
    def symbols(self) -> dict[str, ca.SX]:
        """Every number by name."""
        names = f"{NUMBERS} {PRESENT} {LATE} {TIMES} rest_ahead rest_back"
        return symbols(names, f"{NUMBERS} delay {TIMES}")

    @cached_property
    def bounds(self) -> Bounds:
        """What the guard's graph reads."""
        at_once = Bounds(**{name: self[name] for name in NUMBERS.split()})
        if not self.varies:
            return replace(at_once, delay=self["delay"])
        return replace(at_once, delay=self["delay"], jitter=self.J, mixed=self.mixed)

    @cached_property
    def again(self) -> InFlight:
        """What the last command adds where the new one comes late."""
        pair = ca.vertcat(self["sent"], self["other"])
        return in_flight([(pair, self.J / self["period"])], 0, self.bounds)

    @property
    def coming(self) -> InFlight:
        """What is under way, as its sums."""
        rest = InFlight(self["rest_ahead"], self["rest_back"])
        return InFlight(self["ahead"], self["back"], rest, self.again if self.varies else None)

    def sound(self, faster: float = 1) -> tuple[Relation, ...]:
        """Signs, and how the times lie to each other."""
        late = at_least(self["delay"], self["usual"])
        if not self.varies:
            return (*super().sound(faster), late)
        J, mixed = self.J, self.mixed
        times = (above(J), at_least(self.bounds.period, J), at_least(mixed, J))
        return (*super().sound(faster), *times, at_least(self["usual"], mixed), late)

    @property
    def spread(self) -> Relation:
        """The inequality that jitter brings: 2 net mixed <= M_min (u1 - 2 nbar)."""
        b = self.bounds
        return at_least(b.M_min * (b.u1 - 2 * b.nbar), 2 * self.net * self.mixed)

    def apart(self, more: float = 1) -> Relation:
        """mixed (largest + net) <= M_min (u1 - 2 nbar), a cap's share."""
        b = self.bounds
        most = more * b.M_min * (b.u1 - 2 * b.nbar)
        return at_least(most, self.mixed * (self.largest + self.net))

    @property
    def moving(self) -> tuple[Relation, ...]:
        """No sum is negative."""
        return tuple(at_least(self[name]) for name in SUMS.split())

    def added(self) -> tuple[Relation, ...]:
        """What sums of commands that keep to ``largest`` are at most."""
        b, most = self.bounds, (self.largest + self.net) / self.bounds.M_min
        J, mixed, usual = self.J, self.mixed, self["usual"]
        rest = (self["delay"] - J) * most
        return (
            at_least(rest, self["rest_ahead"]), at_least(rest, self["rest_back"]),
            at_least((usual + mixed - 2 * J) * most, self["ahead"] + self["back"]),
            at_least(J * most, self.again.ahead + self.again.back), above(b.M_min),
            at_least(self["rest_ahead"], self["ahead"]), at_least(self["rest_back"], self["back"]),
        )  # fmt: skip

    def begins(self, way: int, more: ca.SX | float = 0) -> tuple[Relation, ...]:
        """``arrived`` is v+ when the new command may first take over; ``v`` the mean measured."""
        mean, rest = (
            (self["ahead"], self["rest_ahead"]) if way > 0 else (self["back"], self["rest_back"])
        )
        b = self.bounds
        most = ca.fmax(ca.fmax(way * self["v"], b.f_speed) + mean, b.f_speed + rest) + more
        return at_least(most, self["arrived"]), at_least(self["arrived"], b.f_speed)

    def takes_over(self, way: int, more: ca.SX | float = 0) -> ca.SX:
        """v+ when the new command does take over, ``since`` later."""
        push = ca.fmax(way * self["sent"] + self.net + more, 0)
        return self["arrived"] + self["since"] * push / self["mass"]

    def acts(self, beyond: float = 1) -> tuple[Relation, ...]:
        """0 <= since <= J, 0 <= t <= T + J - since, M_min <= M <= M_max."""
        b, mass = self.bounds, self["mass"]
        return (
            at_least(self["since"]), at_least(self.J, self["since"]), at_least(self["t"]),
            at_least(beyond * (b.period + self.J) - self["since"], self["t"]),
            at_least(mass, b.M_min), at_least(b.M_max, mass),
        )  # fmt: skip


def rooms_of(a: LatestAxis) -> tuple[ca.SX, ca.SX]:
    """What is left ahead and what is left behind."""
    coming = a.coming
    return room(a["y"], a.bounds, coming), room(-a["y"], a.bounds, coming.mirrored)
