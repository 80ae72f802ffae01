"""The guard's parts in controller and simulator: axes, flag, monitor, maps onto the wheels."""

from casadi import SX, fmax, fmin, if_else, vertcat

from wmr_ctrl.control.guard.guard import MAPS, Bounds, clipped, feasible, guarded
from wmr_ctrl.control.guard.lateness import AT_ONCE, Since
from wmr_ctrl.control.guard.monitor import LateMotion, least_push
from wmr_ctrl.world.model.dynamics import KEYS, force_to_wheel, plant, rk4_step, wheel_to_force
from wmr_ctrl.world.scenario import load_scenario
from wmr_proofs.claim import Claims, Mutation
from wmr_proofs.statement import (
    Group,
    Named,
    Relations,
    Statement,
    between,
    nonnegative,
    positive,
    symbols,
)

from .common import PRESET, ports_of, scalars
from .guard_axis import EACH, LATE, NUMBERS, GuardAxis

claim = Claims()


@claim("guard.axes")
def axes(mutation: Mutation) -> Statement:
    """guarded(F, y)_i = clip of F_i at y_i with the bounds of axis i, and the safe point likewise,
    i = 1, 2.

    Results for one axis hold for both.

    Given: T > 0.
    """
    one, two = GuardAxis(), GuardAxis()
    table = {f"{name}{k}": a[name] for k, a in ((1, one), (2, two)) for name in a}
    both = Bounds(**{name: vertcat(one[name], two[name]) for name in NUMBERS.split()})
    result = guarded(vertcat(one.asked, two.asked), vertcat(one.y, two.y), both)
    goals = Group()
    for i, a in enumerate((one, two)):
        goals.append(result.force[i] == clipped(mutation * a.asked, a.y, a.bounds))
        goals.append(result.safe[i] == clipped(SX(0), a.y, a.bounds))
    return Statement(table, goals, positive(one.period, two.period))


@claim("guard.promise", each=EACH)
def promise(mutation: Mutation, a: GuardAxis) -> Statement:
    """feasible = 1 implies 2 net (1 + alpha delay) <= M_min alpha (u1 - f_speed), 2 nbar <= u1,
    brake >= net, M_min <= M_max, f_speed < u1 and alpha T <= 1; with jitter also 2 net mixed <=
    M_min (u1 - 2 nbar).

    The published flag implies the theorem's hypotheses, apart from signs.

    Given: at once (delay = 0 in the claim), behind a delay, and with jitter.
    """
    b = a.bounds
    need = mutation(2, 2.01) * a.net * (1 + b.alpha * a.late)
    spread = [a.spread] if a.lateness == LATE else []
    room = b.M_min * b.alpha * (b.u1 - b.f_speed) >= need
    brakes = b.u1 >= 2 * b.nbar, b.brake >= a.net, b.alpha * b.period <= 1
    order = b.M_max >= b.M_min, b.u1 > b.f_speed
    return a.states(room, spread, brakes, order, given=feasible(b) > 0)


@claim("guard.simulated")
def simulated(mutation: Mutation) -> Statement:
    """one Runge-Kutta step h of the plant ends at v1 <= max(v1 + h max(F, 0)/m, h (|F| + 2 mu m
    g)/m), F the sum of all pushes; omega ends at omega + h N/I.

    The simulated robot is never faster than the comparison that the guard relies on, except at
    speeds that friction alone reverses within a step.  This is over the real numbers: the step's
    own rounding, some units in the last place of v a step, is not included, so the simulated v may
    exceed u1 by that much.

    Given: every mu >= 0, m, I, r, l, g, v_s, h > 0, all inputs.
    """
    robot = plant(load_scenario(PRESET))
    t = scalars(ports_of(robot)) | symbols("step", "step")
    m, inertia, mu, r, half, g, v_s = (t[key] for key in KEYS)
    tau = vertcat(t.tau_right + t.noise_right, t.tau_left + t.noise_left)
    push = wheel_to_force(r, half, tau) + vertcat(t.thrust, t.moment)
    after = rk4_step(robot, t.step)[3:5]
    friction = mu * m * g
    slow = t.step * (abs(push[0]) + mutation(2, -1) * friction) / m
    turned = after[1] == t.omega + t.step * push[1] / inertia
    goals = fmax(t.v1 + t.step * fmax(push[0], 0) / m, slow) >= after[0], turned
    given = positive(m, inertia, r, half, g, v_s, t.step), mu >= 0
    return Statement(t, goals, given, {"thrust in all": push[0], "moment in all": push[1]})


@claim("guard.monitor")
def not_blamed(mutation: Mutation) -> Statement:
    """d_least is at most the mean disturbance of the sample in the direction of motion, or 0,
    driving forwards or backwards.

    The monitor reports only bounds that are really violated.

    Given: {NUMBERS_FREE}; M_min <= M <= M_max; push of either sign; both velocities measured to
    within nbar, and beyond nbar on the same side; friction against the motion.
    """
    a = GuardAxis()
    b, t = a.bounds, symbols("old push drag e_new e_old way")
    way = if_else(t.way > 0, 1, -1)
    mean = (a.asked + way * (t.push - mutation * t.drag)) / a.mass
    new = t.old + b.period * mean
    y, before = new + t.e_new, t.old + t.e_old
    errors = [b.nbar >= side * t[name] for side in (1, -1) for name in ("e_new", "e_old")]
    given = a.feasible(), a.during(), errors, fmin(way * y, way * before) > b.nbar, t.drag >= 0
    return Statement(a | t, fmax(t.push, 0) >= least_push(y, before, a.asked, b), given)


@claim("guard.monitor-quiet")
def quiet(mutation: Mutation) -> Statement:
    """d_least = 0 where the measured velocities are not both beyond nbar on the same side.

    At rest and at a change of direction the monitor reports nothing.

    Given: any bounds with T, M_min > 0, nbar >= 0.
    """
    a = GuardAxis()
    b, old = a.bounds, SX.sym("old")
    same = fmax(fmin(a.y, old), -fmax(a.y, old)) - mutation(0, 1)
    given = positive(b.period, b.M_min), b.nbar >= 0, b.nbar >= same
    return Statement(a | {"old": old}, least_push(a.y, old, a.asked, b) == 0, given)


@claim("guard.monitor-sharp")
def sharp(mutation: Mutation) -> Statement:
    """d_least is the push of the sample, forwards and backwards.

    Without uncertainty the monitor measures the disturbance.

    Given: T > 0, nbar = 0, M_min = M_max = M > 0, no friction, push >= 0 in the direction of
    motion, which is that of both velocities.
    """
    a = GuardAxis()
    b, t = a.bounds, symbols("old push way")
    way = if_else(t.way > 0, 1, -1)
    y = t.old + b.period * (a.asked + way * t.push) / b.M_min
    exact = (b.nbar == 0, b.M_max == b.M_min, positive(b.M_min, b.period))
    ahead = (fmin(way * y, way * t.old) > 0, t.push >= 0)
    return Statement(a | t, least_push(y, t.old, a.asked, b) == mutation * t.push, (exact, ahead))


SINCE = Since(
    mean=(((1, 2), 0.5), ((2,), 0.25)),
    rest=(((1,), 0.5), ((1, 2), 0.75)),
    mean_time=0.75, rest_time=1.25, older=AT_ONCE,
)  # fmt: skip
"""Commands that may have acted: of mean either of two, then the older one; likewise of rest."""


@claim("guard.monitor-late")
def late(mutation: Mutation) -> Statement:
    """late velocities: d_least <= D if a push D and the commands that may have acted explain the
    velocity's change since the previous sample, in either direction, in the mean or from rest.

    The monitor never reports bounds that explain the motion, not even behind a delay with jitter.

    Given: mean: either of two commands for T/2, the older for T/4; rest: the newer for T/2, either
    for 3 T/4; no lag; M_min, T > 0, nbar, D >= 0; either axis.
    """
    a = GuardAxis()
    b, t = a.bounds, symbols("old D F1 F2 N1 N2")
    sent = [vertcat(t[f"F{j}"], t[f"N{j}"]) for j in (1, 2)]
    motion, old, D = LateMotion((SINCE, SINCE), sent, sent[0]), t.old, t.D
    goals, given = Group(), Group()
    given += positive(b.M_min, b.period), nonnegative(b.nbar, D)
    for axis, name in enumerate("FN"):
        goals.append(mutation(1, 1.01) * motion.least_push(axis, a.y, old, b) <= D)
        for way in (1, -1):
            newer, older = (fmax(way * t[f"{name}{j}"], 0) for j in (1, 2))
            either = fmax(newer, older)
            mean = 0.5 * either + 0.25 * older + 0.75 * D
            rest = 0.5 * newer + 0.75 * either + 1.25 * D
            moved = b.M_min * (way * (a.y - old) - 2 * b.nbar) / b.period
            begun = b.M_min * (way * a.y - b.nbar) / b.period
            given.append(fmax(mean - moved, rest - begun) >= 0)
    return Statement(a | t, goals, given)


class MappedWheels(Named):
    """A guard's box, a force in it, the ``safe`` one of least effort; wheels with reach phi [N].

    half is l, r the radius [m].
    """

    def __init__(self) -> None:
        self.symbols = symbols("lo1 hi1 lo2 hi2 force1 force2 phi half r", "phi half r")
        self.safe = fmin(fmax(0, self.pair("lo")), self.pair("hi"))

    def pair(self, name: str) -> SX:
        """Both axes of one quantity."""
        return vertcat(self[f"{name}1"], self[f"{name}2"])

    def within(self, force: SX) -> Relations:
        """``force`` is in the box."""
        lo, hi = self.pair("lo"), self.pair("hi")
        return [between(lo[i], force[i], hi[i]) for i in (0, 1)]

    def reached(self, force: SX) -> Relations:
        """``force`` is within the wheels' reach."""
        return self.phi >= abs(force[0]) + abs(force[1]) / self.half

    @property
    def given(self) -> Relations:
        """The hypotheses."""
        sides = positive(self.half, self.phi, self.r)
        return sides, self.within(self.pair("force")), self.reached(self.safe)

    @property
    def torque(self) -> SX:
        """Torques of the force."""
        return force_to_wheel(self.r, self.half, self.pair("force"))

    @property
    def largest(self) -> SX:
        """Size of the larger torque."""
        return fmax(abs(self.torque[0]), abs(self.torque[1]))

    def mapped(self, name: str, safe: SX) -> SX:
        """Output of a map for the force."""
        return MAPS[name](self.pair("force"), self.phi, self.half, safe)


map_claim = Claims()


@map_claim("wheels.reach", (4,))
def torques(mutation: Mutation) -> Statement:
    """max |tau| = (r/2) (|F| + |N|/l).

    The torque limit is a diamond of forces.

    Given: r, l > 0.
    """
    w = MappedWheels()
    size = abs(w.force1) + mutation * abs(w.force2) / w.half
    return Statement(w, w.largest == w.r / 2 * size, positive(w.half, w.r))


@map_claim("wheels.necessary")
def necessary(mutation: Mutation) -> Statement:
    """dbar1 + dbar2/l > phi = 2 tau_max/r: a force that holds both velocities at their limits needs
    a torque above tau_max.

    Motors weaker than the disturbances cannot keep both limits, whatever the guard does.

    Given: F + dbar1 <= 0, N + dbar2 <= 0; dbar1, dbar2 >= 0, r, l > 0.
    """
    # At v = (u1, u1) a safe force has F + dbar1 <= 0 and N + dbar2 <= 0: some torque is larger.
    w = MappedWheels()
    t = w | symbols("dbar1 dbar2")
    tight = t.dbar1 + t.dbar2 / t.half > mutation(1, 0.99) * t.phi
    held = [-t[f"force{i}"] >= t[f"dbar{i}"] for i in (1, 2)]
    signs = nonnegative(t.dbar1, t.dbar2), positive(t.half, t.r)
    return Statement(t, w.largest > t.phi * t.r / 2, (signs, held, tight))


@map_claim("wheels.{name}", over=tuple({"name": name} for name in MAPS))
def mapped(mutation: Mutation, name: str) -> Statement:
    """the result of {name} is in the guard's box and within reach.

    The torque limit does not undo the guard.

    Given: {BOX}.
    """
    w = MappedWheels()
    found = w.mapped(name, mutation(w.safe, SX.zeros(2)))
    return Statement(w, (w.within(found), w.reached(found)), w.given)


@map_claim("wheels.per-wheel")
def clip_per_wheel(mutation: Mutation) -> Statement:
    """after a clip of each wheel's torque the force is in the guard's box.

    False: clipping one wheel changes both thrust and moment, and can turn braking into driving.

    Given: {BOX}.
    """
    w = MappedWheels()
    most = w.phi * w.r / 2
    found = wheel_to_force(w.r, w.half, fmax(-most, fmin(most, w.torque)))
    return Statement(w, w.within(mutation * found), w.given)
