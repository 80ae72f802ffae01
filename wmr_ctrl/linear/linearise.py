"""Exact linearisation of a System: gradients of its graph by CasADi, as a named StateSpace.

Beside it the names of what is linearised, and numerical helpers that the other files share.
"""

from collections.abc import Callable, Iterable, Sequence

import casadi as ca
import control as ct
import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import minimize_scalar

from wmr_ctrl.model.system import System
from wmr_ctrl.signals import FORCE, TRACKING_ERROR, VELOCITY, Signal

Floats = NDArray[np.float64]
MARGINAL = 1e-7
"""Real parts up to this [1/s] count as zero: an estimate without leak, a reference that stands."""


def element_names(signals: Iterable[Signal]) -> list[str]:
    """Names of all elements in order: ``e[1]``, ``e[2]``, ``e[3]``, ``v1``, ``omega``, ..."""
    return [name for signal in signals for name in signal.elements]


DISTURBANCE = Signal(
    "disturbance", "N, N.m", "disturbing generalised force (thrust, turning moment)", 2
)
V_D = Signal("v_d", "m/s, rad/s", "desired velocity", 2)
FORCES = element_names((FORCE,))
DISTURBANCES = element_names((DISTURBANCE,))
STATES = element_names((TRACKING_ERROR, *VELOCITY))
"""e (3), v1, omega: the robot seen from its reference."""


def column(value: ArrayLike) -> Floats:
    """A CasADi column as a flat array."""
    return np.asarray(value, dtype=float).ravel()


def is_stable(poles: ArrayLike, sampled: bool = False) -> bool:
    """True if no pole is outside the stable region; marginal ones count as stable."""
    values = np.asarray(poles, dtype=complex)
    inside = np.abs(values) <= 1 + MARGINAL if sampled else values.real <= MARGINAL
    return bool(inside.all())


def lowest(of: Callable[[Floats], Floats], grid: Floats, xatol: float) -> tuple[float, float]:
    """Place and value of the smallest ``of`` (N) -> (N) on a ``grid`` (N), then near its best."""
    values = np.asarray(of(grid))
    best = int(values.argmin())
    near = minimize_scalar(
        lambda x: float(np.squeeze(of(x))), method="bounded", options={"xatol": xatol},
        bounds=(grid[max(best - 1, 0)], grid[min(best + 1, len(grid) - 1)]),
    )  # fmt: skip
    place, least = (near.x, near.fun) if near.fun < values[best] else (grid[best], values[best])
    return float(place), float(least)


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
