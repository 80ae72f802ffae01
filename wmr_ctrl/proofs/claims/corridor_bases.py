"""Assumptions of the certified corridor about bases that take velocities, and what is sent to them.

Each condition that is checked for a scenario leaves the graph as `wmr_ctrl.corridor` reads it.
"""

import casadi as ca

from wmr_ctrl.filter.channels import WAYS, Channel, scaled
from wmr_ctrl.filter.governor import FirstOrder
from wmr_ctrl.proofs.claim import Claims, Mutation
from wmr_ctrl.proofs.claims.world import EffectGraph, positive
from wmr_ctrl.proofs.methods.spec import Z3
from wmr_ctrl.proofs.statement import Relation, Statement, above, at_least, every, symbols
from wmr_ctrl.world import command_dead_band, speed_loop_pi, wheel_speed_limit

claim = Claims(by=Z3(effort=150))

NOTHING = FirstOrder(*(ca.SX(0) for _ in range(6)))
SCALES = (
    {"key": "curvature", "words": "one factor", "scale": "curvature", "kinds": "axes wheels"},
    {"key": "axes", "words": "each axis its own factor", "scale": "axes", "kinds": "axes"},
    {"key": "turn", "words": "turning first", "scale": "turn", "kinds": "axes wheels"},
    {"key": "drive", "words": "driving first", "scale": "drive", "kinds": "axes wheels"},
    {"key": "wheels-curvature", "words": "wheels, one factor", "scale": "curvature",
     "kinds": "wheels"},
    {"key": "wheels-turn", "words": "wheels, turning first", "scale": "turn", "kinds": "wheels"},
    {"key": "wheels-drive", "words": "wheels, driving first", "scale": "drive", "kinds": "wheels"},
)  # fmt: skip
"""How a filter brings a command within its limits, and the speeds that it limits."""


@claim("corridor.filter-{key}", given="limits and l > 1e-29", over=SCALES)
def passes(mutation: Mutation, scale: str, kinds: str) -> Statement:
    """A command of which no limited speed is beyond its limit is sent as it is ({words}).

    On this condition the base gets what the law asks for.
    """
    t = symbols("v omega l A B C", "l A B C")
    unit = ((ca.SX(1), ca.SX(0)), (ca.SX(0), ca.SX(1)))
    rows = list(unit) * ("axes" in kinds)
    most = [t["A"], t["B"]] * ("axes" in kinds)
    if "wheels" in kinds:
        rows, most = [*rows, *((ca.SX(1), way * t["l"]) for way in WAYS)], [*most, t["C"], t["C"]]
    channels, asked = [Channel(row, NOTHING, 0.0) for row in rows], (t["v"], t["omega"])
    sent = scaled(asked, channels, [-item for item in most], most, scale)
    given = (
        *(above(t[name], 1e-29) for name in ("l", "A", "B", "C")),
        *(at_least(mutation(1, 2) * size, ca.fabs(channel.of(asked)))
          for channel, size in zip(channels, most, strict=True)),
    )  # fmt: skip
    return Statement(t, every(sent, ca.vertcat(*asked)), given)


@claim("corridor.dead-band", given="any size")
def dead_band(mutation: Mutation) -> Statement:
    """a command behind the dead band is off by at most its size, and by nothing where it is larger.

    What the dead band does counts as an error of the command.
    """
    g = EffectGraph(command_dead_band.COMMAND_DEAD_BAND, (("base.deadband", [0.01, 0.01]),))
    goals = list[Relation]()
    for i in (0, 1):
        size, off = g[f"base.deadband[{i + 1}]"], g.system.y[i] - g.system.u[i]
        beyond = ca.fabs(g.system.u[i]) > size
        goals.append(at_least(mutation(1, 0.9) * ca.fabs(size), ca.fabs(off)))
        goals.append(at_least(0, ca.if_else(beyond, ca.fabs(off), 0)))
    return g.states(goals, [at_least(g[f"base.deadband[{i + 1}]"]) for i in (0, 1)])


@claim("corridor.wheel-speed", given="r, l, w_max > 0")
def wheel_speed(mutation: Mutation) -> Statement:
    """|v + l omega|, |v - l omega| <= r w_max imply that the firmware leaves the command as it is.

    On this condition no wheel's speed is clipped.
    """
    g = EffectGraph(wheel_speed_limit.WHEEL_SPEED_LIMIT, (("base.w_max", 10.0),))
    r, l, most = g["robot.r"], g["robot.l"], g["base.w_max"]
    speeds = (g.system.u[0] + way * l * g.system.u[1] for way in WAYS)
    given = (
        *(above(item) for item in (r, l, most)),
        *(at_least(mutation(1, 2) * r * most, ca.fabs(speed)) for speed in speeds),
    )
    return g.states(every(g.system.y, g.system.u), given)


@claim("corridor.pi-loop", given="r, l, tau_max > 0; no wheel is at its torque limit")
def pi_loop(mutation: Mutation) -> Statement:
    """the PI loop whose integral may rest does what the one does whose integral never rests.

    Without a torque limit that acts, the certificate may take the loop for a linear one.
    """
    g, plain = (
        EffectGraph(speed_loop_pi.PI, (("base.antiwindup", resting),)) for resting in (True, False)
    )
    own = g.system
    graph = plain.system.function("plain", [plain.system.update, plain.system.y])
    following, torque = graph(own.u, own.x, own.p)
    most = g["actuator.tau_max"]
    given = [
        *positive(g, "robot.r", "robot.l", "actuator.tau_max"),
        *(above(mutation(1, 2) * most, ca.fabs(torque[i])) for i in (0, 1)),
    ]
    return g.states([*every(own.update, following), *every(own.y, torque)], given)
