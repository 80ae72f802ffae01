"""Logs of bases that take velocities give their numbers back."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.own_axes import Axis, Truth
from tests.identification.conftest import NUMBERS, drive
from wmr_ctrl import identify, simulate
from wmr_ctrl.control.filter import command_filter
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.identification.logs.log import LogError
from wmr_ctrl.identification.logs.samples import AxisLog
from wmr_ctrl.identification.propose import propose
from wmr_ctrl.identification.speed_loop import foretold
from wmr_ctrl.report.identified import write_identification
from wmr_ctrl.world.scenario import loads_scenario


def test_speeds_of_sets_that_are_followed_together_are_those_of_each_alone():
    """For any number of sets and any delays."""
    rng = np.random.default_rng(3)
    t, sent = 0.02 * np.arange(60), rng.uniform(-0.5, 0.5, 6).repeat(10)
    log = AxisLog(t, sent, np.ones(60, bool), t, sent, np.array([0, 25]), of_way=False, period=0.02)
    names = ("gain", "wn", "zeta", "accel", "delay")
    drawn = rng.uniform((0.8, 2.0, 0.3, 0.5, 0.0), (1.2, 9.0, 1.1, 3.0, 0.1), (9, 5))
    sets = [dict(zip(names, row, strict=True)) for row in drawn]

    together = foretold(log, "second-order", sets).T

    assert np.ptp(together, axis=0).max() > 0.05
    alone = [foretold(log, "second-order", [one])[:, 0] for one in sets]
    assert together == pytest.approx(np.array(alone), abs=1e-12)


def test_a_first_order_base_gives_its_numbers_back_but_no_limit_that_was_never_met(based):
    """Three half-widths: an interval of 95 % misses by that much once in 1e8."""
    assert based.bounds.loop == "first-order"
    for name, truth in NUMBERS.items():
        item = based.parameters[name]
        assert item.verdict == "determined", name
        assert abs(item.value - truth) <= 3 * max(item.high - item.value, item.value - item.low)
    assert min(based.score.foretold) > 0.98
    ramp = based.parameters["accel1"]
    assert (ramp.verdict, ramp.high) == ("undetermined", np.inf)
    assert ramp.low > 1.0
    assert any("acceleration limit" in text for text in based.remarks)


def test_deviations_are_means_of_what_is_left_of_the_rows_in_use(based):
    fit = based.judgements[0].fit
    left = np.where(fit.log.in_fit, 3.0, np.inf)

    deviation = replace(fit, left=left).deviation()
    assert np.median(deviation) == pytest.approx(3.0)
    assert deviation.max() == pytest.approx(3.0)


def test_the_scenario_runs_behind_its_filter(based):
    scenario = loads_scenario(based.to_toml(), based.scenario.name)

    assert scenario == based.scenario
    command_filter(scenario)
    run = simulate(scenario, "kanayama", overrides={"clock.duration": 1.0})
    assert run.monitor.violations == 0
    # The peak gain of a family of first-order loops is its largest gain.
    assert based.bounds.peak_gain == tuple(high for _, high in scenario.filter.intervals("gain"))


def test_the_picture_and_the_page_are_those_of_a_base(based, tmp_path):
    write_identification(based, tmp_path / "fit.html", tmp_path / "fit.svg")

    largest = np.nanmax(np.abs(based.traces().residual), axis=0)
    assert (largest <= based.bounds.d).all()
    assert based.bounds.d == pytest.approx(largest, rel=1e-3)
    text = (tmp_path / "fit.html").read_text()
    assert "first-order" in text
    assert based.bounds.sentence in text


def test_a_proposed_drive_keeps_limits_and_floor(based):
    plan = propose(based, 3.0)

    assert np.hypot(*plan.path[:, :2].T).max() <= plan.farthest <= 1.5
    limits = based.scenario.limits.v_u1
    for speed, limit, fastest in zip((plan.v, plan.omega), limits, plan.fastest, strict=True):
        assert np.abs(speed).max() <= limit
        assert fastest <= limit
        assert speed[0] == speed[-1] == 0


def test_what_is_no_log_of_such_a_base_is_refused_by_name():
    log, run = drive(), simulate("turtlebot3-burger", "pid", overrides={"clock.duration": 0.1})

    for key, factor, said in (
        ("v_command [m/s]", -1.0, "one of the two has the wrong sign"),
        ("omega_measured [rad/s]", 57.3, "degrees for radians"),
    ):
        with pytest.raises(LogError, match=said):
            identify(log | {key: [factor * x for x in log[key]]}, base="velocity")
    with pytest.raises(LogError, match="--base velocity"):
        identify(log)
    with pytest.raises(ArgumentError, match="--base velocity"):
        identify(run)
    with pytest.raises(ArgumentError, match="torque, velocity"):
        identify(log, base="wheels")


@pytest.mark.slow
def test_commands_that_are_lost_are_named_where_delays_are_undetermined():
    lossy = identify(drive(lost=0.5, seconds=30.0), base="velocity")

    assert lossy.parameters["delay1"].verdict == "undetermined"
    assert any("commands were lost or came late by turns" in text for text in lossy.remarks)


@pytest.mark.slow
def test_a_pi_loop_gives_its_frequency_back_and_a_filter_for_its_family():
    axis = Axis("pi", first=4.0, zeta=0.5)

    found = identify(drive(Truth((axis, axis)), seconds=20.0), base="velocity")

    for name in ("wn1", "wn2", "zeta1", "zeta2"):
        truth = axis.first if name.startswith("wn") else axis.zeta
        assert found.parameters[name].value == pytest.approx(truth, rel=0.03), name
    assert found.bounds.loop == "pi"
    assert found.scenario.filter.loop == ("pi", "pi")
    assert found.scenario.filter.kind == "clip", found.remarks


def test_an_axis_with_a_loop_of_the_other_kind_determines_only_what_both_kinds_say():
    """The speed v follows a first-order loop, omega a second-order one; a scenario has one kind for
    both.
    """
    log = drive(Truth((Axis(), Axis("second-order", first=10.0, zeta=0.7))))

    found = identify(log, base="velocity")

    assert found.scenario.base.loop == ("second-order", "second-order")
    assert found.parameters["delay1"].low < 0.04 < found.parameters["delay1"].high
    assert all(found.parameters[name].verdict != "determined" for name in ("wn1", "zeta1"))
    assert found.parameters["wn2"].value == pytest.approx(10.0, rel=0.02)
