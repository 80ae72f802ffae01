"""The corridor's monitor beside runs of the tests' own loop, whose samples are counted here."""

from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks.corridor_adversary import Attacked
from tests.corridor.test_every_sample import LITTLE, PERIOD, heavier, simulated, timed
from tests.tables import changes
from wmr_ctrl.theory.corridor import corridor_monitor, find_corridor
from wmr_ctrl.world.scenario import override
from wmr_proofs.corridor.latch import left_by

CASE = simulated(timed(PERIOD, 200), "disturbance.std = 0.1")


@pytest.fixture(scope="module")
def monitor():
    return corridor_monitor(CASE, "prox")


@pytest.fixture(scope="module")
def numbers(monitor):
    return {port.signal.name: np.array(port.value) for port in monitor.params}


class Made:
    """A run of the tests' own loop that is displaced 5 cm ahead at a sample."""

    law, guard = "prox", False

    def __init__(self, scenario, at, frames="paper", off=(0.0, 0.0)):
        loop = Attacked(scenario, "prox", np.zeros((scenario.clock.samples, 2)))
        loop.jump, loop.at = (0.05, 0.0, 0.0), at * scenario.clock.substeps
        loop.run()
        self.columns = loop.log.columns()
        (ahead, aside), theta = off, self.columns["theta"]
        s, c = np.sin(theta), np.cos(theta)
        self.columns["x"] = self.columns["x"] + ahead * s + aside * c
        self.columns["y"] = self.columns["y"] - ahead * c + aside * s
        if frames == "rep103":
            self.columns["theta"] = self.columns["theta"] + np.pi / 2
            self.columns["theta_d"] = self.columns["theta_d"] + np.pi / 2
        self.time, self.rows = self.columns["t"], len(self.columns["t"])
        self.settings = SimpleNamespace(frames=frames, index=lambda t: round(t / PERIOD))

    def __getitem__(self, name):
        return self.columns[name]


def watched(monitor, run):
    """The monitor's outputs held, left, certified and distance, each with a column a sample."""
    names = [item.signal.name for item in monitor.inputs]
    step, x, told = monitor.function("step", [monitor.update, monitor.y]), monitor.x0, []
    for u in np.hstack([run[name].reshape(run.rows, -1) for name in names]):
        x, y = step(u, x, monitor.p0)
        told.append(y.full().ravel())
    return np.array(told).T


def test_what_is_certified_comes_down_after_each_round_of_samples(monitor, numbers):
    """The robot never leaves its path.  The first sample has no history."""
    K, most = int(numbers["corridor.samples"][0]), numbers["corridor.position"]
    run = Made(override(CASE, {"clock.duration": (2 * K + 8) * PERIOD}), -1)
    held, left, certified, distance = watched(monitor, run)

    assert held.tolist() == [0.0] * K + [1.0] * (K + 8)
    assert certified.tolist() == [0.0] * (K + 1) + [most[0]] * K + [most[1]] * 7
    assert most[0] > most[1] >= find_corridor(CASE, "prox").position
    assert not left.any()
    assert distance.max() < 1e-6


def test_a_robot_that_left_and_came_back_has_left(monitor):
    _, left, certified, distance = watched(
        monitor, Made(override(CASE, {"clock.duration": 12.0}), 180)
    )

    assert distance[-1] < certified[-1]
    assert left.tolist() == [0.0] * 181 + [1.0] * 59


@pytest.mark.parametrize("frames", ["paper", "rep103"])
def test_a_run_is_settled_by_what_it_is_off_ahead_and_aside(numbers, frames):
    ahead, aside = numbers["corridor.box"][:2]
    between = (ahead + aside) / 2
    shown = [left_by(Made(CASE, 180, frames, off), CASE) for off in ((between, 0), (0, between))]

    assert ahead > 1.5 * aside
    assert shown[0] is not None
    assert shown[1] is None


@pytest.mark.parametrize("frames", ["paper", "rep103"])
def test_a_run_is_held_against_it_until_the_robot_changes(numbers, frames):
    K, at = int(numbers["corridor.samples"][0]), 180
    run, left = Made(CASE, at, frames), left_by(Made(CASE, at, frames), CASE)
    settled = round(left.since / PERIOD)

    assert (round(left.time / PERIOD), settled) == (at + 1, K)
    assert left.most == pytest.approx(numbers["corridor.position"][0], rel=1e-9)
    assert left.distance == pytest.approx(np.hypot(*run["e"][at + 1, :2]), rel=1e-6)
    for time, said in ((170 * PERIOD, False), (190 * PERIOD, True)):
        change = [{"t": time, "mu": 0.081}, {"t": 195 * PERIOD, "mu": 0.082}]
        assert (left_by(run, override(CASE, {"changes": change})) is not None) == said


def test_what_is_measured_amiss_widens_what_a_monitor_certifies():
    noise = changes("""
        sensor.pose_noise = 1e-5
        sensor.velocity_noise = [1e-6, 1e-5]
    """)
    loud = override(CASE, noise)
    numbers = {p.signal.name: np.array(p.value) for p in corridor_monitor(loud, "prox").params}

    alone = find_corridor(loud, "prox").position_late

    assert numbers["corridor.position"].min() == pytest.approx(alone + 2**0.5 * 1e-5, rel=1e-4)


def test_what_stays_free_of_a_whole_run_is_what_its_corridor_leaves():
    """The clearance is not that of the corridor that ends when the robot becomes heavier."""
    near = changes("reference.keep_out = [[0.0, 2.0, 1.0]]; body.radius = 0.3")
    tube = find_corridor(
        simulated(timed(PERIOD, 16), LITTLE, heavier(0.225), near), "prox", whole=True
    )

    assert tube.position < 0.9 * tube.whole.position
    assert tube.clearance.free == tube.clearance.path - 0.3 - tube.whole.position
