"""Each line of a run's text is its figure, with its unit and the verdict that follows from it."""

from contextlib import nullcontext
from dataclasses import replace

import click
import pytest

from wmr_ctrl import simulate
from wmr_ctrl.cli import console, options
from wmr_ctrl.cli.summary import summary_text
from wmr_ctrl.control.default_law import default_law
from wmr_ctrl.control.laws import LAWS
from wmr_ctrl.core.errors import WmrError
from wmr_ctrl.core.fields.units import sized
from wmr_ctrl.core.fields.values import SEED_END
from wmr_ctrl.report.run_rows import MISSING, MOST_ROWS, _small, rows_of
from wmr_ctrl.results import outcome_of
from wmr_ctrl.results import summary as figures_of
from wmr_ctrl.world.scenario import load_scenario, preset_names


@pytest.fixture(scope="module")
def run():
    changes = {"clock.duration": 4.0, "guard.enabled": True, "changes": [{"t": 2.0, "m": 40.0}]}
    return simulate(load_scenario("paper-simulation-nominal", changes), "prox", engine="numpy")


def told(run, label, settings=None, **monitor):
    """Text of a summary beside a label, after changes to the run's settings or findings."""
    seen = replace(run.monitor, **monitor)
    other = replace(
        run,
        settings=replace(run.settings, **(settings or {})),
        monitor=seen,
        outcome=outcome_of(seen, run.guard),
    )
    return "; ".join(text for name, text in rows_of(other, verbose=True) if name == label)


def test_an_error_is_tracked_up_to_the_tolerance(run):
    error = figures_of(run)["tracking"]["drive"]["position_rms"]
    words = [
        told(run, "position error", {"tolerance": share * error}) for share in (0.999, 1.0, 1.001)
    ]

    assert ["NOT TRACKED" in word for word in words] == [True, False, False]


def test_figures_name_the_robot_of_their_window(run):
    """The last quarter has only the 40 kg robot; the whole run also has the heavier one."""
    ise = figures_of(run)["ise"]

    assert ise["before"] > 9 * ise["after"]
    assert told(run, "ISE before 2 s") == f"{ise['before']:.4g}, 50 kg"
    assert told(run, "ISE from 2 s on") == f"{ise['after']:.4g}, 40 kg"
    assert "50 kg, from 2 s on 40 kg" in told(run, "position error, whole run")
    assert "last quarter (3 to 4 s: 40 kg)" in told(run, "position error")
    assert "last half (2 to 4 s: 40 kg)" in told(run, "wheel torque, change")
    robots = [{"from": 0.0, "robot": "50 kg"}, {"from": 2.0, "robot": "40 kg"}]
    assert figures_of(run)["robots"] == robots


@pytest.mark.parametrize(
    "asked, fast", [((1, 2), False), ((1.1, 2), True), ((1, 2.1), True), ((1.1, 2.1), True)]
)
def test_a_reference_is_too_fast_where_one_of_its_speeds_is(run, asked, fast):
    settings = {"usable": (1.0, 2.0), "asked": asked}

    assert ("TOO FAST" in told(run, "usable with the guard", settings)) is fast


def test_a_disturbance_is_within_its_bound_until_motion_contradicts_it(run):
    label = "disturbance, at least"

    assert "within dbar" in told(run, label)
    assert "from 3.25 s on BEYOND dbar" in told(run, label, bounds_left=(3.25, 1))


def test_what_is_beyond_a_limit_is_counted_in_steps_of_the_plant(run):
    settings = {"plant": 0.002, "control": 0.01}
    broken = {"violations": 3, "first_violation": (1.0, 1)}

    assert told(run, "beyond a limit", settings, **broken) == "3 plant steps of 0.002 s"


def test_torques_are_those_of_the_figures(run):
    figures = figures_of(run)
    least, most, change, needed = (sized(figures[key], "N m") for key in (
        "tau_rms", "tau_peak", "torque_change_rms", "torque_needed_rms"))  # fmt: skip

    assert len({least, most, change, needed}) == 4
    assert told(run, "wheel torque") == f"{least} RMS, at most {most}"
    assert told(run, "wheel torque, change").startswith(change)
    assert told(run, "wheel torque, needed").startswith(needed)


@pytest.mark.parametrize("preset", preset_names())
def test_a_run_is_told_on_one_screen_with_what_matters_for_its_base(preset):
    """The short rows are among all rows; a base that takes velocities has none about torques."""
    case = load_scenario(preset, {"clock.duration": 1.0, "metrics.split": 0.5,
                                  "metrics.rms_from": 0.2, "changes": []})  # fmt: skip
    run = simulate(case, default_law(case).name, engine="numpy")
    short, every = rows_of(run), rows_of(run, verbose=True)

    assert len(short) <= MOST_ROWS
    assert set(short) < set(every)
    assert len(summary_text(run).splitlines()) <= 24
    assert any("torque" in name for name, _ in every) is (case.base.kind == "torque")
    assert dict(short)["largest |v1|"].startswith(sized(figures_of(run)["max_abs_v"][0], "m/s"))


@pytest.mark.parametrize(
    "value, text",
    [(0.0, "0 m/s"), (12345.6, "1.235e+04 m/s"), (0.1, "0.1 m/s"), (4.91e-5, "49.1 µm/s"),
     (-0.02594, "-25.94 mm/s"), (7.5e-9, "0.0075 µm/s")],
)  # fmt: skip
def test_a_number_has_four_digits_and_a_prefix_that_fits(value, text):
    assert sized(value, "m/s") == text


@pytest.mark.parametrize(
    "value, text",
    [(None, MISSING), (0.0, "0 mm"), (5e-7, "below 0.001 mm"), (1e-6, "0.001 mm"),
     (0.25, "250 mm"), (1.5, "1.5 m")],
)  # fmt: skip
def test_errors_are_in_millimetres_below_a_metre(value, text):
    assert _small(value, "m") == text


@pytest.mark.parametrize(
    "error, code",
    [
        (click.Abort(), 130),
        (click.ClickException("x"), 2),
        (WmrError("x"), 2),
        (OSError(28, "No space left on device", "/x"), 2),
        (ZeroDivisionError("x"), 70),
    ],
)
def test_an_error_is_told_and_its_traceback_only_where_it_is_asked_for(error, code, capsys):
    with pytest.raises(type(error)) as caught:
        raise error
    for debug in (False, True):
        assert console.explain(caught.value, debug=debug) == code
        assert ("Traceback" in capsys.readouterr().err) is debug


def test_text_from_outside_cannot_command_the_terminal():
    assert console.wrapped("a\x1b[31m\x07b\u202e c") == "a [31m b c"


@pytest.mark.parametrize(
    "seed, good",
    [("-1", False), ("0", True), (str(SEED_END - 1), True), (str(SEED_END), False)],
)
def test_a_seed_is_from_zero_up_and_below_its_end(seed, good):
    with nullcontext() if good else pytest.raises(click.UsageError, match=f"below {SEED_END}"):
        assert options._seed(None, None, seed) == int(seed)


def test_laws_are_named_once_each_in_the_order_in_which_they_were_given():
    """Also in combination with "all"; a law that does not exist is refused later."""
    assert options._each_law(None, None, ["prox, pid", "mb,prox"]) == ("prox", "pid", "mb")
    every = tuple(dict.fromkeys(["mb", "typo", *LAWS]))
    assert options._each_law(None, None, ["mb", "typo, all"]) == every
