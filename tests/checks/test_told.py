"""Checks of a scenario and a law: each warning has its numbers and remedy, or does not appear."""

import pytest

from tests.tables import changes

NOMINAL = "paper-simulation-nominal"
ON = "guard.enabled = true"
TIMED = "encoder.counts = 4096; encoder.method = time"
UNBOUNDED = f"{ON}; disturbance.truncate = inf"
WIDE = f"{UNBOUNDED}; guard.M_min = [25.0, 2.7]; guard.dbar = [60.0, 15.0]"
SEEN_LATE = f"{WIDE}; guard.M_min = [45.0, 4.86]; sensor.velocity_window = 0.1"
STUCK = f"{ON}; guard.M_min = [25.0, 2.7]; guard.dbar = [60.0, 10.0]; guard.alpha = 5.0"
LATE = f"{ON}; actuator.delay = 0.02"
TURNED = "disturbance.std = 0.5; initial.pose = [0.0, 0.0, 0.0]"
"""sqrt(2) 0.5/0.1 of both wheels, times half the track of 0.25 m."""
LINE = "reference.kind = line; reference.speed"
TIGHT = "reference.radius = 0.1; reference.rate = 1.4"
HOLDS = "The guard still keeps the limits"
TRUNCATE = "Set disturbance.truncate = 3 for a guarantee."
LEARNS = "|S|^2 = 0.319 & above 0.054 & eta^2 below 1.373 & gains.nn.rho1[2] above 43.2"
DEAR = "(1/alpha + age + window/2 + delay + lag) & at most 0.669 m/s"
STEEP = 0.15 * 9.81 / 0.01
"""Slope of the largest friction of the paper's run [1/s]."""


def told_on(scenario, key, text):
    """Rows of ``law | changes | said``, each with the scenario and the key of its warnings."""
    rows = (line.split(" | ") for line in text.strip().splitlines())
    return [pytest.param(law.strip(), set_, scenario, key, said) for law, set_, said in rows]


@pytest.mark.parametrize(
    "law, set_, scenario, key, said",
    [
        *told_on(NOMINAL, "reference", f"""
            mb | {LINE} = 0.8 | .
            mb | {LINE} = 1.2 | may not drive that fast
            mb | {TIGHT} | 1.4 rad/s & wind up
            nn | reference.kind = stop-and-go | stands still
            nn | {LINE} = 0 | stands still
            nn | reference.rate = -0.1 | backwards
            mb | {LINE} = 0.79 | -
            nn | {LINE} = 1e-3 | -
            nn | {LINE} = 0.05 | -
            mb | reference.kind = circle | -
            mb | reference.kind = lemniscate | -
        """),
        *told_on("fast-reference", "reference", "mb |  | reaches 0.9 m/s & about 1 m behind"),
        *told_on(NOMINAL, "gains.kinematics.k", """
            mb | gains.kinematics.k = [10, 0.5, 4] | k[2] = 0.5 is below 1
        """),
        # What no theorem covers.
        *told_on("paper-simulation", "disturbance.std", "mb |  | unbounded\nnn |  | unbounded"),
        *told_on("far-start", "disturbance.std", """
            mb |  | pushes v1 with 14.1 N rms & at most 2.33 N
            pid |  | -
        """),
        *told_on(NOMINAL, "disturbance.std", f"""
            mb | disturbance.std = 0.5; disturbance.truncate = 3 | 0.5 N m rms, cut at 3 times that
            mb | {TURNED} | pushes omega with 1.77 N m rms
            mb |  | -
        """),
        *told_on(NOMINAL, "actuator.tau_max", """
            mb | actuator.tau_max = 1.95 | Raise it above 1.96 N m.
            mb | actuator.tau_max = 1.97 | -
        """),
        *told_on("paper-simulation", "actuator.tau_max", """
            pid | actuator.tau_max = 3.0 | friction needs 95.6 N
        """),
        *told_on(NOMINAL, "actuator.delay", f"""
            mb | actuator.delay = 0.01 | .
            mb | actuator.delay = 0.009 | -
            mb | {LATE} | {HOLDS}
            mb | {LATE}; actuator.lag = 0.02 | {HOLDS}
        """),
        # Of all that is told, nothing else.
        *told_on("far-start", "", f"""
            pid | {UNBOUNDED} | {TRUNCATE}
            mb | {UNBOUNDED} | {TRUNCATE}
            pid | {ON}; disturbance.truncate = 3 | -
        """),
        # Whom the barrier cannot hold.
        *told_on("far-start-friction-overestimated", "model", """
            mb |  | cannot hold |v1| below 1 m/s at the start
        """),
        *told_on("far-start-drop", "model", """
            mb |  | cannot hold |v1| below 1 m/s from 3 s on
            nn |  | -
        """),
        *told_on(NOMINAL, "model", """
            mb | model.mu = 0.12 | ahead of the reference
            mb |  | -
            nn |  | -
        """),
        *told_on("far-start", "model", "mb |  | -\nnn |  | -"),
        *told_on("paper-experiment", "model", "mb |  | -\nnn |  | -"),
        # The network.
        *told_on("paper-simulation", "gains.nn.eta", f"nn |  | {LEARNS}"),
        *told_on(NOMINAL, "gains.nn.eta", """
            nn | gains.nn.Gamma = [0, 0] | -
            pid |  | -
            smc |  | -
            mb |  | -
        """),
        # What the guard costs.
        *told_on(NOMINAL, "encoder.method", f"""
            prox | {ON}; {TIMED} | the guard relies on one fixed window
            prox | {TIMED} | -
        """),
        *told_on("fast-reference", "guard.dbar", f"""
            pid | {SEEN_LATE}; clock.control = 0.1 | {DEAR} & could leave more than 0.779 m/s
            prox | {WIDE} | -
            prox | {WIDE}; clock.control = 0.1 | at most 0.603 m/s
        """),
        *told_on(NOMINAL, "guard.dbar", f"mb | {STUCK}; robot.mu = 0.15 | no motion at all"),
        # Periods.
        *told_on(NOMINAL, "clock.control", """
            mb | actuator.lag = 0.3 | every shorter period that was tried & lower the lag, or
        """),
        *told_on("paper-simulation", "clock.plant", f"""
            kanayama | clock.plant = 0.01 | up to {STEEP:.4g} 1/s & Choose {1 / STEEP:.2g} s or less
        """),
    ],
)  # fmt: skip
def test_a_warning_has_its_numbers_and_remedy(told, law, set_, scenario, key, said):
    found = [item.sentence for item in told(law, changes(set_), scenario=scenario, key=key)]

    assert len(found) == (said != "-")
    assert [part for part in said.split(" & ") if found and part not in found[0]] == []
