"""Exact linearisation of a System: gradients of its graph by CasADi, as a named StateSpace."""

from __future__ import annotations

from collections.abc import Sequence

import casadi as ca
import control as ct
import numpy as np

from wmr_ctrl.linear.names import element_names
from wmr_ctrl.linear.numbers import Floats, column
from wmr_ctrl.model.system import System


def linearise(
    system: System,
    u: Sequence[float] | Floats,
    x: Sequence[float] | Floats | None = None,
    p: Sequence[float] | Floats | None = None,
    graph: ca.Function | None = None,
) -> ct.StateSpace:
    """The System near inputs ``u`` and state ``x``, as deviations from that point.

    Continuous for a continuous System, with ``dt`` for a sampled one.  States, inputs and outputs
    have the names of the System's ports.  ``x`` and ``p`` default to the ports' own values;
    ``graph`` is `gradients` of the System where a caller has it.
    """
    start = system.x0 if x is None else x
    numbers = system.p0 if p is None else p
    a, b, c, d = (np.asarray(part) for part in (graph or gradients(system))(u, start, numbers))
    return ct.ss(
        a, b, c, d, 0 if system.period is None else system.period, name=system.name,
        states=element_names(port.signal for port in system.state) or None,
        inputs=element_names(port.signal for port in system.inputs),
        outputs=element_names(item.signal for item in system.outputs),
        remove_useless_states=False,
    )  # fmt: skip


def gradients(system: System) -> ca.Function:
    """(u, x, p) -> A, B, C, D, exactly."""
    u, x, update, y = system.u, system.x, system.update, system.y
    parts = [ca.jacobian(graph, symbol) for graph in (update, y) for symbol in (x, u)]
    return system.function("gradients", [ca.densify(part) for part in parts])


def outputs_at(system: System, u: Floats, x: Floats, p: Floats) -> tuple[Floats, Floats]:
    """Update and outputs of a System at a point."""
    update, y = system.function("at", [system.update, system.y])(u, x, p)
    return column(update), column(y)
