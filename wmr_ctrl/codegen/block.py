"""Block: a System as one function of all that it knows, with its derivatives, for stand-alone use.

A block's known values z lie side by side: inputs, parameters, state.  Its results w are the rates
(continuous systems), the outputs that are no states, and the diagnostics.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import casadi as ca

from wmr_ctrl.codegen.emit import Kernel, kernel
from wmr_ctrl.laws.controller import controller
from wmr_ctrl.model.parameters import Parameters
from wmr_ctrl.model.plant import plant, rk4_step
from wmr_ctrl.model.reference import reference
from wmr_ctrl.model.system import Output, System, stack
from wmr_ctrl.scenario import Scenario

Entry = tuple[int, int, bool]
"""Row of w, row of z, and whether the derivative there is a constant."""


@dataclass(frozen=True)
class Block:
    """A System, its results beyond the states, its C kernels and the serialised graph."""

    system: System
    results: tuple[Output, ...]
    kernels: tuple[Kernel, ...]
    jacobian: tuple[Entry, ...]
    graph: str


def plant_block(scenario: Scenario) -> Block:
    """The plant with the native loop's Runge-Kutta step; parameters end with that step [s]."""
    system = plant(scenario)
    p = Parameters(scenario, system.params)
    following = rk4_step(system, p.take("clock.plant"))
    stepped = replace(system, params=p.ports)
    step = kernel(
        "rk4",
        "State after one Runge-Kutta step, inputs held.",
        {"u": stepped.u, "x": stepped.x, "p": stepped.p},
        {"next": following},
    )
    return _block(stepped, (step,))


def law_block(scenario: Scenario, law: str) -> Block:
    """The controller of ``law``: one sample with its memory."""
    return _block(controller(scenario, law))


def reference_block(scenario: Scenario) -> Block:
    """The desired trajectory, sampled with the control period, which is its last parameter."""
    system = reference(scenario)
    p = Parameters(scenario, system.params)
    p.take("clock.control")
    return _block(replace(system, params=p.ports, period=scenario.clock.control))


def results_of(system: System) -> tuple[Output, ...]:
    """Outputs that are not states themselves, then the diagnostics."""
    states = {item.signal.name: item.sym for item in system.state}
    own = (item for item in system.outputs if not _is_state(item, states))
    return (*own, *system.diagnostics)


def _is_state(output: Output, states: dict[str, ca.SX]) -> bool:
    sym = states.get(output.signal.name)
    return sym is not None and bool(ca.is_equal(ca.SX(output.expr), sym))


def _block(system: System, more: tuple[Kernel, ...] = ()) -> Block:
    z, results = ca.vertcat(system.u, system.p, system.x), results_of(system)
    y = stack(item.expr for item in results)
    w = y if system.period else ca.vertcat(system.update, y)
    evaluate = kernel(
        "evaluate", f"Results of the {system.title}.", {"z": z}, {"w": ca.vertcat(system.update, y)}
    )
    return Block(
        system,
        results,
        (evaluate, *_derivatives(z, w), *more),
        _entries(z, w),
        evaluate.function.serialize(),
    )


def _derivatives(z: ca.SX, w: ca.SX) -> tuple[Kernel, Kernel]:
    dz, bar = ca.SX.sym("dz", z.numel()), ca.SX.sym("bar", w.numel())
    forward = ca.densify(ca.jtimes(w, z, dz))
    reverse = ca.densify(ca.jtimes(w, z, bar, True))
    return (
        kernel(
            "forward_rows",
            "Jacobian of the results times a direction.",
            {"z": z, "dz": dz},
            {"dw": forward},
        ),
        kernel(
            "reverse_rows",
            "Transposed Jacobian of the results times weights.",
            {"z": z, "bar": bar},
            {"back": reverse},
        ),
    )


def _entries(z: ca.SX, w: ca.SX) -> tuple[Entry, ...]:
    jacobian = ca.jacobian(w, z)
    rows, columns = jacobian.sparsity().get_triplet()
    constant = [part.is_constant() for part in jacobian.nonzeros()]
    return tuple(zip(rows, columns, constant, strict=True))
