"""The corridor against an adversary on the tests' own loop, and what it refuses."""

import re
from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

import wmr_ctrl.theory.corridor as room
from tests.corridor.adversary import (
    attack,
    farthest,
    farthest_misled,
    worst_excursions,
    worst_pushes,
)
from wmr_ctrl.control.laws.registry import LAWS
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.theory.corridor import find_corridor
from wmr_ctrl.theory.corridor.answer import Corridor, bounds
from wmr_ctrl.world.scenario import load_scenario, override
from wmr_proofs.corridor import masses
from wmr_proofs.corridor.certificate import Certifier
from wmr_proofs.corridor.masses import certified
from wmr_proofs.corridor.whole import certified_run

EXACT_POSE = {"sensor.pose_period": 0.0, "sensor.pose_noise": 0.0, "sensor.correction": 1.0}
QUICK = {
    **EXACT_POSE, "clock.control": 0.05, "gains.kinematics.k": [12.0, 196.0, 5.0],
    "gains.prox": {"rho": [24.0, 16.0], "wo": 12.0},
}  # fmt: skip
CASES = {
    "prox, 10 ms": ("safe-simulation", "prox", {}, 300, 1.3),
    "mb, 10 ms": ("safe-simulation", "mb", {}, 300, 1.3),
    "kanayama, 10 ms": ("safe-simulation", "kanayama", {}, 400, 1.3),
    "prox, 50 ms": ("safe-experiment", "prox", QUICK, 150, 1.3),
}
"""Preset, law, changes, samples that an attack takes, and how tight the corridor is at least."""


@pytest.mark.parametrize("case", CASES)
@pytest.mark.slow_but("prox, 10 ms")
def test_no_adversary_leaves_the_corridor_and_some_come_near(case):
    preset, law, changes, samples, loose = CASES[case]
    scenario = override(load_scenario(preset), changes)
    size = scenario.disturbance.std * scenario.disturbance.truncate

    tube = find_corridor(scenario, law)
    reached = farthest(scenario, law, samples, size)

    assert tube.position / loose <= reached.position <= tube.position
    assert reached.position == pytest.approx(tube.linear, rel=0.03)
    assert np.abs(reached.e[:, 2]).max() <= tube.heading
    assert not reached.clipped
    assert reached.torque < settle(scenario, law).tau_max


@pytest.mark.slow
def test_another_mass_than_the_law_believes_in_is_one_force_with_a_sign():
    wrong = {"robot.m": 40.0, "robot.I": 4.3, "changes": []}
    believed = {"model.m": 50.0, "model.I": 5.4, "model.mu": 0.08}
    scenario = override(load_scenario("safe-simulation"), {**wrong, **believed})
    tube = find_corridor(scenario, "prox")
    reached = farthest(scenario, "prox", 300, 3.0)

    assert tube.position / 1.3 <= reached.position <= tube.position
    assert np.abs(reached.e[:, 2]).max() <= tube.heading


@pytest.mark.parametrize(("bent", "whole"), [("not", False), ("a kink", True), ("a jump", False)])
@pytest.mark.slow
def test_a_law_that_has_a_kink_where_the_robot_may_be_is_refused(bent, whole):
    """Neither has a second derivative."""
    shapes = {"not": lambda w: 0 * w, "a kink": lambda w: ca.fmax(w, 0.11),
              "a jump": lambda w: ca.if_else(w > 0.11, 1.0, 0.0)}  # fmt: skip

    def inside(context):
        law = LAWS["prox"].inside(context)
        (force,) = law.system.outputs
        more = ca.vertcat(0, 1e-6 * shapes[bent](context.v[1]))
        system = replace(law.system, outputs=(replace(force, expr=force.expr + more),))
        return replace(law, system=system)

    told = {"clock.duration": 2.0, "changes": []}
    setup = settle(override(load_scenario("safe-simulation"), told), "prox")
    setup = replace(setup, law=replace(setup.control_law, inside=inside))
    tube = certified_run(setup, closing=False) if whole else certified(setup, closing=False)

    assert (tube.position is None) == (bent != "not")


FILTERED = {"guard.enabled": False, "disturbance.std": 0.06, "sensor.pose_noise": 0.0}


@pytest.mark.slow
def test_poses_that_are_corrected_in_part_are_counted_with_their_dead_reckoning():
    pushed = override(load_scenario("safe-experiment"), FILTERED)
    misled = override(pushed, {"disturbance.std": 0.0, "sensor.pose_noise": 1e-3})
    tubes = [find_corridor(item, "prox") for item in (pushed, misled)]
    reached = farthest(pushed, "prox", 100, 0.18), farthest_misled(misled, "prox", 100, "pose")

    for tube, found, loose in zip(tubes, reached, (1.5, 2.0), strict=True):
        assert tube.position / loose < found.position <= tube.position
    assert reached[0].position == pytest.approx(tubes[0].linear, rel=0.05)
    assert tubes[1].position_late < 1.3 * reached[1].position
    assert "in the long run" in tubes[1].sentence


@pytest.mark.parametrize(
    ("kind", "noise"),
    [("pose", {"sensor.pose_noise": 1e-3}), ("velocity", {"sensor.velocity_noise": [2e-3, 5e-3]})],
)
@pytest.mark.slow
def test_so_do_errors_of_measurements_and_none_within_it(kind, noise):
    alone = {**noise, "disturbance.std": 0.0, "guard.enabled": False}
    scenario = override(load_scenario("safe-simulation"), alone)
    tube = find_corridor(scenario, "prox")
    within, beyond = (
        farthest_misled(scenario, "prox", 300, kind, times).position for times in (1.0, 1.2)
    )

    assert tube.position / 1.2 < within <= tube.position < beyond


@pytest.mark.slow
def test_a_first_velocity_that_is_off_is_counted_though_the_observer_knows_of_none_before():
    """The worst errors of 44 samples behind a first one, for which alone the answer is another."""
    size, samples, first = 1e-4, 44, 2
    changes = {
        "sensor.velocity_noise": [size, 0.0], "disturbance.std": 0.0, "guard.enabled": False,
        "gains.prox": {"kinematics": [5.0, 196.0, 5.6], "rho": [42.9, 21.74], "wo": 10.0},
    }  # fmt: skip
    scenario = override(load_scenario("safe-simulation"), changes)
    steps, push = scenario.clock.substeps, np.zeros((samples + first + 2, 2))

    def ahead(errors):
        return attack(scenario, "prox", push, velocity=errors).e[steps - 1 :: steps, 0]

    rest, errors = ahead(push), np.zeros_like(push)
    single = [np.zeros_like(push) for _ in range(2)]
    single[0][0, 0] = single[1][first, 0] = size
    at_first, later = (ahead(item) - rest for item in single)
    errors[0, 0] = np.sign(at_first[samples])
    errors[1 : samples + 1, 0] = np.sign(later[first : first + samples][::-1])
    reached = attack(scenario, "prox", push, velocity=size * errors).position
    tube = find_corridor(scenario, "prox")

    assert tube.position_late < reached <= tube.position < 1.15 * reached


@pytest.mark.slow
def test_every_peak_holds_for_every_error_at_every_plant_step():
    """Not the distance alone: each component of the box, under pushes for any direction."""
    scenario = load_scenario("safe-simulation")
    certifier = Certifier(settle(scenario, "prox"))
    box = certifier.tube(certifier.inputs).peaks.fast[:3]
    each = [np.abs(x.e).max(axis=0) for x in worst_excursions(scenario, "prox", 300, 3.0)]

    assert (np.max(each, axis=0) <= box).all()
    assert (np.max(each, axis=0)[:2] >= (0.95, 0.7) * box[:2]).all()


@pytest.mark.slow
def test_late_drives_start_with_the_torque_that_friction_takes_and_the_words_say_so():
    changes = {"guard.enabled": False, "disturbance.std": 0.05}
    scenario = override(load_scenario("safe-simulation"), changes)
    late = override(scenario, {"actuator.delay": 0.01})
    words = (
        "at its speed, with the torque that friction takes in its drives and a law that has asked "
        "for it,"
    )

    assert words in find_corridor(late, "prox").sentence
    assert words not in find_corridor(scenario, "prox").sentence


@pytest.mark.slow
def test_errors_of_the_position_are_counted():
    scenario = override(load_scenario("safe-simulation"), {"sensor.pose_noise": 1e-3})
    tube, samples, rng = find_corridor(scenario, "prox"), 200, np.random.default_rng(1)
    exact = override(scenario, {"sensor.pose_noise": 0.0})
    pushes = worst_pushes(exact, "prox", samples, 3.0)[:3]
    offsets = 1e-3 * rng.choice([-1.0, 1.0], size=(len(pushes), samples, 2))
    cases = zip(pushes, offsets, strict=True)
    reached = [attack(scenario, "prox", *case).position for case in cases]

    assert tube.position > find_corridor(exact, "prox").position + 1e-3
    assert max(reached) <= tube.position


@pytest.mark.slow
def test_a_robot_that_is_displaced_within_the_start_stays_within_the_corridor():
    start = (0.002, 0.002, 0.02)
    scenario = override(load_scenario("safe-simulation"), {"corridor.start": start})
    tube, rng = find_corridor(scenario, "prox"), np.random.default_rng(4)
    alone = find_corridor(load_scenario("safe-simulation"), "prox")
    pushes = list(worst_pushes(scenario, "prox", 300, 3.0))
    quiet = np.zeros((20, 2))
    jumps = rng.choice([-1.0, 1.0], size=(len(pushes), 3)) * start
    reached = [
        attack(scenario, "prox", np.vstack([quiet, p[-k:]]), jump=jump, at=20).position
        for k, p, jump in zip((300, 100, 50, 30, 20, 10, 5, 3), pushes, jumps, strict=True)
    ]

    assert max(reached) <= tube.position
    assert "on it, or moved there by up to 2 mm ahead" in tube.sentence
    assert tube.position_late == pytest.approx(alone.position, rel=1e-4)
    assert tube.position_late < tube.position


@pytest.mark.parametrize("changes", [{}, {"sensor.pose_noise": 1e-5}])
def test_a_start_too_far_off_is_refused_with_the_largest_share_that_closes(changes):
    start = np.array([0.05, 0.05, 0.15])
    scenario = override(load_scenario("safe-simulation"), {**changes, "corridor.start": start})
    tube = find_corridor(scenario, "prox")

    assert tube.position is None
    told = re.search(r"; it closes from (\S+) % of corridor.start$", tube.sentence)
    assert 0.9 * tube.near <= float(told[1]) / 100 <= tube.near < 1
    for share, closes in ((0.98, True), (1.02, False)):
        nearer = override(scenario, {"corridor.start": share * tube.near * start})
        tube_there = certified(settle(nearer, "prox"), closing=False)
        assert (tube_there.position is not None) == closes


@pytest.mark.slow
def test_of_masses_in_an_interval_each_keeps_within_one_corridor():
    told = {"guard.M_min": [48.0, 5.2], "guard.M_max": [52.0, 5.6], "corridor.cells": 2}
    told |= {"changes": []}
    scenario = override(load_scenario("safe-simulation"), told)
    tube, alone = (
        find_corridor(scenario, "prox"),
        find_corridor(load_scenario("safe-simulation"), "prox"),
    )
    believed = {"model.m": 50.0, "model.I": 5.4, "model.mu": 0.08}
    corners = [{**believed, "robot.m": m, "robot.I": i} for m in (48.0, 52.0) for i in (5.2, 5.6)]

    assert tube.masses == ((48.0, 52.0), (5.2, 5.6))
    assert tube.position > alone.position
    for corner in corners:
        assert farthest(override(scenario, corner), "prox", 100, 3.0).position <= tube.position


@pytest.mark.slow
def test_cells_that_are_too_coarse_are_refused_with_the_mass():
    scenario = override(load_scenario("safe-simulation"), {"corridor.cells": 1})

    assert "with M = 58.2 kg" in find_corridor(scenario, "prox").refused


REFUSED = {
    "disturbance.truncate = inf": ("paper-simulation", {}, "prox"),
    "corrected in part": ("safe-experiment", {"sensor.pose_period": 0.2}, "prox"),
    "v_c0 (angular) may reach 3.43 of 1.3, which is so for the linear loop already": (
        "safe-experiment",
        {},
        "prox",
    ),
    "circles and lines alone": ("safe-simulation", {"reference.kind": "lemniscate"}, "prox"),
    "away from their limits": ("safe-simulation", {}, "smc"),
    "the effect encoder": ("robot-10ms", {}, "prox"),
    "counts a lag or late velocities": ("safe-simulation", {"actuator.lag": 0.005}, "prox"),
    "unstable": ("safe-simulation", {"clock.control": 0.2, "guard.enabled": False}, "prox"),
    "depends on the heading": ("safe-simulation", {"slope.angle": 0.01}, "prox"),
    "may grow as large as what the loop corrects, beyond the 30.4 mm that the linear loop leaves": (
        "safe-experiment",
        EXACT_POSE,
        "prox",
    ),
}


@pytest.mark.parametrize("words", REFUSED)
@pytest.mark.slow_but(
    "disturbance.truncate = inf",
    "corrected in part",
    "circles and lines alone",
    "away from their limits",
    "the effect encoder",
    "counts a lag or late velocities",
    "unstable",
    "depends on the heading",
)
def test_what_is_not_covered_is_refused_by_name(words):
    preset, changes, law = REFUSED[words]

    tube = find_corridor(override(load_scenario(preset), changes), law)

    assert tube.position is None
    assert words in tube.refused
    assert words in tube.sentence


@pytest.mark.slow
def test_where_none_closes_it_says_for_which_share_one_would():
    scenario = override(load_scenario("safe-experiment"), EXACT_POSE)
    closes = find_corridor(scenario, "prox").closes

    with_less = override(scenario, {"disturbance.std": 0.9 * closes})
    with_more = override(scenario, {"disturbance.std": 1.1 * closes})

    assert find_corridor(with_less, "prox").position is not None
    assert find_corridor(with_more, "prox").position is None


LESS = {
    "with M = 58.2 kg e1 (w - w_d) may grow": {"corridor.cells": 1},
    "(others were not tried) it closes with cells as narrow as those of corridor.cells = 3": {
        "corridor.cells": 1,
        "gains.prox": {"kinematics": [16.8, 196.0, 5.6], "rho": [42.9, 21.74], "wo": 10.0},
    },
    "leave out sensor.velocity_window = 0.02": {"sensor.velocity_window": 0.02},
}


@pytest.mark.parametrize("words", LESS)
@pytest.mark.slow_but("leave out sensor.velocity_window = 0.02")
def test_a_refusal_has_numbers_and_says_what_to_change(words, monkeypatch):
    monkeypatch.setattr(masses, "MOST_CELLS", 0)
    told = {"guard.enabled": "corridor.cells" in LESS[words], **LESS[words]}
    tube = find_corridor(override(load_scenario("safe-simulation"), told), "prox")

    assert tube.position is None
    assert words in tube.refused


@pytest.mark.slow
def test_what_a_refusal_of_cells_says_closes_with_every_mass():
    told = {"corridor.cells": 1, "changes": []}
    scenario = override(load_scenario("safe-simulation"), told)
    refused = find_corridor(scenario, "prox").refused
    count = int(re.search(r"; it closes with corridor.cells = (\d+)", refused)[1])
    assert find_corridor(override(scenario, {"corridor.cells": count}), "prox").position is not None

    pushed = override(scenario, {"corridor.cells": 2, "disturbance.std": 3.0})
    tube = find_corridor(pushed, "prox")
    assert "it closes while each wheel is pushed by at most" in tube.sentence
    less = override(pushed, {"disturbance.std": 0.99 * 3.0 * tube.closes})
    more = override(pushed, {"disturbance.std": 1.03 * 3.0 * tube.closes})
    assert find_corridor(less, "prox").position is not None
    assert find_corridor(more, "prox").position is None


def test_figures_and_words_are_rounded_to_the_safe_side():
    assert bounds(0.0, 0.0, (0.0019999, 0.00109999)) == (
        "velocities to within 0.00199 m/s and 0.00109 rad/s"
    )
    tube = Corridor(
        "prox", position=1e-14, heading=2e-15, position_late=1e-14, share=0.1,
        masses=((45.00000049, 71.50000051), (4.0, 5.0)),
    )  # fmt: skip
    assert {tube.figures[key] for key in ("position", "heading", "position_late")} == {1e-9}
    assert "M is anything from 45.0001 to 71.5 kg" in tube.sentence


def test_what_a_refusal_closes_with_is_the_share_of_all_that_disturbs():
    tube = Corridor("prox", refused="no", closes=0.5, push=2.0, pose=0.02, velocity=(0.004, 0.2))

    assert tube.sentence == (
        "no corridor: no; it closes while each wheel is pushed by at most 1 N m, positions are "
        "measured to within 10 mm, velocities to within 0.002 m/s and 0.1 rad/s"
    )


@pytest.mark.slow
def test_with_as_few_lost_poses_as_a_refusal_says_there_is_a_corridor():
    told = {"sensor.pose_dropout": 0.1, "corridor.losses": 1000}
    scenario = override(load_scenario("safe-simulation"), told)
    refused = find_corridor(scenario, "prox").refused
    less = {
        "corridor.losses": int(re.search(r"it closes with corridor.losses = (\d+)", refused)[1])
    }

    assert find_corridor(override(scenario, less), "prox").position is not None


LOST = {"sensor.pose_dropout": 0.1, "corridor.losses": 40}


@pytest.mark.parametrize(("period", "more"), [(0.05, LOST), (5.0, {})])
@pytest.mark.slow
def test_what_a_refusal_says_to_set_for_rare_poses_has_a_corridor(period, more):
    scenario = override(load_scenario("safe-simulation"), {"sensor.pose_period": period, **more})
    refused = find_corridor(scenario, "prox").refused
    less = {key: float(x) for key, x in re.findall(r"(sensor\.\S+) = ([\d.]+)", refused)}

    assert bool(more) == ("sensor.pose_dropout" in less)
    assert (period > 0.05) == ("sensor.pose_period" in less)
    assert find_corridor(override(scenario, less), "prox").position is not None


def test_without_ball_arithmetic_it_is_not_checked(monkeypatch):
    monkeypatch.setattr(room, "is_open", lambda: False)

    assert "NOT_CHECKED" in find_corridor(load_scenario("safe-simulation"), "prox").sentence


@pytest.mark.slow
def test_a_first_command_counts_from_the_measured_velocity():
    """Its change may be a_max T at most: what that velocity is off leaves the less of it."""
    changes = {
        "sensor.velocity_noise": [1e-4, 1e-4], "disturbance.std": 0.1, "guard.enabled": False,
    }  # fmt: skip
    scenario = override(load_scenario("safe-simulation"), changes)
    certifier = Certifier(settle(scenario, "kanayama"))
    names = [item.name for item in certifier.loop.conditions]
    sizes = dict(zip(names, certifier.most, strict=True))
    period, gains = scenario.clock.control, settle(scenario, "kanayama").gains
    off = certifier.inputs.velocity

    assert (off > 0).all()
    for i, axis in enumerate(("linear", "angular")):
        left = gains.a_max[i] * period - off[i]
        assert sizes[f"the command's change ({axis})"] == pytest.approx(left, rel=1e-9)
        assert sizes[f"the command's change ({axis})"] <= left

    far = override(scenario, {"sensor.velocity_noise": [0.1, 0.1]})
    refused = find_corridor(far, "kanayama")
    assert refused.position is None
    assert "the measured velocity is off by" in refused.refused


def test_a_name_instead_of_a_scenario_is_refused():
    with pytest.raises(ArgumentError, match=r"find_corridor: scenario = .* must be a Scenario"):
        find_corridor("safe-simulation", "prox")
