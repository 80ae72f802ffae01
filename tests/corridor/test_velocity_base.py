"""The corridor of bases that take velocities, against an adversary of the tests' own."""

import numpy as np
import pytest

from tests.control.bases import VELOCITY, based
from tests.corridor.further import EXACT, PUSHED, QUIET, WIDE, burger
from tests.corridor.sending import course
from tests.tables import cases, changes
from wmr_ctrl import simulate
from wmr_ctrl.control.filter.filter import CommandFilter, passing_commands
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.report.course import course_of_tube
from wmr_ctrl.theory.corridor import corridor_monitor, find_corridor
from wmr_ctrl.world.scenario import load_scenario
from wmr_proofs.corridor.certificate import Certifier


@pytest.mark.slow
def test_it_starts_with_commands_under_way_and_an_observer_that_knows_of_them():
    """Without commands in transit the robot falls behind; the answer says that this is excluded."""
    scenario = burger(QUIET, WIDE)
    certifier = Certifier(settle(scenario, "prox"))
    force, _ = certifier.loop.observed
    memory = certifier.loop.remains[2 + force : 4 + force]
    tube = find_corridor(scenario, "prox")

    assert memory == pytest.approx([0.0, 0.0], abs=1e-12)
    assert course(scenario, "prox", 40).position <= tube.position + 1e-12
    assert course(scenario, "kanayama", 40, idle=True).position > 1e-4


@pytest.mark.parametrize(
    "changed, why",
    cases("""
        actuator.tau_max = 1; filter.kind = clip   | actuator.tau_max
        base.losses = 1; filter.kind = clip        | command loss
        base.jerk = [1, 1]; filter.kind = clip     | command jerk
        corridor.start = [0.1, 0.1, 0.1]           | the command's change (angular) may reach | slow
        base.w_max = 4.95; filter.kind = clip      | the firmware's limit of the right wheel  | slow
        limits.v_u1 = [0.174, 2.84]; limits.v_u2 = [0.165, 2.2] | the filter's limit (v)      | slow
    """),
)
def test_what_is_not_covered_is_refused_by_name(changed, why):
    tube = find_corridor(burger(PUSHED, changed), "kanayama")

    assert tube.position is None
    assert why in tube.refused


@pytest.mark.parametrize(
    "told, why",
    cases("""
        filter.kind = band                            | filter.kind = "band"
        filter.kind = clip; filter.slew = [0.1, 0.3]  | filter.slew
    """),
)
def test_filters_that_remember_what_was_sent_are_refused(told, why):
    second = changes("""
        filter.loop = second-order
        filter.frequency = [4.0, 6.0]
        filter.damping = [0.8, 1.0]
        filter.trust = true
    """)
    assert why in find_corridor(based(VELOCITY | second, told), "kanayama").refused


@pytest.mark.parametrize("channels", ["body", "wheels"])
@pytest.mark.parametrize("kind", ["clip", "governor"])
@pytest.mark.parametrize("scale", ["curvature", "turn", "drive"])
def test_a_filter_passes_the_commands_within_its_sizes_whatever_came_before(kind, scale, channels):
    scenario = burger({"filter.kind": kind, "filter.scale": scale, "filter.channels": channels})
    filtered, rng = CommandFilter(scenario), np.random.default_rng(3)
    rows = passing_commands(scenario)
    largest = 0.0
    for _ in range(300):
        command = (rng.uniform(-1, 1, 2) * (0.25, 3.0)).tolist()
        used = max(
            abs(row[0] * command[0] + row[1] * command[1]) / most for _, row, (_, most) in rows
        )
        filtered.step(rng.uniform(-3, 3, 2).tolist(), rng.uniform(-0.2, 0.2, 2).tolist())
        if used <= 1:
            seen = rng.uniform(-0.2, 0.2, 2).tolist()
            assert filtered.step(command, seen).command == pytest.approx(command, rel=1e-14)
            largest = max(largest, used)
    assert largest > 0.9


def test_a_base_that_takes_velocities_has_no_monitor():
    with pytest.raises(ScenarioError, match="bases that take velocities"):
        corridor_monitor(burger(PUSHED), "kanayama")


@pytest.mark.slow
def test_a_run_that_begins_without_commands_under_way_has_the_band_of_the_whole_run():
    """The permanent corridor starts with commands at the reference's speed in transit, which no run
    has.
    """
    scenario = burger("clock.duration = 4.0")
    run = simulate(scenario, "kanayama")
    known = find_corridor(scenario, "kanayama", whole=True)

    assert known.late == "commands of that speed in transit and a law that has sent them"
    assert known.figures["late"] == known.late
    assert known.whole.run == 4.0
    assert known.position < 1e-9 < known.whole.position
    assert "within 0.1 mm and 0.0001 rad" in known.sentence
    most = max(known.whole.position, known.whole.heading)
    assert course_of_tube(run).max() == pytest.approx(most)


@pytest.mark.slow
def test_nothing_is_promised_of_obstacles_where_only_the_corridor_for_good_is_known():
    told = changes("""
        reference.keep_out = [[0.0, -0.3, 0.1]]
        body.radius = 0.1
        base.accel = [2.0, 12.0]
        disturbance.std = 2e-6
        disturbance.truncate = 3.0
        filter.kind = clip
    """)
    scenario = burger(told)
    tube = find_corridor(scenario, "kanayama", whole=True)

    assert tube.position is not None
    assert tube.whole.position is None
    assert tube.clearance.free is None
    assert "without a corridor of the run nothing is promised" in tube.sentence


@pytest.mark.slow
def test_a_ramp_behind_a_small_dead_band_has_a_corridor():
    """The bound on a ramp's change includes the step that the dead band adds."""
    told = changes("""
        base.accel = [2.0, 12.0]
        base.deadband = [0.005, 0.01]
        filter.kind = clip
        disturbance.std = 3e-5
        disturbance.truncate = 3.0
    """)
    scenario = burger(told)

    assert find_corridor(scenario, "kanayama").position is not None


@pytest.mark.slow
def test_a_ramp_that_nothing_disturbs_has_a_corridor_of_nearly_nothing():
    tube = find_corridor(load_scenario("clearpath-jackal", EXACT), "kanayama")

    assert tube.position < 1e-9
