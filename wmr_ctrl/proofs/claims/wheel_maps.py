"""Maps behind the guard onto the wheels' torques, which keep what the guard has secured."""

import casadi as ca

from wmr_ctrl.guard.guard import MAPS
from wmr_ctrl.model.dynamics import force_to_wheel, wheel_to_force
from wmr_ctrl.proofs.claim import Claims, Mutation
from wmr_ctrl.proofs.methods.spec import Z3
from wmr_ctrl.proofs.statement import Relation, Statement, above, at_least, equal, symbols

BOX = (
    "every box lo <= hi of both axes, every force in it, |F0| + |N0|/l <= phi for the safe point "
    "(F0, N0)"
)


class MappedWheels:
    """A guard's box, a force in it, and wheels with reach phi [N]; half is l, r the radius [m]."""

    def __init__(self) -> None:
        self.symbols = symbols("lo1 hi1 lo2 hi2 force1 force2 phi half r", "phi half r")

    def pair(self, name: str) -> ca.SX:
        """Both axes of one quantity."""
        return ca.vertcat(self.symbols[f"{name}1"], self.symbols[f"{name}2"])

    @property
    def safe(self) -> ca.SX:
        """Force of least effort in the box."""
        return ca.fmin(ca.fmax(0, self.pair("lo")), self.pair("hi"))

    def within(self, force: ca.SX) -> tuple[Relation, ...]:
        """``force`` is in the box."""
        lo, hi = self.pair("lo"), self.pair("hi")
        return tuple(
            at_least(part) for i in (0, 1) for part in (force[i] - lo[i], hi[i] - force[i])
        )

    def reached(self, force: ca.SX) -> Relation:
        """``force`` is within the wheels' reach."""
        t = self.symbols
        return at_least(t["phi"], ca.fabs(force[0]) + ca.fabs(force[1]) / t["half"])

    @property
    def given(self) -> tuple[Relation, ...]:
        """The hypotheses."""
        t = self.symbols
        sides = (above(t["half"]), above(t["phi"]), above(t["r"]))
        return (*sides, *self.within(self.pair("force")), self.reached(self.safe))

    def mapped(self, name: str, safe: ca.SX) -> ca.SX:
        """Output of a map for the force."""
        return MAPS[name](self.pair("force"), self.symbols["phi"], self.symbols["half"], safe)


claim = Claims(by=Z3(effort=150))


@claim("wheels.reach", (4,), given="r, l > 0")
def torques(mutation: Mutation) -> Statement:
    """max |tau| = (r/2) (|F| + |N|/l).

    The torque limit is a diamond of forces.
    """
    w = MappedWheels()
    t = w.symbols
    torque = force_to_wheel(t["r"], t["half"], w.pair("force"))
    largest = ca.fmax(ca.fabs(torque[0]), ca.fabs(torque[1]))
    size = ca.fabs(t["force1"]) + mutation * ca.fabs(t["force2"]) / t["half"]
    return Statement(t, (equal(largest, t["r"] / 2 * size),), (above(t["half"]), above(t["r"])))


@claim("wheels.necessary", given="F + dbar1 <= 0, N + dbar2 <= 0; dbar1, dbar2 >= 0, r, l > 0")
def necessary(mutation: Mutation) -> Statement:
    """dbar1 + dbar2/l > phi = 2 tau_max/r: a force that holds both velocities at their limits needs
    a torque above tau_max.

    Motors weaker than the disturbances cannot keep both limits, whatever the guard does.
    """
    # At v = (u1, u1) a safe force has F + dbar1 <= 0 and N + dbar2 <= 0: some torque is larger.
    w = MappedWheels()
    t = {**w.symbols, **symbols("dbar1 dbar2")}
    torque = force_to_wheel(t["r"], t["half"], w.pair("force"))
    largest = ca.fmax(ca.fabs(torque[0]), ca.fabs(torque[1]))
    tight = above(t["dbar1"] + t["dbar2"] / t["half"], mutation(1, 0.99) * t["phi"])
    held = [at_least(-t[f"force{i}"], t[f"dbar{i}"]) for i in (1, 2)]
    positive = [at_least(t[f"dbar{i}"]) for i in (1, 2)] + [above(t["half"]), above(t["r"])]
    return Statement(t, (above(largest, t["phi"] * t["r"] / 2),), (*positive, *held, tight))


@claim.also(
    "wheels.rotation-first",
    "rotation-first ends in the guard's box and within reach",
    "The same when rotation is served first.",
    name="rotation-first",
)
@claim("wheels.linear-first", given=BOX)
def linear(mutation: Mutation, name: str = "linear-first") -> Statement:
    """linear-first ends in the guard's box and within reach.

    The torque limit does not undo the guard.
    """
    w = MappedWheels()
    found = w.mapped(name, mutation(w.safe, ca.SX.zeros(2)))
    return Statement(w.symbols, (*w.within(found), w.reached(found)), w.given)


@claim("wheels.per-wheel", given=BOX)
def clip_per_wheel(mutation: Mutation) -> Statement:
    """a clip of each wheel's torque ends in the guard's box.

    False: clipping one wheel changes thrust and moment at once, and can turn braking into driving.
    """
    w = MappedWheels()
    t = w.symbols
    most = t["phi"] * t["r"] / 2
    torque = force_to_wheel(t["r"], t["half"], w.pair("force"))
    found = wheel_to_force(t["r"], t["half"], ca.fmax(-most, ca.fmin(most, torque)))
    return Statement(t, w.within(mutation * found), w.given)
