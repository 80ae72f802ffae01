"""The gate before a clip or governor of first-order loops, on the graph that is compiled.

Times and ramps are the defaults of `GateSettings`; any numbers come in.
"""

from casadi import SX, fmax, fmin, if_else, substitute, vertcat, vertsplit

from wmr_ctrl.control.filter import gate
from wmr_ctrl.control.filter.channels import AXES, WAYS, usable_time
from wmr_ctrl.control.filter.clip import Clip
from wmr_ctrl.control.filter.governor_step import Governor
from wmr_ctrl.core.signals import Signal
from wmr_ctrl.world.scenario import load_scenario
from wmr_proofs.claim import Claims, Mutation
from wmr_proofs.statement import Group, Relations, Statement, exchanged

from .command_filter import SHAPES, Keys
from .command_filter import STATED as OF_GOVERNOR
from .common import elements_of, named_ports, ports_of

STATED = {
    "filter.kind": "clip", "filter.gain": OF_GOVERNOR["filter.gain"], "filter.d": [0.05, 0.05],
}  # fmt: skip


SETTINGS = gate.GateSettings()
claim = Claims()


class GateStep:
    """Symbols of a step of the gate before a clip, and the command that leaves it (``sent``).

    ``gone``: the time in which a command may change [s]; ``timed`` are the hypotheses that define
    it.
    """

    def __init__(self) -> None:
        """Read the graph."""
        scenario = load_scenario("paper-simulation", STATED)
        self.system, self.goal = gate.gate_and_goal(scenario, SETTINGS)
        ports = ports_of(self.system)
        self.ports = {item.signal: item.sym for item in ports}
        self.symbols, self.sent = elements_of(*ports), self.system.outputs[0].expr
        T, elapsed = SX(scenario.clock.control), self[gate.ELAPSED]
        self.gone = usable_time(elapsed, T)
        self.timed = self.gone == if_else(elapsed == 0, T, fmax(fmin(elapsed, T), 0))
        clip = Clip(scenario)
        each = (channel.bounds for channel in clip.channels)
        bounds = vertcat(*(x for b in each for x in (b.V, b.dbar, b.K_min, b.K_max)))
        own = named_ports(*clip.p.ports), named_ports(*self.system.params)
        *numbers, hi1, hi2 = vertsplit(exchanged(vertcat(bounds, *clip.limits), *own))
        self.limits, self.bounds = (hi1, hi2), [numbers[:4], numbers[4:]]

    def __getitem__(self, signal: Signal) -> SX:
        """The symbol of a port."""
        return self.ports[signal]

    @property
    def sound(self) -> Relations:
        """Hypotheses: the parameters leave some safe command."""
        given = Group()
        for V, dbar, low, high in self.bounds:
            given += [dbar < V, dbar >= 0, low > 0, high >= low]
        return tuple(given)

    def below(self, tops: list[SX]) -> Relations:
        """|sent_i| <= top_i for both axes."""
        return tuple(tops[i] >= way * self.sent[i] for i in AXES for way in WAYS)

    def falling(self, mutation: Mutation) -> Relations:
        """|sent_i| <= max(|last_i| - fall_i t, 0) for both axes."""
        last = self[gate.LAST]
        step = [mutation(1, 1.1) * SETTINGS.fall[i] * self.gone for i in AXES]
        return self.timed, self.below([fmax(abs(last[i]) - step[i], 0) for i in AXES])


BEHIND: dict[str, Keys] = {
    **{name: {"stated": STATED | shape["more"], "of": Clip} for name, shape in SHAPES.items()},
    "governor": {"stated": OF_GOVERNOR, "of": Governor},
}
"""Filters behind a gate."""


@claim("gate.inside", premises="filter.limits", each=BEHIND)
def inside(mutation: Mutation, stated: Keys, of: type[Clip] | type[Governor]) -> Statement:
    """|w| <= (V - dbar)/K_max, w each limited speed of the command that the gate sends before a
    clip: v and omega, both wheels, or all of these, in each way to scale but one factor beside
    wheels; before a governor of v and omega, one factor, w is at most its limit of the step.

    Whatever arrives, in any order and however late, the gate sends a command that the filter could
    have sent, so the filter's theorem (filter.clip, filter.step) covers the base.

    Given: a gate with its default times and ramps before a filter of first-order loops; l > 0; one
    limit for both directions; (V - dbar)/K_max > 0 of each speed, V less 2^-26 of it, the
    governor's four limits above 0 (filter.limits); every real input of any size, any time since the
    last step; {PLAIN}.
    """
    scenario = load_scenario("paper-simulation", stated)
    (system, goal), own = gate.gate_and_goal(scenario, SETTINGS), of(scenario)
    ports, asked = ports_of(system), SX.sym("sent", 2)
    sides = own.limits if isinstance(own, Governor) else [own.limits] * 2
    speeds = [channel.of(asked) for channel in own.channels]
    both = named_ports(*ports_of(own.system)), named_ports(*ports)
    numbers = exchanged(vertcat(*speeds, *sides[0], *sides[1]), *both)
    parts = vertsplit(substitute(numbers, asked, system.outputs[0].expr))
    found, cuts = parts[: len(speeds)], {f"goal{i}": goal[i] for i in AXES}
    goals, given = Group(), [item > 0 for name, item in both[1].items() if name == "robot.l"]
    for side, way in enumerate(WAYS):
        for i, w in enumerate(found):
            limit = parts[(1 + side) * len(found) + i]
            cuts[f"limit {side} {i}"] = limit
            given.append(limit > 0)
            goals.append(mutation(1, 0.99) * limit >= way * w)
    return Statement(elements_of(*ports), goals, given, cuts)


@claim("gate.stop")
def stop(mutation: Mutation) -> Statement:
    """sent_i = 0.

    A stop sends 0 immediately, without a ramp.

    Given: {SOUND}; stop > 0.
    """
    g = GateStep()
    goals = tuple(g.sent[i] == mutation(0, 1e-3) * g[gate.LAST][i] for i in AXES)
    return Statement(g.symbols, goals, (g.sound, g[gate.STOP] > 0))


@claim("gate.falls", each={"stale": {"latched": False}, "latched": {"latched": True}})
def falls(mutation: Mutation, latched: bool) -> Statement:
    """|sent_i| <= max(|last_i| - fall_i t, 0) where the command is older than timeout or the gate
    is latched; if it is, it is so at the step after.

    Without a recent command the base is brought to rest; what was stopped stays stopped until a
    reset.

    Given: {SOUND}; {GONE}; age of the command > timeout, or latched > 0, reset <= 0.
    """
    g = GateStep()
    if latched:
        given = g.sound, g[gate.LATCHED] > 0, -g[gate.RESET] >= 0
        return Statement(g.symbols, (g.falling(mutation), g.system.update[-3] == 1), given)
    old = g[gate.COMMAND_AGE] > SX(SETTINGS.command_timeout)
    return Statement(g.symbols, g.falling(mutation), (g.sound, old))


@claim("gate.rise")
def rise(mutation: Mutation) -> Statement:
    """|sent_i| <= |last_i| + rise_i t.

    No command speeds the base up faster than stated.

    Given: {SOUND}; {GONE}; any command at the end of the ramp.
    """
    g = GateStep()
    step = [mutation(1, 0.9) * SETTINGS.rise[i] * g.gone for i in AXES]
    goals = g.timed, g.below([abs(g[gate.LAST][i]) + step[i] for i in AXES])
    return Statement(g.symbols, goals, g.sound, {f"goal{i}": g.goal[i] for i in AXES})
