"""Bounds of each sample of a whole run are reached by the worst disturbances and hardly exceed
them.
"""

import re
from itertools import product
from types import SimpleNamespace

import numpy as np
import pytest

from tests.corridor.further import burger
from tests.corridor.one_by_one import HEADING, ROUND, SIDES, of_base, of_torques
from tests.papers_robot import safe
from tests.tables import changes
from wmr_ctrl.control.setup import settle
from wmr_ctrl.theory.corridor import find_corridor
from wmr_ctrl.world.scenario import override
from wmr_proofs.corridor import passage, remainders
from wmr_proofs.corridor.along import Along
from wmr_proofs.corridor.asked import run_corridor
from wmr_proofs.corridor.inputs import bounded_inputs
from wmr_proofs.corridor.instant import Guess, Instant
from wmr_proofs.corridor.passage import Passing

PERIOD = 0.05


def timed(period, samples):
    """Clock settings with two plant steps a sample."""
    return {"clock.control": period, "clock.plant": period / 2,
            "clock.duration": samples * period, "changes": []}  # fmt: skip


def heavier(time):
    return {"changes": [{"t": time, "m": 62.0, "I": 6.6, "mu": 0.12}]}


GAINS = changes("""
    guard.enabled = false
    gains.prox = {rho = [42.9, 21.74], wo = 10.0}
""")
"""Gains with k1 = 16.8, fast enough to make these bounds large at 50 ms."""


def simulated(*parts):
    return safe(GAINS, *parts)


EIGHT = changes("""
    reference.kind = lemniscate
    reference.size = 1.0
    reference.rate = 0.1
""")
LITTLE = changes("""
    disturbance.std = 0.02
    sensor.pose_noise = 1e-5
    actuator.tau_max = 10.0
    sensor.velocity_noise = [2e-5, 2e-4]
""")
LATE = changes("""
    actuator.delay = 0.01
    actuator.lag = 0.01
    sensor.correction = 0.6
    sensor.pose_noise = 1e-4
    corridor.start = [0.0, 0.0, 5e-3]
""")
STOPS = changes("""
    reference.kind = stop-and-go
    reference.radius = 2.0
    reference.period = 4.0
    reference.speed = 0.2
    robot.mu = 0.02
    disturbance.std = 0.003
    sensor.pose_noise = 0.0
    sensor.velocity_noise = [0.0, 0.0]
    actuator.tau_max = 10.0
""")
FAST = EIGHT | changes("""
    reference.rate = 0.5
    disturbance.std = 0.0
    actuator.tau_max = 20.0
    sensor.correction = 0.6
""")
BASE = changes("""
    base.delay = 0.03
    disturbance.std = 1e-6
    disturbance.truncate = 3.0
    sensor.pose_noise = 1e-6
    sensor.velocity_noise = [1e-6, 1e-5]
""")
HEAVIER = (EIGHT, timed(PERIOD, 16), LITTLE, heavier(0.225))
CASES = {
    "a robot that becomes heavier": ("prox", simulated(*HEAVIER), (1.0317, 1.0717, 1.0069)),
    "late drives, poses in part": (
        "prox",
        simulated(EIGHT, timed(0.02, 12), LITTLE, LATE, heavier(0.13)),
        (1.0694, 1.2741, 1.0175),
    ),
    "a fast path, poses in part": (
        "prox",
        simulated(FAST, timed(PERIOD, 16)),
        (2.6593, None, None),
    ),
    "from a standstill": ("prox", simulated(STOPS, timed(PERIOD, 16)), (2.539, 1.197, 1.000)),
    "a base that takes velocities": (
        "kanayama",
        burger(timed(0.06, 6), EIGHT, BASE),
        (1.0092, 1.0528, None),
    ),
}
"""Law and scenario; how much larger the bounds of position and heading are, a mean of samples, and
that of the torque in the run."""


@pytest.mark.parametrize("case", CASES)
@pytest.mark.slow_but(
    "a fast path, poses in part", "from a standstill", "a base that takes velocities"
)
def test_a_bound_is_what_all_that_disturbs_leads_to_and_hardly_more(case):
    law, scenario, (position, heading, torque) = CASES[case]
    base, start = law == "kanayama", scenario.corridor.start
    sizes = {
        "push": np.full(2, 3 * scenario.disturbance.std),
        "pose": np.sqrt(2) * scenario.sensor.pose_noise,
        "velocity": np.array(scenario.sensor.velocity_noise),
    }
    if base:
        sizes["heard"] = np.array([1e-6, 1e-5])
    kinds = [kind for kind, size in sizes.items() if np.any(size)]
    own = (of_base if base else of_torques)(scenario, law, kinds)
    rounded = changes("base.quantum = [2e-6, 2e-5]") if base else {}
    tube = run_corridor(override(scenario, rounded), law)
    reached = [own.of_samples(ways, sizes, start) for ways in (ROUND, HEADING)]
    far, turned = (one / other for one, other in zip(tube.course, reached, strict=True))

    assert min(far.min(), turned.min()) > 0.999
    assert tube.position == tube.course[0].max()
    if torque is not None:
        used = tube.share * scenario.actuator.tau_max / own.sums(1, SIDES, sizes, start).max()
        assert used > 0.999
        assert used == pytest.approx(torque, rel=0.01)
        assert "torque" in tube.binding
    assert far.mean() == pytest.approx(position, rel=0.01)
    assert heading is None or turned.mean() == pytest.approx(heading, rel=0.01)


SENT = changes("""
    base.delay = 0.03
    base.quantum = [2e-3, 1e-2]
    disturbance.std = 1e-4
    disturbance.truncate = 3.0
    sensor.pose_noise = 1e-4
""")
LOUD = changes("""
    disturbance.std = 0.02
    sensor.pose_noise = 1e-3
    sensor.velocity_noise = [2e-3, 2e-2]
""")
LONG = simulated(timed(PERIOD, 159), LOUD)


def test_a_set_that_does_not_stand_is_not_taken_for_one(monkeypatch):
    """The contribution of its samples is guessed to be half of the true one."""
    setup, followed, exact = settle(LONG, "prox"), [], Passing._follow

    def counted(passing, now, *given, **more):
        followed[-1] += now.count
        return exact(passing, now, *given, **more)

    def course():
        followed.append(0)
        return Passing(Along(setup), bounded_inputs(setup), np.zeros(3)).run().position

    monkeypatch.setattr(Passing, "_follow", counted)
    held = course()
    monkeypatch.setattr(passage, "HELD", 0.5)
    every = course()

    assert held == pytest.approx(every, rel=1e-3)
    assert every[-1] == pytest.approx(every.max(), rel=1e-3)
    assert followed[0] < 0.9 * 159 <= followed[1]


def test_boxes_of_secants_that_are_left_certify_nothing(monkeypatch):
    law, scenario, _ = CASES["from a standstill"]
    assert run_corridor(scenario, law).position is not None
    monkeypatch.setattr(remainders, "SLOW_ROOM", 0.6)
    narrow = override(scenario, {"clock.duration": 8 * PERIOD})

    assert "may grow as large as what the loop corrects" in run_corridor(narrow, law).refused


@pytest.mark.slow
def test_a_run_that_a_limit_stops_is_refused_with_its_time_and_what_would_do():
    told = changes("actuator.tau_max = 4.9; disturbance.std = 0.1")
    weak = override(CASES["a robot that becomes heavier"][1], told)
    tube, own = find_corridor(weak, "prox", whole=True), of_torques(weak, "prox", ("push",))
    words = re.search(r"wheel may reach (\S+) of 4.9 at t = (\S+) s,", tube.refused)
    reach, time = map(float, words.groups())

    def used(share):
        return own.sums(1, SIDES, {"push": np.full(2, 0.3 * share)}, np.zeros(3))

    first = int(np.argmax(used(1.0) > 4.9))
    assert tube.position is None
    assert time == pytest.approx(PERIOD * first)
    assert "where v_d = " in tube.refused
    assert reach == pytest.approx(used(1.0)[first], rel=0.04)
    assert used(tube.closes).max() < 4.9 < 1.02 * used(2 * tube.closes).max()


def test_all_masses_of_a_cell_stay_within_its_bounds():
    told = changes("""
        guard.enabled = true
        guard.M_min = [49.0, 5.3]
        guard.M_max = [51.0, 5.5]
        corridor.cells = 1
        robot.m = 50.0
        robot.I = 5.4
        model.m = 50.0
        model.I = 5.4
        disturbance.std = 0.0
        reference.rate = 0.3
    """)
    scenario = simulated(EIGHT, timed(0.02, 16), told)
    tube, found = run_corridor(scenario, "mb"), []
    for m, inertia in product((49.0, 51.0), (5.3, 5.5)):
        other = override(scenario, {"robot.m": m, "robot.I": inertia})
        e, _ = of_torques(other, "mb", ()).rest
        found.append((np.hypot(e[:, 0], e[:, 1]), np.abs(e[:, 2])))
    far, turned = (size.reshape(16, 2).max(axis=1) for size in np.max(found, axis=0))

    assert (far < tube.course[0]).all()
    assert (turned < tube.course[1]).all()
    assert (tube.course[0] / far).mean() == pytest.approx(1.44, rel=0.01)


@pytest.mark.slow
def test_a_dead_band_that_pushes_bring_commands_into_is_counted():
    short = burger(timed(0.06, 20), SENT, "filter.kind = clip")
    heard, partly, missed = (
        run_corridor(override(short, {"base.deadband": [0.0, dead]}), "kanayama").position
        for dead in (0.0, 0.1, 0.18)  # of 0.2 rad/s
    )

    assert heard == partly
    assert missed > 1.9 * heard


def test_infinite_guess_does_not_hold():
    """Nothing may follow from an infinite guess, however large guesses may be."""
    endless, less = (Guess(*np.full((3, 1, 2), size)) for size in (np.inf, 1.0))
    assert less.holds(less)
    assert not endless.holds(less)


def test_a_sample_that_stands_for_others_has_the_extremes_of_all():
    course = np.array([[0.0, 9.0], [1.0, 4.0], [3.0, 2.0], [2.0, 5.0], [7.0, 0.0]])
    block = SimpleNamespace(at=np.zeros(2))
    held = Instant(1, 4, None, block, held=True)

    assert held.most(course).tolist() == [[3.0, 5.0]] * 2
    assert held.least(course).tolist() == [[1.0, 2.0]] * 2
    assert Instant(1, 4, None, block).most(course).tolist() == course[1:3].tolist()


def test_reason_of_refusal_has_a_number():
    """The law compensates friction that the robot does not have: deviations grow without bound."""
    given = changes("""
        reference.kind = stop-and-go
        robot.m = 37.0
        robot.I = 7.4
        robot.mu = 0.0
        model.mu = 0.083
        disturbance.std = 0.0872
        clock.control = 0.02
        clock.duration = 0.2
        changes = []
    """)
    refused = run_corridor(safe(given), "prox").refused
    assert "may grow as large as what the loop corrects" in refused
    assert "nan" not in refused
