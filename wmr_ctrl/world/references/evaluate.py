"""Numbers from a reference's graph: its values at given times, and the range of its velocities."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.errors import ArgumentError, ScenarioError
from wmr_ctrl.fields.plugins import blamed
from wmr_ctrl.model.system import System
from wmr_ctrl.signals import REFERENCE, SAMPLE, TIME
from wmr_ctrl.symbolic import ca

if TYPE_CHECKING:
    from wmr_ctrl.scenario import Scenario

GRID = 2001
MOST_SAMPLES = 20_000
Floats = NDArray[np.float64]


def reference(scenario: Scenario) -> System:
    """The desired trajectory: System from time t [s] to the seven reference signals.

    Raises ArgumentError, which names the kind, for one that gives something else.
    """
    kind = scenario.reference_kind
    remedy = "Mend it, or choose another kind; --debug shows where."
    with blamed(f'reference.kind = "{kind.name}": its graph cannot be built', remedy):
        system = kind.build(scenario)
    given = [item.signal.name for item in system.outputs]
    reads = {item.signal.name for item in system.inputs} - {TIME.name, SAMPLE.name}
    if given != [signal.name for signal in REFERENCE] or reads or system.draws:
        raise ArgumentError(
            f'reference.kind = "{kind.name}": its graph must give '
            f"{', '.join(signal.name for signal in REFERENCE)} in this order, from "
            f"{TIME.name} or {SAMPLE.name} alone and without random numbers."
        )
    return system


def sample(scenario: Scenario, times: Floats) -> Floats:
    """Return the reference at ``times`` (N,) [s]: (N, 7), in the order of ``signals.REFERENCE``.

    A reference with state is held from sample to sample; its times must not fall.
    """
    system = reference(scenario)
    if system.x.numel():
        return _stepped(system, scenario.clock.control, np.asarray(times, dtype=float))
    graph = system.function("reference", [system.y])
    row = np.asarray(times, dtype=float).reshape(1, -1)
    return np.asarray(graph(row, ca.DM(0, 1), ca.DM(system.p0))).T


def _stepped(system: System, period: float, times: Floats) -> Floats:
    graph = system.function("reference", [system.update, system.y])
    x, p, k, rows = ca.DM(system.x0), ca.DM(system.p0), 0, []
    for time in times:
        wanted = int(np.floor(time / period + 1e-9))
        for step in range(k, wanted):
            x = graph(step * period, x, p)[0]
        k = max(k, wanted)
        rows.append(np.asarray(graph(k * period, x, p)[1]).ravel())
    return np.array(rows)


def reference_bounds(scenario: Scenario) -> tuple[float, float, float]:
    """Return min v1_d [m/s], max v1_d [m/s] and max |v2_d| [rad/s] over the run.

    Taken on a fine grid over one cycle of the velocities or the run, whichever is shorter; the
    theorems ask for 0 < v1_d < v_u2[1] and |v2_d| < v_u2[2].
    """
    end = min(scenario.clock.duration, scenario.reference.cycle)
    rows = sample(scenario, np.linspace(0, end, GRID))
    v1, v2 = rows[:, 3], rows[:, 4]
    return float(v1.min()), float(v1.max()), float(np.abs(v2).max())


def check_finite(scenario: Scenario) -> None:
    """Raise ScenarioError where the reference is not finite: at samples, and on a grid between.

    Over one cycle of the velocities or the run, whichever is shorter, and MOST_SAMPLES at most.
    """
    end, period = min(scenario.clock.duration, scenario.reference.cycle), scenario.clock.control
    samples = np.arange(min(end / period + 1, MOST_SAMPLES)) * period
    times = np.union1d(samples, np.linspace(0, end, GRID))
    bad = np.flatnonzero(~np.isfinite(sample(scenario, times)).all(axis=1))
    if bad.size:
        raise ScenarioError(
            f'reference.kind = "{scenario.reference_kind.name}": the desired motion is not finite '
            f"at t = {times[bad[0]]:.6g} s. Change the reference's numbers, or its graph."
        )
