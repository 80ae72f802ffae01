"""A checker that shares no code with the corridor's computation accepts what it states, and nothing
that is stated too small."""

from dataclasses import fields, replace

import casadi as ca
import numpy as np
import pytest

from tests.corridor.fixed_point import Certificate, RefusedError, check
from tests.corridor.stated import stated
from wmr_ctrl.control.setup import settle
from wmr_ctrl.world.scenario import load_scenario
from wmr_proofs.corridor.certificate import Certifier

FREE = {"guard.enabled": False}
NOISY = {**FREE, "sensor.velocity_noise": [0.002, 0.004]}
CASES = {
    "prox": ("safe-simulation", "prox", {}),
    "mb": ("safe-simulation", "mb", {}),
    "an observer, velocities with noise": ("safe-simulation", "kanayama", NOISY),
    "a base with a dead band": ("irobot-create3", "kanayama", {}),
    "a start": ("safe-simulation", "prox", {"corridor.start": [0.002, 0.002, 0.02]}),
    "jitter": ("safe-simulation", "prox", {**FREE, "actuator.jitter": 0.003}),
    "a lag": ("safe-simulation", "prox", {**FREE, "actuator.lag": 0.01}),
    "late commands behind the guard": ("safe-simulation", "prox", {"actuator.delay": 0.02}),
    "rare poses": ("safe-simulation", "prox", {"sensor.pose_period": 0.05}),
    "poses with noise": ("safe-simulation", "prox", {"sensor.pose_noise": 1e-5}),
}
DEFAULT = "prox", "an observer, velocities with noise", "jitter"


def certifier_of(case):
    preset, law, changes = CASES[case]
    return Certifier(settle(load_scenario(preset, changes), law))


@pytest.fixture(scope="module")
def prox():
    """Certificate with a start, poses and velocities with errors, and jitter."""
    changes = {
        **FREE, "actuator.jitter": 0.002, "corridor.start": [1e-4, 1e-4, 1e-3],
        "sensor.pose_noise": 1e-5, "sensor.velocity_noise": [1e-4, 2e-4],
    }  # fmt: skip
    certifier = Certifier(settle(load_scenario("safe-simulation", changes), "prox"))
    return stated(certifier, certifier.inputs)


@pytest.mark.parametrize("case", CASES)
@pytest.mark.slow_but(*DEFAULT)
def test_checker_finds_the_width_that_the_computation_states(case):
    certifier = certifier_of(case)
    tube = certifier.tube(certifier.inputs)
    position, heading = check(stated(certifier, certifier.inputs))

    assert position == pytest.approx(tube.position, rel=1e-3)
    assert heading == pytest.approx(tube.heading, rel=1e-2)


@pytest.mark.parametrize("name", ["fast", "state", "out"])
@pytest.mark.slow_but("state")
def test_no_size_of_the_box_may_be_smaller(prox, name):
    box = getattr(prox, name)
    for k in np.flatnonzero(box > 1e-9):
        less = box.copy()
        less[k] *= 0.9
        with pytest.raises(RefusedError, match="reaches"):
            check(replace(prox, **{name: less}))


LARGER = {
    "push": 0.1, "pose": 1e-5, "velocity": 1e-4, "reckoned": 1e-4, "body": 1.0, "command": 0.1,
    "dead": 100.0, "start": 1e-4, "law_gap": 0.1, "step_gap": 1e-4, "off": 0.1,
}  # fmt: skip
"""What is added to each input."""


@pytest.mark.parametrize("name", LARGER)
def test_no_input_may_be_larger_than_what_the_box_is_for(prox, name):
    with pytest.raises(RefusedError):
        check(replace(prox, **{name: getattr(prox, name) + LARGER[name]}))


@pytest.mark.parametrize(
    "name", ["push", "velocity", "reckoned", "body", "command", "dead", "fast"]
)
def test_a_size_of_the_other_sign_is_refused(prox, name):
    with pytest.raises(RefusedError, match="negative"):
        check(replace(prox, **{name: -getattr(prox, name) - 1e-9}))


def scaled(graph, share, rows):
    """The graph with the deviations of some outputs from its values there multiplied."""
    by = ca.SX.sym("by", graph.numel_in(0))
    output = ca.densify(graph(by))
    output[rows] = share * output[rows]
    return ca.Function("graph", [by], [output])


@pytest.mark.parametrize("share", [-1.0, 0.9])
@pytest.mark.parametrize("row", [0, 1])
def test_the_box_of_another_law_is_refused(prox, row, share):
    with pytest.raises(RefusedError):
        check(replace(prox, law=scaled(prox.law, share, row)))


@pytest.mark.parametrize("row", range(5))
def test_the_box_of_another_robot_is_refused(prox, row):
    with pytest.raises(RefusedError):
        check(replace(prox, step=scaled(prox.step, 1.01, row)))


def test_no_limit_may_act_on_the_box(prox):
    for k in range(prox.sizes.numel_out(0)):
        with pytest.raises(RefusedError, match="limit"):
            check(replace(prox, sizes=scaled(prox.sizes, -1.0, k)))
    with pytest.raises(RefusedError, match="limit"):
        check(replace(prox, lower=prox.lower + 1e6))


@pytest.mark.parametrize("changed", [{"late": 5}, {"ratios": np.full(10, 5.0)}])
def test_another_delay_or_other_pairs_are_refused(prox, changed):
    with pytest.raises(RefusedError):
        check(replace(prox, **changed))


def test_every_part_of_a_certificate_is_altered_here():
    """Apart from numbers of columns, and points around which the graphs are expanded."""
    altered = {*LARGER, "fast", "state", "out", "law", "step", "sizes", "lower", "late", "ratios"}
    sizes = {"queue", "memory", "acting", "steps", "share"}
    points = {"law_at", "step_at", "rest", "disc"}

    assert {item.name for item in fields(Certificate)} == altered | sizes | points


ALTERED = {
    "_remainders": lambda given: tuple(0.9 * part for part in given),
    "_changes": lambda given: 0.9 * given,
    "_given": lambda given: 0.99 * given,
}
"""Results of the computation's steps, made too small."""


@pytest.mark.parametrize("name", ALTERED)
def test_a_computation_that_forgets_something_states_what_is_refused(name, monkeypatch):
    certifier, right = certifier_of("jitter"), getattr(Certifier, name)
    monkeypatch.setattr(Certifier, name, lambda *given: ALTERED[name](right(*given)))
    with pytest.raises(RefusedError):
        check(stated(certifier, certifier.inputs))


def test_smaller_inputs_have_a_smaller_box(prox):
    assert check(replace(prox, push=0.5 * prox.push))[0] < 0.9 * check(prox)[0]
