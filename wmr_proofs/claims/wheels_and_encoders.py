"""Bounds that sensors, drives and ground add to the guard's assumptions, on their graphs."""

from collections.abc import Mapping
from itertools import product
from typing import Any

from casadi import SX, floor, is_equal, vertcat, vertsplit

from wmr_ctrl.world import encoder, wheels
from wmr_ctrl.world.effect import Bound, Effect
from wmr_ctrl.world.model.dynamics import wheel_to_force
from wmr_ctrl.world.model.system import Parameters
from wmr_ctrl.world.scenario import load_scenario
from wmr_proofs.claim import Claims, Mutation, rows
from wmr_proofs.methods.spec import Z3, Both, Ring
from wmr_proofs.regions import FREE, NONNEGATIVE, POSITIVE, Case
from wmr_proofs.statement import (
    Named,
    Relations,
    Statement,
    at_least,
    exchanged,
    positive,
    symbols,
    within,
)
from wmr_proofs.traced import Tracing, expression, functions_for_traced, traced

from .common import ports_of, scalars

WHEELS = {"wheels.radius": [0.01, -0.01], "wheels.track": 0.01}
"""Structure of the graphs alone: their numbers stay symbols."""


class EffectGraph(Named):
    """An effect's System for a scenario with some numbers, which stay symbols.

    ``symbols``: all ports' elements by name, and the numbers that the bound alone reads;
    ``parameters``: the graph's own by their keys.
    """

    def __init__(self, effect: Effect, numbers: Mapping[str, object], tables: str = "") -> None:
        """Take the bound's numbers of ``tables`` and of its own section as symbols."""
        self.effect, self.scenario = effect, load_scenario("paper-simulation", numbers)
        self.system = effect.build(self.scenario)
        self.parameters = Parameters(self.scenario, self.system.params)
        self.tables = tuple(dict.fromkeys((effect.section.KEY, *tables.split())))
        self.told, self.trace = self._bounded(1.0)
        drawn = (item.port for item in self.system.draws)
        ports = (*ports_of(self.system), *drawn)
        self.symbols = self.trace.symbols | scalars(ports)

    def _bounded(self, share: float) -> tuple[Bound, Tracing]:
        scenario, trace = traced(self.scenario, self.tables, share)
        assert self.effect.bound is not None
        with functions_for_traced("wmr_ctrl.world", but="wmr_ctrl.world.effect"):
            return self.effect.bound(scenario), trace

    def column(self, name: str) -> SX:
        """The two elements ``name[1]`` and ``name[2]``."""
        return vertcat(self[f"{name}[1]"], self[f"{name}[2]"])

    def bound(self, name: str) -> SX:
        """The pair or number ``name`` of the effect's Bound, for the symbols of its graph.

        Conditions that its code tests on the way become part of the claim (`states`). ValueError if
        it depends on a number that is no symbol.
        """
        pairs = []
        for told, trace in ((self.told, self.trace), self._bounded(1.25)):
            value = vars(told)[name]
            pair = value if isinstance(value, tuple) else (value,)
            found = vertcat(*map(expression, pair), *trace.met)
            pairs.append(exchanged(found, trace.symbols, self))
        if not is_equal(pairs[0], pairs[1], 100):
            raise ValueError(f"the bound of {self.effect.name} holds a number that is no symbol")
        parts = vertsplit(pairs[0])
        self.always = [at_least(item, 1) for item in parts[len(pair) :]]
        return vertcat(*parts[: len(pair)])

    def above_zero(self, *names: str) -> Relations:
        """Each of these numbers is positive."""
        return [self[name] > 0 for name in names]


MISREAD = "|c - 1| u1 + |d| l' u2", "|c l'/l - 1| u2 + |d| u1/l"
MISMADE = "tau sum |1/(1 + radius_i) - 1|/r", "l tau sum |(1 + track)/(1 + radius_i) - 1|/r"

ORDERS, PLACES = "<=>", ("least", "inside", "largest")


def wheel_cases(axis: int, misread: bool) -> tuple[Case, ...]:
    """Cases of a bound on other wheels: signs of absolute values, places of two clamped numbers.

    Misread speeds: c = mean 1/(1 + radius_i) for v1, or c (1 + track) for omega, below, at or above
    1, and 1/(1 + radius_i) = c (1 +- e).  Torques: each 1 + radius_i below, at or above 1 for the
    thrust, 1 + track for the moment.
    """
    ways = product(product(ORDERS, repeat=2), product(PLACES, repeat=2))
    return tuple(_wheel_case(axis, misread, *way) for way in ways)


def _wheel_case(axis: int, misread: bool, orders: Any, places: Any) -> Case:
    free = ("robot.r", "robot.l", "encoder.counts", "clock.control", "n1", "n2", "x1", "x2", "t")
    numbers = dict.fromkeys(free, POSITIVE)
    if misread:
        sizes = "limits.v_u1[1]", "limits.v_u1[2]"
        numbers |= dict.fromkeys(sizes, POSITIVE)
    else:
        sizes = "size", "size"
        numbers |= {"size": NONNEGATIVE, "motor.step": FREE}

    def values(n: Mapping[str, Any]) -> Mapping[str, Any]:
        ratio = [{"<": 1 / (1 + n[k]), "=": 1, ">": 1 + n[k]}[o]
                 for k, o in zip(("n1", "n2"), orders, strict=True)]  # fmt: skip
        share = [{"least": -1, "inside": (1 - n[k]) / (1 + n[k]), "largest": 1}[place]
                 for k, place in zip(("x1", "x2"), places, strict=True)]  # fmt: skip
        limited = [part * n[size] for part, size in zip(share, sizes, strict=True)]
        if misread:
            mean = n["t"] if axis else ratio[0]
            track = ratio[0] / mean if axis else n["t"]
            off = {"<": -n["n2"] / (1 + n["n2"]), "=": 0, ">": n["n2"] / (1 + n["n2"])}[orders[1]]
            radii = [1 / (mean * (1 + off)), 1 / (mean * (1 - off))]
            told = dict(zip(("v", "omega"), limited, strict=True))
        else:
            track = n["t"]
            radii = [track * part if axis else part for part in ratio]
            told = dict(zip(("tau_right", "tau_left"), limited, strict=True))
            told["actuator.tau_max"] = n["size"] - n["motor.step"] / 2
        wheels = {"wheels.radius[1]": radii[0] - 1, "wheels.radius[2]": radii[1] - 1}
        kept = {name: n[name] for name in numbers if "." in name}
        return {**kept, **told, **wheels, "wheels.track": track - 1}

    return Case(f"{' '.join(orders)}; {', '.join(places)}", numbers, values)


claim = Claims()


@claim(
    "world.encoder.{name}",
    over=rows(axis=(0, 1), name=("v1", "omega"), error=("2 pi r/(N w)", "2 pi r/(N w l)")),
)
def counted_speed(mutation: Mutation, axis: int) -> Statement:
    """differences of counts over w, the window that the bound gives, give {name} with an error
    below {error}.

    What the guard counts as window, and what an encoder adds to nbar besides it.

    Given: {WHOLE}.
    """
    g = EffectGraph(encoder.ENCODER, {"encoder.counts": 64.0}, "robot clock")
    scenario, skidded = g.scenario, g["theta"] + g["skid"]
    now = encoder.turned(scenario, g.parameters, g["path"], skidded)
    turn = symbols("old_right old_left")
    old = vertcat(turn.old_right, turn.old_left)
    whole = g.column("wheel_counts_1")
    given = list[Relations]()
    for real, part in ((now, floor(now)), (old, whole)):
        for i in (0, 1):
            given += real[i] >= part[i], real[i] - part[i] < 1
    exact = encoder.velocity_of((now - old) / g["clock.control"], g.parameters)
    bound = g.bound("nbar")[axis]
    off = g.system.outputs[axis].expr - exact[axis]
    most = mutation(bound, 0.9 * bound)
    sides = g.above_zero("robot.r", "robot.l", "encoder.counts", "clock.control", "sample")
    cuts = {"turn_right": now[0], "turn_left": now[1]}
    cuts |= {"counts_right": floor(now[0]), "counts_left": floor(now[1])}
    window = g.bound("window")[axis] == g["clock.control"]
    goals = most > off, off > -most, window
    return g.states(goals, given=(sides, given), cuts=cuts, more=turn)


def _shares(g: EffectGraph) -> Relations:
    """1 + radius_i and 1 + track are positive."""
    return positive(*(1 + g[f"wheels.{name}"] for name in ("radius[1]", "radius[2]", "track")))


@claim(
    "world.wheels.misread-{name}",
    by=lambda axis: Both(Z3(), Ring(wheel_cases(axis, True))),
    over=rows(axis=(0, 1), name=("v1", "omega"), off=MISREAD),
)
def misread_speed(mutation: Mutation, axis: int) -> Statement:
    """with wheels other than believed, their turns give {name} off by at most {off}, c
    and d the mean and half the difference of 1/(1 + radius_i).

    What wrong radii add to nbar of an encoder.

    Given: {WHEELS_INSIDE}.
    """
    numbers = {"encoder.counts": 64.0, **WHEELS}
    g, t = EffectGraph(encoder.ENCODER, numbers, "robot clock wheels limits"), symbols("v omega")
    turn = encoder.turned(g.scenario, g.parameters, t.v, t.omega)
    shown = encoder.velocity_of(turn, g.parameters)[axis]
    limits = g.column("limits.v_u1")
    believed = g["robot.r"], g["robot.l"]
    counted = encoder.rounded_by(believed, g["encoder.counts"], g["clock.control"])[axis]
    most = g.bound("nbar")[axis] - counted
    off = shown - (t.v if axis == 0 else t.omega)
    sizes = g.above_zero("robot.r", "robot.l", "encoder.counts", "clock.control")
    inside = within(vertcat(*t.values()), limits), positive(limits[0], limits[1])
    given = sizes, _shares(g), inside
    return g.states(within(off, most * mutation(1, 0.9)), given=given, more=t)


@claim(
    "world.wheels.{name}",
    by=lambda axis: Both(Z3(), Ring(wheel_cases(axis, False))),
    over=rows(axis=(0, 1), name=("thrust", "moment"), off=MISMADE),
)
def wheels_thrust(mutation: Mutation, axis: int) -> Statement:
    """torques of at most tau make a {name} that is off by at most {off}.

    What wrong radii, and for the moment a wrong track, add to dbar.

    Given: {WHEELS_SIZES}.
    """
    limited = {**WHEELS, "actuator.tau_max": 5.0}
    g = EffectGraph(wheels.WHEELS, limited, "robot actuator motor")
    told, most = vertcat(g["tau_right"], g["tau_left"]), g["actuator.tau_max"]
    believed = (g["robot.r"], g["robot.l"])
    made, meant = (wheel_to_force(*believed, tau)[axis] for tau in (g.system.y, told))
    bound = g.bound("dbar")[axis]
    sizes = within(told, most + 0.5 * g["motor.step"])
    given = g.above_zero("robot.r", "robot.l"), _shares(g), sizes
    return g.states(within(made - meant, bound * mutation(1, 0.9)), given=given)
