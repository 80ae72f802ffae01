"""Rims of a run's own base, whose loop makes up for friction once a plant step."""

from collections.abc import Iterator

import casadi as ca

from wmr_ctrl.filter.governor import FirstOrder, largest_command
from wmr_ctrl.filter.held_loop import push_of_kick
from wmr_ctrl.model.dynamics import KEYS, friction, plant, rk4_step, wheel_to_force
from wmr_ctrl.model.system import System
from wmr_ctrl.proofs.claim import Claims, Mutation
from wmr_ctrl.proofs.claims.common import PRESET, scalars
from wmr_ctrl.proofs.ledger import HAND
from wmr_ctrl.proofs.methods.spec import Z3
from wmr_ctrl.proofs.relation import Relation, above, at_least, between, positive, when
from wmr_ctrl.proofs.statement import Statement
from wmr_ctrl.proofs.symbols import symbols
from wmr_ctrl.scenario import load_scenario

claim = Claims(by=Z3(effort=60))
POINTS = ("start", "half", "again", "end", "after")


def stages(robot: System, h: ca.SX) -> Iterator[ca.SX]:
    """v1 at each stage of a Runge-Kutta step."""
    rate, x = robot.function("rate", [robot.update]), robot.x
    yield x[3]
    for part in (h / 2, h / 2, h):
        x = robot.x + part * rate(robot.u, x, robot.p)
        yield x[3]


@claim(
    "filter.held-kick",
    given="m, g, v_s, h > 0, mu >= 0; x <= 2; F the force of loop and pushes, with h (F - "
    "F1(v1))/m >= 0; tanh rises, by no more than its argument, between all stages and v1 behind",
)
def held_kick(mutation: Mutation) -> Statement:
    """v1 goes in a Runge-Kutta step h of the plant less far than h (F - F1(v1))/m, by at most h/m
    times the rise of F1 from the step's start to its end.

    Friction held over steps takes v off its loop's way by no more, in all, than h times its range
    while v nears a command from one side. Backwards by symmetry.
    """
    robot = plant(load_scenario(PRESET))
    t = scalars((*robot.inputs, *robot.state, *robot.params))
    t |= symbols("step", "step") | symbols(" ".join(POINTS))
    m, _, mu, r, l, g, v_s = (t[key] for key in KEYS)
    tau = ca.vertcat(t.tau_right + t.noise_right, t.tau_left + t.noise_left)
    force = wheel_to_force(r, l, tau)[0] + t.thrust
    way = t.step * (force - friction(mu, m, g, v_s, robot.x[3:5])[0]) / m
    after = rk4_step(robot, t.step)[3]
    at = dict(zip(POINTS, (*stages(robot, t.step), after), strict=True))
    cuts = {"force": force} | {name: ca.tanh(v / v_s) for name, v in at.items()}
    given = [*positive(m, g, v_s, t.step), at_least(mu), at_least(way)]
    given.append(at_least(2 * m * v_s, t.step * mu * m * g))
    for k, name in enumerate(POINTS):
        for other in POINTS[:k]:
            rise, change = t[name] - t[other], (at[name] - at[other]) / v_s
            for side, on in ((1, change >= 0), (-1, change < 0)):
                given += [when(on, item) for item in between(0, side * rise, side * change)]
    before, then = (friction(mu, m, g, v_s, v)[0] for v in (robot.x[3:5], ca.vertcat(after, 0)))
    most = mutation(1, 0.9) * t.step * (then - before) / m
    return Statement(t, between(0, way - (after - t.v1), most), tuple(given), cuts)


class Command:
    """A rim of a first-order base while one command acts, as far as friction lets it go.

    ``gone`` is the share of its way that the loop went; of the ``kick`` that friction leads to at
    most, it may still lead to ``credit`` at the start and to what is ``left`` now.
    """

    def __init__(self, mutation: Mutation) -> None:
        """Name the numbers; what counts as a push leads to the kick in the shortest while."""
        self.t = t = symbols(
            "start bound asked gone gone_least gone_most credit left V d K_max kick",
            "V d K_max kick gone_least gone_most",
        )
        self.push = push_of_kick(mutation(1, 0.9) * t.kick, t.gone_least)
        kappa = 1 / t.gone_most - 1
        unused, d = ca.SX(0), t.d + self.push
        limits = FirstOrder(t.V, d, unused, unused, t.K_max, kappa)
        self.given: tuple[Relation, ...] = (
            *positive(t.V, t.K_max, t.gone_least), *between(0, t.left, t.credit),
            at_least(t.kick, t.credit), at_least(t.d), above(t.V, d), at_least(1, t.gone_most),
            at_least(t.gone_most, t.gone_least), *between(0, t.gone, t.gone_most),
            at_least(largest_command(t.bound, limits), t.asked), *between(t.start, t.bound, t.V),
            at_least(t.V, t.start + t.credit),
        )  # fmt: skip

    def reached(self, start: ca.SX, push: ca.SX, gone: ca.SX) -> ca.SX:
        """Speed behind a while."""
        t = self.t
        return (1 - gone) * start + gone * (t.K_max * t.asked + push)


HELD_RIM = (
    "a command within the governor's, with kappa = 0 the clip's, whose push is d and what is for "
    "friction; it acts while the loop goes at most what kappa counts on{}; the speed at the start "
    "within the bound that the governor counts on and, by what friction may still lead to, within V"
)


@claim(
    "filter.held-rim-falls",
    given=HELD_RIM.format(""),
    premises="filter.held-kick",
)
def held_rim_falls(mutation: Mutation) -> Statement:
    """where v falls towards the command, the rim stays within V by what friction may still lead to.

    What friction took from v's way at a rim it cannot take again before v has risen.
    """
    own = Command(mutation)
    t = own.t
    rim = own.reached(t.start, t.d, t.gone) + t.credit - t.left
    return Statement(t, (at_least(t.V, rim + t.left),), own.given)


@claim(
    "filter.held-rim-rises",
    given=HELD_RIM.format(""),
    premises="filter.held-kick",
)
def held_rim_rises(mutation: Mutation) -> Statement:
    """where v does not fall towards the command, the rim stays within V, and from the shortest time
    of a command on within V by all that friction may lead to.

    There friction only holds the rim back, and the next fall has its whole range.
    """
    own = Command(mutation)
    t = own.t
    rim = own.reached(t.start, t.d, t.gone)
    behind = ca.if_else(t.gone >= t.gone_least, t.kick, 0)
    return Statement(t, (at_least(t.V, rim + behind),), own.given)


@claim(
    "filter.held-rim-bound",
    given=HELD_RIM.format(", at least the shortest while"),
    premises="filter.held-kick",
)
def held_rim_bound(mutation: Mutation) -> Statement:
    """what the governor carries from one takeover, or from V or odometry in between, to the next
    bounds the rim's speed there, of odometry that may be off by what friction leads to, too.

    The governor's bound is right wherever it counts, though not within the time of a command.
    """
    own = Command(mutation)
    t = own.t
    carried = own.reached(t.bound, t.d + own.push, t.gone)
    true = own.reached(t.start, t.d, t.gone) + t.kick
    whole = ca.if_else(t.gone >= t.gone_least, carried - true, 0)
    seen = own.reached(ca.fmin(t.start + t.kick, t.V), t.d + own.push, t.gone)
    part = own.reached(t.start, t.d, t.gone) + t.credit
    return Statement(t, (at_least(whole), at_least(seen, part)), own.given)


@claim(
    "filter.held-kicks",
    given="commands that change at plant steps; pushes of at most d_v on v; x <= 2; 2 x d_v beside "
    "them counts as pushes, and what leads to h/m times F1's range while the shortest command acts",
    by=HAND,
    premises="filter.held-kick filter.held-rim-falls filter.held-rim-rises filter.held-rim-bound "
    "filter.mean filter.induction",
)
def held_kicks() -> None:
    """while one command acts, what friction adds to a rim's speed is at most h/m times the fall of
    F1(v) so far where v started above K u + d_v, and nothing where it did not.

    Behind clip and governor every wheel keeps its limit in every plant step, friction and all.
    """
