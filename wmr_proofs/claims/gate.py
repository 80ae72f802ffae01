"""The gate before a clip of first-order loops, on the graph that is compiled.

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
from wmr_proofs.statement import Cuts, Group, Relations, Statement, Symbols, exchanged, within

from .command_filter import STATED as OF_GOVERNOR
from .common import elements_of, named_ports, ports_of
from .filter_shapes import SHAPES, Keys, named_for

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


@claim("gate.inside")
def inside(mutation: Mutation) -> Statement:
    """|sent_i| <= (V_i - dbar_i)/K_max_i.

    Whatever arrives, in any order and however late, the gate sends a command that the clip could
    have sent, so the clip's theorem (filter.clip) covers the base.

    Given: {SOUND}.
    """
    g = GateStep()
    return Statement(g.symbols, g.below([mutation(1, 0.99) * top for top in g.limits]), g.sound)


@claim("gate.stop")
def stop(mutation: Mutation) -> Statement:
    """sent_i = 0.

    A stop sends 0 immediately, without a ramp.

    Given: {SOUND}; stop > 0.
    """
    g = GateStep()
    goals = tuple(g.sent[i] == mutation(0, 1e-3) * g[gate.LAST][i] for i in AXES)
    return Statement(g.symbols, goals, (g.sound, g[gate.STOP] > 0))


@claim("gate.stale")
def stale(mutation: Mutation) -> Statement:
    """|sent_i| <= max(|last_i| - fall_i t, 0).

    Without a recent command the base is brought to rest.

    Given: {SOUND}; {GONE}; age of the command > timeout.
    """
    g = GateStep()
    old = g[gate.COMMAND_AGE] > SX(SETTINGS.command_timeout)
    return Statement(g.symbols, g.falling(mutation), (g.sound, old))


@claim("gate.latched")
def latched(mutation: Mutation) -> Statement:
    """|sent_i| <= max(|last_i| - fall_i t, 0), and the step after is latched as well.

    After a stop the base stays stopped until a reset.

    Given: {SOUND}; {GONE}; latched > 0, reset <= 0.
    """
    g = GateStep()
    given = g.sound, g[gate.LATCHED] > 0, -g[gate.RESET] >= 0
    return Statement(g.symbols, (g.falling(mutation), g.system.update[-3] == 1), given)


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


@claim("gate.inside.{key}", over=SHAPES)
def inside_shapes(mutation: Mutation, more: Keys, scales: tuple[str, ...]) -> Statement:
    """|w| <= (V - dbar)/K_max, w each limited speed of the command that the gate sends: {limited}.

    The gate sends a command that the clip could have sent, for any choice of limited speeds.

    Given: a gate with its default times and ramps before a clip of first-order loops; l > 0; (V -
    dbar)/K_max > 0 of each speed; every real input of any size, any time since the last step.
    """
    table, cuts = Symbols(), Cuts()
    goals, given = Group(), Group()
    for scale in scales:
        scenario = load_scenario("paper-simulation", STATED | more | {"filter.scale": scale})
        (system, goal), clip = gate.gate_and_goal(scenario, SETTINGS), Clip(scenario)
        table |= named_for(elements_of(*ports_of(system)), scale)
        sent = SX.sym("sent", 2)
        speeds = [channel.of(sent) for channel in clip.channels]
        own = named_ports(*clip.p.ports), named_ports(*system.params)
        numbers = exchanged(vertcat(*clip.limits, *speeds), *own)
        numbers = substitute(numbers, sent, system.outputs[0].expr)
        limits, found = vertsplit(numbers, [0, len(speeds), 2 * len(speeds)])
        for i, limit in enumerate(vertsplit(limits)):
            cuts[f"limit {i} {scale}"] = limit
            given.append(limit > 0)
            goals += within(found[i], mutation(1, 0.99) * limit)
        cuts |= {f"goal{i} {scale}": goal[i] for i in AXES}
        given += [symbol > 0 for name, symbol in own[1].items() if name == "robot.l"]
    return Statement(table, goals, given, cuts)


class BehindGovernor:
    """A gate before a governor, and the governor's limits in the gate's symbols."""

    def __init__(self) -> None:
        """Read both graphs."""
        scenario = load_scenario("paper-simulation", OF_GOVERNOR)
        system, self.goal = gate.gate_and_goal(scenario, SETTINGS)
        self.governor = own = Governor(scenario)
        self.ports = ports_of(system)
        both = named_ports(*ports_of(own.system)), named_ports(*self.ports)
        limits = vertcat(*(vertcat(*side) for side in own.limits))
        self.limits, self.sent = exchanged(limits, *both), system.outputs[0].expr


@claim("gate.governor", premises="filter.limits")
def before_governor(mutation: Mutation) -> Statement:
    """sent_i is at most the governor's limit of the step, either way.

    Before a governor, too, the gate sends only commands that the filter could have sent
    (filter.sent-*).

    Given: a gate with its default times and ramps before a governor of v and omega, one factor; the
    governor's four limits above 0 (filter.limits); every real input of any size, any time since the
    last step.
    """
    g = BehindGovernor()
    goals, cuts = Group(), {f"goal{i}": g.goal[i] for i in AXES}
    given = Group()
    for side, way in enumerate(WAYS):
        for i in AXES:
            limit = g.limits[2 * side + i]
            cuts[f"limit {side} {i}"] = limit
            given.append(limit > 0)
            goals.append(mutation(1, 0.99) * limit >= way * g.sent[i])
    return Statement(elements_of(*g.ports), goals, given, cuts)
