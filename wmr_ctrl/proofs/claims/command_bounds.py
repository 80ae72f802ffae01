"""Commands on their way to a base that takes velocities: what is lost, late or rounded of them."""

import casadi as ca

from wmr_ctrl.proofs.claim import Claims, Mutation
from wmr_ctrl.proofs.claims.world import EffectGraph
from wmr_ctrl.proofs.methods.spec import Z3
from wmr_ctrl.proofs.statement import (
    Relation,
    Statement,
    above,
    at_least,
    equal,
    every,
    symbols,
    within,
)
from wmr_ctrl.world import command_delay, command_loss, command_quantum, jitter

claim = Claims(by=Z3(effort=150))


@claim("world.command-delay.bound", given="any delay")
def command_delay_bound(mutation: Mutation) -> Statement:
    """the bound of a command's delay is what its own graph holds a command back by, which it leaves
    as it is.

    What the governor counts as the delay of a command.
    """
    g = EffectGraph(command_delay.COMMAND_DELAY, (("base.delay", 0.02),))
    assert g.system.transport is not None
    late = equal(g.bound("delay")[0], mutation * g.system.transport)
    return g.states((late, *every(g.system.y, g.system.u)), ())


@claim(
    "world.command-loss.bound",
    given="losses > 0 whole, timeout >= (losses + 1) T; T a multiple of h > 0; so far no more were "
    "missed in a row than the bound tells, and silence lasts for the periods that were missed",
)
def command_loss_bound(mutation: Mutation) -> Statement:
    """no more commands in a row are missed than the bound tells, silence lasts for the periods that
    were missed and no longer, and the base never stops in between.

    What the governor counts as lost commands.
    """
    numbers = (("base.losses", 2), ("base.timeout", 0.05), ("clock.control", 0.01))
    g = EffectGraph(command_loss.COMMAND_LOSS, numbers, "clock")
    t = symbols("steps phase before")
    h, T, most = g["clock.plant"], g["clock.control"], g.bound("losses")[0]
    steps = jitter.whole(T / h)
    since = g["step"] - jitter.whole(g["base.delay"] / h)
    cuts = {"steps": steps, "phase": since - steps * ca.floor(since / steps)}
    missed, silent = g[command_loss.MISSED.name], g[command_loss.SILENT.name]
    given = (
        above(h), equal(T, t["steps"] * h), above(g["base.losses"]), at_least(t["steps"], 1),
        at_least(g["base.timeout"], (g["base.losses"] + 1) * T), at_least(missed),
        at_least(most, missed), at_least((most - missed) * (most - missed - 1)),
        at_least(t["before"]), at_least(t["steps"], t["before"] + 1), at_least(silent),
        equal(t["phase"], ca.if_else(t["before"] + 1 >= t["steps"], 0, t["before"] + 1)),
        at_least((t["steps"] - t["before"] - 1) * (t["steps"] - t["before"] - 2)),
        at_least(missed * t["steps"] + t["before"], silent),
    )  # fmt: skip
    now, silence, missing = ca.vertsplit(g.system.update, [0, 2, 3, 4])
    goals = (
        at_least(mutation(1, 0.9) * most, missing),
        at_least(missing * t["steps"] + t["phase"], silence),
        *every(g.system.y, now),
    )
    return g.states(goals, given, cuts, t)


@claim("world.command-quantum.bound", given="step > 0; whole parts of two numbers: n <= x < n + 1")
def command_quantum_bound(mutation: Mutation) -> Statement:
    """a rounded command is off by at most half a step, per axis.

    What the governor counts as the error of a command.
    """
    g = EffectGraph(command_quantum.COMMAND_QUANTUM, (("base.quantum", [0.01, 0.01]),))
    off, most, given = g.system.y - g.system.u, g.bound("command"), list[Relation]()
    cuts = dict[str, ca.SX]()
    for i in (0, 1):
        step = g[f"base.quantum[{i + 1}]"]
        x = g.system.u[i] / ca.if_else(step > 0, step, 1) + 0.5
        cuts[f"number{i + 1}"] = number = ca.floor(x)
        given += [above(step), at_least(x, number), above(1, x - number)]
    goals = [item for i in (0, 1) for item in within(off[i], mutation(1, 0.9) * most[i])]
    return g.states(goals, given, cuts)
