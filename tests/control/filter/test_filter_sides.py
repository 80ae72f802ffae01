"""A limit for each direction: the commands the filter sends, and the cases it refuses."""

import numpy as np
import pytest

from tests.tables import cases, changes
from wmr_ctrl.control.filter import CommandFilter
from wmr_ctrl.control.filter.filter import filter_system, passing_commands
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.world.scenario import load_scenario

STATED = changes("""
    filter.gain = [0.9, 1.1]
    filter.d = [0.05, 0.05]
    filter.tau = [0.2, 0.3]
    filter.odometry = [0.02, 0.02]
    clock.control = 0.05
    limits.v_u1 = [1.0, 1.0]
    limits.v_u2 = [0.7, 0.7]
    limits.v_min = [-0.05, -0.4]
    limits.v_max = [0.8, 1.0]
""")
SWINGS = changes("""
    filter.loop = second-order
    filter.damping = [0.5, 1.0]
    filter.frequency = [3.0, 5.0]
""") | {"filter.tau": None, "filter.odometry": None}  # fmt: skip


def stated(kind, **more):
    return load_scenario("paper-simulation", {**STATED, "filter.kind": kind, **more})


def test_a_clip_sends_what_the_limit_of_the_direction_leaves():
    step = CommandFilter(stated("clip", **{"filter.scale": "axes"})).step
    assert step((9, 9)).command == pytest.approx((0.75 / 1.1, 0.95 / 1.1), rel=1e-7)
    assert step((-9, -9)).command == pytest.approx((0.0, -0.35 / 1.1), rel=1e-7)
    assert step((0, 0)).flags == ()


@pytest.mark.parametrize("kind", ["clip", "governor"])
@pytest.mark.parametrize("scale", ["curvature", "axes", "turn", "drive"])
def test_nothing_backwards_is_sent_where_a_push_alone_leads_to_the_limit(kind, scale):
    """Not even by rounding; and stopping is never refused."""
    filtered, draw = (
        CommandFilter(stated(kind, **{"filter.scale": scale})),
        np.random.default_rng(2),
    )
    for _ in range(200):
        asked = draw.uniform(-3, 3, 2).tolist()
        still = filtered.step(asked, [draw.uniform(-0.05, 0.8), draw.uniform(-0.4, 1.0)])
        assert still.command[0] * asked[0] >= 0
        if kind == "clip":
            assert still.command[0] >= 0
        assert filtered.step((0.0, 0.0)).command == (0.0, 0.0)


def test_a_command_between_its_ends_passes():
    scenario = stated("governor")
    filtered, draw = CommandFilter(scenario), np.random.default_rng(4)
    rows = passing_commands(scenario)
    assert rows[0][2] == pytest.approx((0.0, 0.75 / 1.1), rel=1e-7)
    for _ in range(200):
        command = [draw.uniform(*ends) for _, _, ends in rows]
        filtered.step(draw.uniform(-3, 3, 2).tolist())
        assert filtered.step(command).command == pytest.approx(command, rel=1e-12)


def test_wheels_that_turn_first_pass_what_turns_within_their_limits_alone():
    wheels = {"filter.channels": "wheels", "filter.scale": "turn", "limits.v_min": (-0.2, -1.0)}
    scenario = stated("clip", **wheels)
    filtered, rows = CommandFilter(scenario), passing_commands(scenario)
    asked = np.random.default_rng(5).uniform(-1, 1, (500, 2))
    inside = [u for u in asked if all(low <= u @ row <= high for _, row, (low, high) in rows)]
    assert len(inside) > 10
    for command in inside:
        assert filtered.step(command.tolist()).command == pytest.approx(command, rel=1e-12)


@pytest.mark.parametrize(
    "more, said",
    cases(r"""
        limits.v_min = [0, -0.4]    | d\[1\] = 0.05 alone .* to -0.05, and limits.v_min\[1\] is
        limits.v_min = [0, -0.4]    | State limits.v_min\[1\] = -0.05: then no command that way
        limits.v_max = [0.8, 0.02]  | d\[2\] = 0.05 .* to 0.05, and limits.v_max\[2\] is
        filter.kind = band          | v_min\[1\] = -0.05, .* = 0.8: .*"band" keeps one
        filter.slew = [0.1, 0.1]    | v_min\[1\] = -0.05, .*= 0.8: .* a loop that overshoots
    """),
)
def test_what_cannot_be_kept_is_refused_by_name(more, said):
    own = SWINGS if more.startswith("filter") else {}
    with pytest.raises(ScenarioError, match=said):
        filter_system(stated("clip", **own, **changes(more)))
