"""Numbers from a reference's graph: its values at given times, and the range of its velocities."""

from __future__ import annotations

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.model.references.registry import trajectory_of
from wmr_ctrl.scenario.reference import Reference
from wmr_ctrl.scenario.scenario import Scenario

GRID = 2001


def function_of(reference: Reference) -> ca.Function:
    """Return the CasADi function t [s] -> reference (7, 1), with the parameters' numbers put in."""
    kind = trajectory_of(reference)
    values = {signal.name: ca.SX(ca.DM(v)) for signal, v in kind.parameters(reference)}
    t = ca.SX.sym("t")
    return ca.Function("reference", [t], [kind.trajectory(t, values)], ["t"], ["reference"])


def sample(reference: Reference, times: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the reference at ``times`` (N,) [s]: (N, 7), in the order of ``signals.REFERENCE``."""
    row = np.asarray(times, dtype=float).reshape(1, -1)
    return np.asarray(function_of(reference)(row)).T


def reference_bounds(scenario: Scenario) -> tuple[float, float, float]:
    """Return min v1_d [m/s], max v1_d [m/s] and max |v2_d| [rad/s] over the run.

    Taken on a fine grid over one cycle of the velocities or the run, whichever is shorter; the
    theorems ask for 0 < v1_d < v_u2[1] and |v2_d| < v_u2[2].
    """
    end = min(scenario.clock.duration, scenario.reference.cycle)
    found = sample(scenario.reference, np.linspace(0, end, GRID))
    v1, v2 = found[:, 3], found[:, 4]
    return float(v1.min()), float(v1.max()), float(np.abs(v2).max())
