"""The linear loop against the compiled one: responses, eigenvalues, symmetries, limits."""

from types import SimpleNamespace

import numpy as np
import pytest

from tests.checks.asking import closed
from tests.tables import changes
from wmr_ctrl.api import simulate
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.signals import elements
from wmr_ctrl.simulation.engines import runnable
from wmr_ctrl.simulation.memory import laid_out
from wmr_ctrl.theory.checks.loop import Loop
from wmr_ctrl.theory.checks.radius import (
    _of_product,
    from_pose_to_pose,
    radius,
    stretches_of,
)
from wmr_ctrl.theory.checks.sampled_plant import divided
from wmr_ctrl.theory.checks.surroundings import DriveTimes, _counts
from wmr_ctrl.world.model.kinematics import error_rotation
from wmr_ctrl.world.references import sample
from wmr_ctrl.world.scenario import load_scenario

T, V_D = 0.01, np.array((0.2, 0.1))
AWAY = np.array([1.0, -0.5, 0.7, 0.3, -0.2])
"""A displacement of the pose, in the frame of the reference, and of the velocity."""
SMALL, SAMPLES = 1e-6, 80
STANDS = {"reference.rate": 0.0}
"""Reference at rest, where the robot stays with viscous friction or with a mean of velocities,
which shows no speed at the first sample."""
EFFECTS = {
    "none": "",
    "lag": "actuator.lag = 0.02",
    "delay": "actuator.delay = 0.02",
    "delay and lag": "actuator.delay = 0.013; actuator.lag = 0.02",
    "window and age": "sensor.velocity_window = 0.02; sensor.velocity_age = 0.01",
    "encoder": "encoder.counts = 1e12; encoder.window = 0.02",
    "resistance": "resistance.viscous = [30.0, 2.0]",
}
POSES = [(0.05, 1.0, 1), (0.0, 0.3, 1), (0.1, 0.5, 1), (0.0, 1.0, 7), (0.1, 0.4, 5)]
"""Age [s], correction, and samples from one pose to the next."""


def still(changed):
    """The nominal circle, or another motion, without friction."""
    floor = {"robot.mu": 0.0, "model.mu": 0.0, "clock.duration": SAMPLES * T}
    return load_scenario("paper-simulation-nominal", floor | changed)


def started(scenario, away):
    """Error and velocity (N, 5) of the run of mb that starts at a distance from the reference."""
    at = sample(scenario, np.array([0.0]))[0]
    level = np.asarray(error_rotation(at[2]).T @ error_rotation(0.0)) @ away[:3]
    start = {
        "initial.pose": (at[:3] + level).tolist(), "initial.velocity": (at[3:5] + away[3:]).tolist()
    }  # fmt: skip
    run = simulate(scenario, "mb", overrides=start)
    return np.column_stack((run["e"], run["v1"], run["omega"]))


def seen_and_told(scenario, every=1):
    """Return the effect of a small initial displacement on error and velocity (N, 5), per unit.

    The first result is from differences of compiled runs, which use no derivatives. The second is
    from the linear loop.
    """
    one, other = (started(scenario, size * AWAY) for size in (SMALL, -SMALL))
    seen = (one - other) / (2 * SMALL)
    loop = Loop(settle(scenario, "mb"))
    v_d = sample(scenario, np.array([0.0]))[0][3:5]
    first, pose, none = (closed(loop, v_d, T, sample=k) for k in (0, every, every + 1))
    x, rows = np.concatenate((seen[0], np.zeros(len(pose) - 5))), []
    for k in range(SAMPLES):
        rows.append(x[:5])
        x = (first if k == 0 else pose if k % every == 0 else none) @ x
    return seen, np.array(rows)


@pytest.mark.parametrize(
    "name", ["delay", "delay and lag", "window and age", "encoder", "resistance"]
)
@pytest.mark.slow_but("delay", "delay and lag")
def test_a_small_displacement_follows_the_matrices(name):
    seen, told = seen_and_told(still(changes(EFFECTS[name]) | ({} if "delay" in name else STANDS)))

    assert told == pytest.approx(seen, abs=2e-4)


@pytest.mark.parametrize("age, correction, every", POSES)
@pytest.mark.slow_but("0.1-0.4-5")
def test_a_small_displacement_follows_the_matrices_with_late_filtered_or_rare_poses(
    age, correction, every
):
    """The linear loop matches the run on a line, up to where the robot settles.

    It settles behind by the distance that it drives while a pose is late.
    """
    pose = {"sensor.pose_delay": age, "sensor.correction": correction, "reference.kind": "line",
            "reference.speed": 0.2, "sensor.pose_period": every * T}  # fmt: skip
    seen, told = seen_and_told(still(pose), every)

    assert told == pytest.approx(seen, abs=0.2 * age + 1e-3)


def finals(scenario, law, samples):
    """Gradient of the whole state after some samples by the initial state, by central differences.

    Flags stay as they are; the final pose is expressed as tracking error.
    """
    ready = runnable(scenario, law)
    ports, columns = ready.compiled.layout.state, []
    size, units = len(elements(ports)), [item.unit for item in ports for _ in item.elements]
    theta = sample(scenario, np.array([samples * T]))[0][2]
    turn = np.eye(size)
    turn[:3, :3] = -np.asarray(error_rotation(theta))
    for i in (k for k in range(size) if units[k] != "1"):
        ends = []
        for step in (SMALL, -SMALL):
            lane = SimpleNamespace(loop=ready, seed=0, start=None, vectors=None)
            memory = laid_out([lane], [])
            memory.settings.samples = samples
            memory.arrays["start"][i, 0] += step
            memory.run()
            ends.append(memory.state[:, 0].copy())
        columns.append(turn @ (ends[0] - ends[1]) / (2 * SMALL))
    return np.array(columns).T


@pytest.mark.parametrize("law, effects", [("pid", "none"), ("prox", "lag"), ("kanayama", "none")])
@pytest.mark.slow_but("pid-none")
def test_eigenvalues_are_those_of_differences_through_the_compiled_loop(law, effects):
    """Eigenvalues of the linear loop are among those found from differences of compiled runs.

    The state includes the law's memory and its observer's estimate of the drives.
    """
    on = {"initial.pose": [0.0, 0.0, -np.pi / 2], "initial.velocity": V_D.tolist()}
    scenario = still(changes(EFFECTS[effects]) | on)
    early, later = (finals(scenario, law, samples) for samples in (5, 6))
    theirs = np.linalg.eigvals(later @ np.linalg.pinv(early, rcond=1e-7))
    ours = np.linalg.eigvals(closed(Loop(settle(scenario, law)), V_D, T))

    for value in ours[np.abs(ours) > 0.5]:
        assert np.abs(theirs - value).min() < 1e-4


def test_on_a_slope_the_matrix_depends_on_the_heading():
    loop = Loop(settle(still({"slope.angle": 0.1}), "pid"))
    here, there = (closed(loop, V_D, T, theta=theta) for theta in (0.0, 2.0))

    assert len(loop.around.headings) > 1
    assert np.abs(there - here).max() > 1e-4


def test_the_origin_of_the_path_length_is_no_state():
    """Encoders and means read the path length; adding a constant to it is neither stable nor
    unstable.
    """
    for effects in ("window and age", "encoder"):
        loop = Loop(settle(still(changes(EFFECTS[effects])), "mb"))
        values = np.linalg.eigvals(closed(loop, V_D, T))

        assert np.abs(values - 1).min() > 1e-4
        assert radius(closed(loop, V_D, T)) < 1


ONE, OTHER, TURNED = np.diag((2.0, 0.5)), np.diag((0.1, 4.0)), np.array([[0.0, 1.0], [0.0, 0.0]])


@pytest.mark.parametrize(
    "factors, counts, mean",
    [
        ((ONE, OTHER), (3, 1), 0.8 ** (1 / 4)),
        ((ONE, OTHER), (2, 6), 2.0**1.25),
        ((1.5 * np.eye(2),), (10_000,), 1.5),
        ((ONE, TURNED), (1, 2), 0.0),
        ((ONE, np.full((2, 2), np.nan)), (1, 1), np.inf),
    ],
)
def test_a_products_radius_per_factor_is_the_geometric_mean_of_what_commutes(factors, counts, mean):
    assert _of_product([*factors], np.array(counts)) == pytest.approx(mean)


def test_stretches_of_a_reference_share_its_period_and_have_the_velocity_of_their_middles():
    """Neighbours are merged only if both velocities are equal."""
    scenario = still({"reference.kind": "lemniscate"})
    each, shares, cycle = stretches_of(scenario)
    counts = np.round(16 * shares).astype(int)
    middles = sample(scenario, (np.arange(16) + 0.5) * cycle / 16)[:, 3:5]

    assert cycle == scenario.reference.cycle
    assert shares.sum() == pytest.approx(1.0)
    assert np.repeat(each, counts, axis=0) == pytest.approx(middles, abs=1e-8)
    assert stretches_of(still({})) is None


def test_from_pose_to_pose_is_the_product_of_the_samples_between():
    loop = Loop(settle(still({"sensor.pose_period": 5 * T, "sensor.correction": 0.5}), "prox"))
    at = loop.on_reference(V_D)
    samples = [loop.closed(at, T, sample=k) for k in range(5, 10)]
    expected = np.linalg.multi_dot(samples[::-1])

    assert from_pose_to_pose(loop, at, T) == pytest.approx(expected, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize(
    "value, period, whole", [(0.3, 0.1, 3), (0.06, 0.01, 6), (0.035, 0.01, 3), (0.0, 0.1, 0)]
)
def test_a_delay_is_as_many_periods_as_its_decimals_say(value, period, whole):
    count, rest = divided(value, period)

    assert count == whole
    assert count * period + rest == pytest.approx(value, abs=1e-12)
    assert rest == 0 or rest > 0.1 * period


@pytest.mark.parametrize("ratio", [1.25, 3.9, 5.0])
def test_sample_counts_of_a_window_average_to_its_length(ratio):
    ways = _counts("sensor.velocity_window", ratio, True)

    assert sum(weight for weight, _ in ways) == pytest.approx(1.0)
    assert sum(weight * count for weight, count in ways) == pytest.approx(ratio)
    assert all(abs(count - ratio) < 1 for _, count in ways)
    assert _counts("sensor.velocity_window", 0.4, True) == [(1.0, 1)]


def test_a_law_s_knowledge_of_its_drives_decays_with_their_lag():
    lag = 0.03
    around = Loop(settle(still({"actuator.lag": lag}), "mb")).around
    known = around.known_of_drives(T, DriveTimes(0.0, 0.0, lag), applied=True, commands=0)

    assert radius(known.moved) == pytest.approx(np.exp(-T / lag), rel=1e-12)
