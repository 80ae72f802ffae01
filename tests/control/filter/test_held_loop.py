"""PI loops held over plant steps: the effect of each step is within the filters' assumptions."""

import math

import numpy as np
import pytest
from scipy import signal

import wmr_ctrl
from tests.control.bases import VELOCITY, based
from tests.control.test_velocity_base import OVERSHOOTING, ROOT
from tests.tables import cases, changes
from wmr_ctrl.control.filter.band import enclosed
from wmr_ctrl.control.filter.clip import slew_reach
from wmr_ctrl.control.filter.filter import command_filter
from wmr_ctrl.control.filter.forecast import PIECES
from wmr_ctrl.control.filter.held_loop import HeldLoop, _time_of_pushes, held_friction
from wmr_ctrl.control.filter.peak_gain import PiLoop, peak_gains
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.world.scenario import override

WORST = changes("robot.m = 55.0; base.kp = 140.0; base.ki = 320.0")
"""The member of the stated family that swings most."""
ALONE = {"base.kind": "torque"}
"""Override that removes a run's own base from a scenario, so that the stated family alone remains.
"""


def worst(h, **stated):
    """A run of the worst member of the family, with its force held over h."""
    own = {**OVERSHOOTING, **WORST, "clock.plant": h, "clock.control": 0.05}
    return override(based(own), {f"filter.{key}": value for key, value in stated.items()})


def steps(
    h, pushed = False, count = 4_000, M = 55.0, kp = 140.0,
    ki = 320.0, c = 0.0,
):  # fmt: skip
    """Speed after each step, under a command of 1 from the first step on, or a push of 1 N."""
    v = f = 0.0
    found, u, d = [], 0.0 if pushed else 1.0, float(pushed)
    for _ in range(count):
        v, f = v + h / M * (kp * (u - v) + f - c * v + d), f + h * ki * (u - v)
        found.append(v)
    return np.array(found)


def swung(speeds):
    """Largest speed that commands (or pushes) of at most 1 can cause: the sum of all changes."""
    return float(np.abs(np.diff(speeds, prepend=0.0)).sum())


@pytest.mark.parametrize(
    "h, more, said",
    [(0.005, 1.0073, "0.7 % at 5 ms"), (0.01, 1.0148, "1.5 % at 10 ms")],
)
def test_the_peak_gain_of_a_run_is_that_of_its_held_loop_where_it_is_the_larger(h, more, said):
    run = worst(h, push=[10.0, 0.0])
    own, alone = (peak_gains(item)[0] for item in (run, override(run, ALONE)))
    N, pushed = swung(steps(h)), swung(steps(h, pushed=True))
    assert N / alone.gain == pytest.approx(more, abs=1e-4)
    assert N <= own.gain < N * (1 + 1e-4)
    assert said in (ROOT / "docs" / "explanation" / "filter.md").read_text(encoding="utf-8")
    assert pushed * 10 <= own.push
    inside = override(run, changes("robot.m = 50.0; base.kp = 150.0; base.ki = 300.0"))
    assert peak_gains(inside)[0] == alone


@pytest.mark.parametrize("z, share", [(0.2, 0.0), (0.7, 0.4), (1.5, 0.0), (2.5, 0.4)])
def test_no_loop_that_is_held_swings_more_than_it_is_said_to(z, share):
    """The computed peaks bound the peaks of the held loop.

    Their gain is at most 3 % larger, unless the loop without a hold has a larger gain.
    ``share``: the part of the damping that is friction.
    """
    M, h, w0 = 20.0, 0.01, 4.0
    k, ki = 2 * z * w0 * M, w0**2 * M
    own = {"M": M, "kp": (1 - share) * k, "ki": ki, "c": share * k}
    through = HeldLoop((M, M), own["kp"], ki, (own["c"], own["c"]), h)
    sides = [(x, x) for x in own.values()]
    peak = PiLoop(*sides, through).peak(1.0)
    N, pushed = (swung(steps(h, side, **own)) for side in (False, True))

    assert peak.gain * (1 + 1e-12) >= N
    assert pushed <= peak.push * (1 + 1e-12)
    assert peak.gain <= max(PiLoop(*sides).peak(1.0).gain, 1.03 * N)


@pytest.mark.slow
@pytest.mark.parametrize("h", [0.001, 0.01])
def test_the_tables_of_a_band_hold_every_step_of_the_held_loop(h):
    """The tables without the held loop do not bound the response to a step of that length."""

    def beyond(run):
        known, response = enclosed(run, 0), steps(h)
        piece = run.clock.control / PIECES
        times = h * np.arange(1, 4001)
        own = np.floor(times / piece + 1e-9).astype(int)
        inner = own < len(known.high)
        over = response[inner] - known.high[own[inner]], known.low[own[inner]] - response[inner]
        late = times[~inner] - piece * len(known.high)
        left = np.abs(response[~inner] - 1) - known.left * np.exp(-known.rate * late)
        return float(max(map(np.max, (*over, left))))

    exact = {"mass": [55.0] * 2, "kp": [140.0] * 2, "ki": [320.0] * 2}
    known = worst(h, kind="band", **exact)
    assert beyond(known) <= 1e-12 < 1e-4 < beyond(override(known, ALONE))


@pytest.mark.slow
def test_slow_commands_reach_what_the_sum_over_steps_tells():
    """K L of a held loop: h times the sum of |1 - S| from where S first reaches 1 on."""
    h = 0.01
    run = worst(h, slew=[0.05, 0.05], mass=[55.0] * 2, kp=[140.0] * 2, ki=[320.0] * 2)
    left = 1 - steps(h)
    first = int(np.argmax(left <= 0))
    held = h * np.abs(left[first:]).sum() + peak_gains(run)[0].gain * run.clock.control / 2
    reach, alone = slew_reach(run)[0], slew_reach(override(run, ALONE))[0]
    assert alone < held <= reach


@pytest.mark.parametrize("z", [0.2, 0.7])
def test_a_push_lasts_as_long_as_the_rest_of_a_step_over_the_peak_gain(z):
    base = override(based(OVERSHOOTING), {
        "base.loop": "second-order", "base.damping": z, "base.frequency": 3.0})  # fmt: skip
    times = np.linspace(0, 40 / z, 200_001)
    _, S = signal.step(([9.0], [1.0, 6.0 * z, 9.0]), T=times)
    _, impulse = signal.impulse(([9.0], [1.0, 6.0 * z, 9.0]), T=times)
    rest, gain = (float(np.trapezoid(np.abs(x), times)) for x in (1 - S, impulse))
    assert _time_of_pushes(base, 0) - base.clock.plant == pytest.approx(rest / gain, rel=1e-6)


def test_a_run_takes_the_steps_that_are_counted_on():
    """Viscous friction is held over a step, too."""
    run = worst(0.01, friction=[0.0, 30.0])
    run = override(run, changes("""
        clock.control = 0.01
        resistance.viscous = [20.0, 1.0]
        clock.duration = 3.0
    """))  # fmt: skip
    log = wmr_ctrl.simulate(run, "kanayama", engine="numpy")
    v, u, f = log["v1"], log["v_command"], 0.0
    for k in range(len(v) - 1):
        expected = v[k] + 0.01 / 55.0 * (140.0 * (u[k] - v[k]) + f - 20.0 * v[k])
        assert v[k + 1] == pytest.approx(expected, abs=1e-12)
        f += 0.01 * 320.0 * (u[k] - v[k])
    assert np.ptp(v) > 0.1


@pytest.mark.parametrize(
    "change",
    [
        changes("base.kp = 1e4; filter.kp = [1e4, 1e4]"),
        changes("clock.plant = 0.5; clock.control = 1.0"),
    ],
)
def test_a_loop_too_quick_for_its_steps_is_refused(change):
    with pytest.raises(ScenarioError, match=r"clock\.plant = .* is held for as long"):
        settle(override(worst(0.01), change), "kanayama")


def stepped(v, u, mu, h):
    """v after a step of a run: one of Runge and Kutta's, with the loop of 0.2 s and friction
    held.
    """
    given, k = (u - v) / (-h / math.expm1(-h / 0.2)) + mu * 9.81 * math.tanh(v / 0.01), [0.0]
    for share in (0.0, 0.5, 0.5, 1.0):
        k.append(given - mu * 9.81 * math.tanh((v + share * h * k[-1]) / 0.01))
    return v + h / 6 * (k[1] + 2 * k[2] + 2 * k[3] + k[4])


def rim(limit, mu, h, asked, l=0.25):
    """Return the largest speed of a rim during the requests ``asked``, with exact odometry."""
    top, v, w = 0.0, 0.0, 0.0
    for demand in asked:
        u = limit.step(demand, (v, w)).command
        for _ in range(round(0.05 / h)):
            v, w = stepped(v, u[0], mu, h), stepped(w, u[1], 0.0, h)
            top = max(top, abs(v) + l * abs(w))
    return top


def test_a_governor_counts_on_friction_that_changes_within_a_plant_step():
    """Friction holds the base back near rest, so it reverses faster than the governor assumes.

    The proposed ``filter.tau`` covers this.
    """
    told = {"kind": "governor", "tau": [0.2, 0.2]}
    stated = based(VELOCITY | changes("""
        base.tau = [0.2, 0.2]
        base.gain = [1.0, 1.0]
        robot.mu = 0.1
        clock.plant = 0.01
        limits.v_u1 = [1.0, 2.0]
    """) | {"filter": told})  # fmt: skip
    (said,) = held_friction(stated)
    slowest = float(said.split("Raise it to ")[1].split(" s")[0])
    enough = override(stated, {"filter.tau": [0.2, slowest]})

    asked = [(r, 0.0) for r in np.random.default_rng(0).choice([-9.0, 9.0, 0.0, 0.3], 1200)]
    assert rim(command_filter(stated), 0.1, 0.01, asked, 0.0) > 1.003
    assert rim(command_filter(enough), 0.1, 0.01, asked, 0.0) <= 1.0
    assert not list(held_friction(enough))
    assert not list(held_friction(override(stated, {"robot.mu": 0.0})))


LIMITED = {"wheel_speed": 0.8, "d": [0.0, 0.0], "tau": [0.2, 0.2]}
CLIP = {"kind": "clip", **LIMITED}
GOVERNOR = {"kind": "governor", "channels": "wheels", "odometry": [0.02, 0.0], **LIMITED}
TURNED = [*((9.0, 0.0),) * 60, *((0.0, 9.0),) * 60] * 2
"""Straight on, then a turn in place: friction keeps some of v while omega is there already."""
SWAYED = [*((0.2, 9.0),) * 2, *((-0.1, 9.0),) * 2] * 20
"""A turn in place that goes to and fro."""


def limited(stated, mu, h):
    """A base of loops of 0.2 s behind a filter that limits its wheels."""
    return based(VELOCITY | changes("""
        base.tau = [0.2, 0.2]
        base.gain = [1.0, 1.0]
        limits.v_u1 = [1.0, 4.0]
    """) | {"filter": stated, "robot.mu": mu, "clock.plant": h})  # fmt: skip


def told(stated):
    """Return the bound d of v [m/s] that the refusal of a run proposes."""
    with pytest.raises(ScenarioError, match=r"holds back v alone. Raise it to that") as refused:
        settle(stated, "kanayama")
    return float(str(refused.value).split("up to ")[1].split(" m/s")[0])


@pytest.mark.parametrize("stated, asked", [(CLIP, TURNED), (GOVERNOR, SWAYED)])
@pytest.mark.parametrize("mu, h", [(0.1, 0.001), (0.02, 0.005), (0.1, 0.01)])
def test_what_counts_for_friction_at_a_rim_is_enough(stated, asked, mu, h):
    """The proposed ``filter.d`` covers friction at a rim, for a clip and for a governor.

    A governor's commands may be far beyond V.
    """
    run = limited(stated, mu, h)
    enough = override(run, {"filter.d": [told(run), 0.0]})
    settle(enough, "kanayama")
    assert rim(command_filter(run), mu, h, asked) > 0.8
    assert rim(command_filter(enough), mu, h, asked) <= 0.8
    settle(override(run, {"robot.mu": 0.0}), "kanayama")


@pytest.mark.parametrize(
    "changed, words",
    cases("""
        filter.odometry = [0, 0]             | with friction within plant steps, and filter.odometry
        initial.velocity = [0.3, 2]          | a wheel starts at 0.8 m/s, above 0.798 m/s
        robot.mu = 0.3; clock.plant = 0.01   | Shorten clock.plant to at most 0.00679 s
    """),
)
def test_what_a_governor_of_rims_counts_on_with_friction_is_refused_where_it_fails(changed, words):
    run = override(limited(GOVERNOR, 0.1, 0.001), {"filter.d": [0.3, 0.0]})
    settle(run, "kanayama")
    with pytest.raises(ScenarioError, match=words):
        settle(override(run, changes(changed)), "kanayama")


def test_friction_that_is_too_steep_for_a_plant_step_is_refused_behind_every_filter():
    """Friction too steep for the plant step is refused, and the proposed step is accepted.

    With steps of 10 ms and mu = 0.6, a base behind a clip reached 1.27 times a limit of 1 cm/s.
    """
    steep = changes("filter.kind = clip; robot.mu = 0.6; clock.plant = 0.01")
    stated = based({**VELOCITY, **steep, "base.gain": [1.0, 1.0]})
    with pytest.raises(ScenarioError, match="throw v beyond its command near rest") as refused:
        settle(stated, "kanayama")
    enough = float(str(refused.value).split("to at most ")[1].split(" s")[0])
    assert 0.004 < enough < 0.005
    settle(override(stated, {"clock.plant": 0.05 / math.ceil(0.05 / enough)}), "kanayama")


def test_a_governor_of_wheels_needs_one_gain_for_both_axes():
    run = override(limited(GOVERNOR | {"gain": [0.9, 1.1]}, 0.0, 0.001), {"base.gain": [1.0, 1.05]})
    with pytest.raises(ScenarioError, match="loops of v and omega differ"):
        settle(run, "kanayama")
