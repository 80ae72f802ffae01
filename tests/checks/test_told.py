"""Checks of a scenario and a law: each warning has its numbers and remedy, or does not appear."""

from math import inf

import pytest

NOISE, TORQUE, DELAY = "disturbance.std", "actuator.tau_max", "actuator.delay"
ETA, DBAR, METHOD = "gains.nn.eta", "guard.dbar", "encoder.method"
PAPER, NOMINAL, FAR, FAST = (
    "paper-simulation",
    "paper-simulation-nominal",
    "far-start",
    "fast-reference",
)
DROP = "far-start-drop"
TURNED = {NOISE: 0.5, "initial.pose": [0.0, 0.0, 0.0]}
"""sqrt(2) 0.5/0.1 of both wheels, times half the track of 0.25 m."""
ON = {"guard.enabled": True}
TIMED = {"encoder.counts": 4096.0, METHOD: "time"}
UNBOUNDED = {**ON, "disturbance.truncate": inf}
WIDE = {**UNBOUNDED, "guard.M_min": [25.0, 2.7], DBAR: [60.0, 15.0]}
SEEN_LATE = {**WIDE, "guard.M_min": [45.0, 4.86], "sensor.velocity_window": 0.1}
STUCK = {**ON, "guard.M_min": [25.0, 2.7], DBAR: [60.0, 10.0], "guard.alpha": 5.0, "robot.mu": 0.15}
TIGHT = {"reference.radius": 0.1, "reference.rate": 1.4}
STEEP = 0.15 * 9.81 / 0.01
"""Slope of the largest friction of the paper's run [1/s]."""


def line(speed):
    return {"reference.kind": "line", "reference.speed": speed}


REFERENCES = [
    ("mb", line(0.8), [""]),
    ("mb", line(1.2), ["may not drive that fast"]),
    ("mb", TIGHT, ["1.4 rad/s", "wind up"]),
    ("nn", {"reference.kind": "stop-and-go"}, ["stands still"]),
    ("nn", line(0), ["stands still"]),
    ("nn", {"reference.rate": -0.1}, ["backwards"]),
    ("mb", line(0.79), None),
    ("nn", line(1e-3), None),
    ("nn", line(0.05), None),
    ("mb", {"reference.kind": "circle"}, None),
    ("mb", {"reference.kind": "lemniscate"}, None),
]
EXACT = [(law, name) for law in ("mb", "nn") for name in (FAR, "paper-experiment", NOMINAL)]


@pytest.mark.parametrize(
    "law, changes, scenario, key, said",
    [
        *((law, changes, NOMINAL, "reference", said) for law, changes, said in REFERENCES),
        ("mb", {}, FAST, "reference", ["reaches 0.9 m/s", "about 1 m behind"]),
        ("mb", {"gains.kinematics.k": (10, 0.5, 4)}, NOMINAL, "gains.kinematics.k",
         ["k[2] = 0.5 is below 1"]),
        # What no theorem covers.
        ("mb", {}, PAPER, NOISE, ["unbounded"]),
        ("nn", {}, PAPER, NOISE, ["unbounded"]),
        ("mb", {}, FAR, NOISE, ["pushes v1 with 14.1 N rms", "at most 2.33 N"]),
        ("mb", {NOISE: 0.5, "disturbance.truncate": 3}, NOMINAL, NOISE,
         ["0.5 N m rms, cut at 3 times that"]),
        ("mb", TURNED, NOMINAL, NOISE, ["pushes omega with 1.77 N m rms"]),
        ("mb", {}, NOMINAL, NOISE, None),
        ("pid", {}, FAR, NOISE, None),
        ("mb", {TORQUE: 1.95}, NOMINAL, TORQUE, ["Raise it above 1.96 N m."]),
        ("mb", {TORQUE: 1.97}, NOMINAL, TORQUE, None),
        ("pid", {TORQUE: 3.0}, PAPER, TORQUE, ["friction needs 95.6 N"]),
        ("mb", {DELAY: 0.01}, NOMINAL, DELAY, [""]),
        ("mb", {DELAY: 0.009}, NOMINAL, DELAY, None),
        ("mb", {**ON, DELAY: 0.02}, NOMINAL, DELAY, ["The guard still keeps the limits"]),
        ("mb", {**ON, DELAY: 0.02, "actuator.lag": 0.02}, NOMINAL, DELAY,
         ["The guard still keeps the limits"]),
        # Of all that is told, nothing else.
        ("pid", UNBOUNDED, FAR, "", ["Set disturbance.truncate = 3 for a guarantee."]),
        ("mb", UNBOUNDED, FAR, "", ["Set disturbance.truncate = 3 for a guarantee."]),
        ("pid", {**ON, "disturbance.truncate": 3}, FAR, "", None),
        # Whom the barrier cannot hold.
        ("mb", {}, "far-start-friction-overestimated", "model",
         ["cannot hold |v1| below 1 m/s at the start"]),
        ("mb", {}, DROP, "model", ["cannot hold |v1| below 1 m/s from 3 s on"]),
        ("mb", {"model.mu": 0.12}, NOMINAL, "model", ["ahead of the reference"]),
        ("nn", {}, DROP, "model", None),
        *((law, {}, name, "model", None) for law, name in EXACT),
        # The network.
        ("nn", {}, PAPER, ETA, ["|S|^2 = 0.319", "above 0.054", "eta^2 below 1.373",
                                "gains.nn.rho1[2] above 43.2"]),
        ("nn", {"gains.nn.Gamma": (0, 0)}, NOMINAL, ETA, None),
        *((law, {}, NOMINAL, ETA, None) for law in ("pid", "smc", "mb")),
        # What the guard costs.
        ("prox", {**ON, **TIMED}, NOMINAL, METHOD, ["the guard relies on one fixed window"]),
        ("prox", TIMED, NOMINAL, METHOD, None),
        ("pid", {**SEEN_LATE, "clock.control": 0.1}, FAST, DBAR,
         ["(1/alpha + age + window/2 + delay + lag)", "at most 0.669 m/s",
          "No guard at all could leave more than 0.779 m/s"]),
        ("prox", WIDE, FAST, DBAR, None),
        ("prox", {**WIDE, "clock.control": 0.1}, FAST, DBAR, ["at most 0.603 m/s"]),
        ("mb", STUCK, NOMINAL, DBAR, ["no motion at all"]),
        # Periods.
        ("mb", {"actuator.lag": 0.3}, NOMINAL, "clock.control",
         ["every shorter period that was tried", "lower the lag, or its gains"]),
        ("kanayama", {"clock.plant": 0.01}, PAPER, "clock.plant",
         [f"up to {STEEP:.4g} 1/s", f"Choose {1 / STEEP:.2g} s or less"]),
    ],
)  # fmt: skip
def test_a_warning_has_its_numbers_and_remedy(told, law, changes, scenario, key, said):
    found = [item.sentence for item in told(law, changes, scenario=scenario, key=key)]

    assert len(found) == (said is not None)
    assert [part for part in said or () if part not in found[0]] == []
