"""Block: a System as one function of all that it knows, with its derivatives, for stand-alone use.

A block's known values z lie side by side: inputs, parameters, state.  Its results w are the rates
(continuous systems), the outputs that are no states, and the diagnostics.
"""

from dataclasses import dataclass, replace

import casadi as ca

from wmr_ctrl.codegen.emit import Kernel, kernel
from wmr_ctrl.control.controller import asking_controller, guard
from wmr_ctrl.control.loop import rolling_of
from wmr_ctrl.control.setup import Setup
from wmr_ctrl.filter.channels import AXES, FLAG_MEANINGS, FLAG_NAMES, FLAGS, SENT, has_bit
from wmr_ctrl.filter.filter import called_filter
from wmr_ctrl.model.dynamics import plant, rk4_step
from wmr_ctrl.model.system import Output, Parameters, System, port, stack
from wmr_ctrl.scenario import Scenario
from wmr_ctrl.signals import ASKED, Signal
from wmr_ctrl.world.effect import EffectRole
from wmr_ctrl.world.references.kind import reference
from wmr_ctrl.world.registry import EFFECTS

PARALLEL = Signal(
    "clock.parallel",
    "1",
    "1: for masters that step all parts at once; the first sample uses the inputs of "
    "initialisation",
)
"""Parameter of sampled blocks with inputs that their kernels do not read; the stepping does."""

Entry = tuple[int, int, bool]
"""Row of w, row of z, and whether the derivative there is a constant."""


@dataclass(frozen=True)
class Block:
    """A System and its results beyond continuous states, with its kernels and serialised graph.

    ``kernels`` are those of the native loop, from the same graphs and under the same names of
    vectors, so that both compute the same bits; ``derivatives`` need not be fast.
    """

    system: System
    results: tuple[Output, ...]
    kernels: tuple[Kernel, ...]
    derivatives: tuple[Kernel, ...]
    jacobian: tuple[Entry, ...]
    graph: str


def plant_block(scenario: Scenario) -> Block:
    """The plant with the native loop's Runge-Kutta step; parameters end with that step [s].

    It tells the way that it drives where a sensor of the scenario asks for it.
    """
    sensors = [item.system(scenario) for item in EFFECTS.present(scenario, EffectRole.SENSOR)]
    system = plant(scenario, rolling=rolling_of(sensors)[:1])
    p = Parameters(scenario, system.params)
    following = rk4_step(system, p.take("clock.plant"))
    stepped = replace(system, params=p.ports)
    given = {"u": stepped.u, "x": stepped.x, "p": stepped.p}
    meaning = "State after one Runge-Kutta step, inputs held."
    return _block(stepped, (kernel("rk4", meaning, given, {"next": following}),))


def law_block(setup: Setup) -> Block:
    """The controller of a law, watched: one sample with its memory, and the force asked for."""
    system = asking_controller(setup)
    return _block(replace(system, params=(*system.params, port(PARALLEL))))


def guard_block(setup: Setup) -> Block:
    """The velocity guard by itself: asked force and measured velocity to wheel torques."""
    system = guard(setup)
    return _block(replace(system, params=(*system.params, port(PARALLEL))))


SHARE = Signal("share", "1", "share of the command asked for that is sent, by axis", 2)


def filter_block(scenario: Scenario) -> Block:
    """The command filter: what it sends, that as a share of what was asked, its flags one by one.

    It comes without derivatives: those of the band's tables would be longer than all the rest.

    ScenarioError where the filter is not set, or cannot be met.
    """
    system = called_filter(scenario)
    made = {item.signal: item.expr for item in system.outputs}
    asked = next(item.sym for item in system.inputs if item.signal == ASKED)
    sent = made[SENT]
    shares = (ca.if_else(asked[i] == 0, 1, sent[i] / asked[i]) for i in AXES)
    told = (
        Output(
            Signal(name.replace("-", "_"), "1", f"1: {FLAG_MEANINGS[bit]}"),
            has_bit(made[FLAGS], bit),
        )
        for bit, name in FLAG_NAMES.items()
    )
    p = Parameters(scenario, system.params)
    p.take("clock.control")
    shown = (Output(SHARE, ca.vertcat(*shares)), *told)
    block = _block(replace(system, params=(*p.ports, port(PARALLEL)), diagnostics=shown))
    return replace(block, derivatives=())


def corridor_block(system: System, scenario: Scenario) -> Block:
    """The monitor of a corridor, whose System is given; comparisons leave it no derivatives."""
    p = Parameters(scenario, system.params)
    p.take("clock.control")
    block = _block(replace(system, params=(*p.ports, port(PARALLEL))))
    return replace(block, derivatives=())


def reference_block(scenario: Scenario) -> Block:
    """The desired trajectory, sampled with the control period."""
    system = reference(scenario)
    p = Parameters(scenario, system.params)
    p.take("clock.control")
    return _block(replace(system, params=p.ports, period=scenario.clock.control))


def results_of(system: System) -> tuple[Output, ...]:
    """Outputs that are no continuous states themselves, then the diagnostics."""
    states = {} if system.period else {item.signal.name: item.sym for item in system.state}
    pairs = ((item, states.get(item.signal.name)) for item in system.outputs)
    own = (item for item, sym in pairs if sym is None or not ca.is_equal(ca.SX(item.expr), sym))
    return (*own, *system.diagnostics)


def _block(system: System, more: tuple[Kernel, ...] = ()) -> Block:
    results = results_of(system)
    own = stack(item.expr for item in results[: len(results) - len(system.diagnostics)])
    given = {"u": system.u, "x": system.x, "p": system.p}
    shown = {"next": system.update, "y": own, "d": system.d}
    evaluate = kernel("evaluate", f"Results of the {system.title}.", given, shown)
    z, y = ca.vertcat(system.u, system.p, system.x), stack(item.expr for item in results)
    w = y if system.period else ca.vertcat(system.update, y)
    whole = ca.Function("evaluate", [z], [ca.vertcat(system.update, y)], ["z"], ["w"])
    derivatives, entries = _derivatives(z, w), _entries(z, w)
    return Block(system, results, (evaluate, *more), derivatives, entries, whole.serialize())


def _derivatives(z: ca.SX, w: ca.SX) -> tuple[Kernel, Kernel]:
    dz, bar = ca.SX.sym("dz", z.numel()), ca.SX.sym("bar", w.numel())
    forward, reverse = ca.jtimes(w, z, dz), ca.jtimes(w, z, bar, True)
    along = "Jacobian of the results times a direction."
    back = "Transposed Jacobian of the results times weights."
    return (
        kernel("forward_rows", along, {"z": z, "dz": dz}, {"dw": ca.densify(forward)}),
        kernel("reverse_rows", back, {"z": z, "bar": bar}, {"back": ca.densify(reverse)}),
    )


def _entries(z: ca.SX, w: ca.SX) -> tuple[Entry, ...]:
    jacobian = ca.jacobian(w, z)
    rows, columns = jacobian.sparsity().get_triplet()
    constant = [jacobian.nz[k].is_constant() for k in range(jacobian.nnz())]
    return tuple(zip(rows, columns, constant, strict=True))
