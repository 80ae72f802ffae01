"""A limit of the wheels' speed is judged in every plant step, as limits of v and omega are."""

from dataclasses import replace

import numpy as np
import pytest

import wmr_ctrl
from tests.control.bases import VELOCITY, based
from tests.tables import changes
from wmr_ctrl.cli.check_sentences import promise
from wmr_ctrl.cli.summary import summary_text
from wmr_ctrl.control.setup import settle
from wmr_ctrl.results import Monitor, outcome_of
from wmr_ctrl.world.scenario import load_scenario


@pytest.mark.parametrize("engine", ["native", "numpy"])
@pytest.mark.slow_but("numpy")
def test_a_wheel_beyond_its_limit_is_an_outcome(engine):
    """A wheel beyond its limit ends the run as a violation; a higher limit is kept.

    Both engines agree. Every step except the last is logged.
    """
    stated = VELOCITY | changes("""
        clock.control = 0.01
        clock.plant = 0.01
        clock.duration = 2.0
    """)
    free = wmr_ctrl.simulate(based(stated), "kanayama", engine=engine)
    rims = np.abs(free["v1"]) + 0.25 * np.abs(free["omega"])
    assert based(stated).robot.l == 0.25
    low, high = (
        wmr_ctrl.simulate(based({**stated, "filter.wheel_speed": W}), "kanayama", engine=engine)
        for W in (0.9 * rims.max(), 1.001 * rims.max())
    )

    first = int(np.argmax(rims > 0.9 * rims.max()))
    assert low.outcome.value == "limit-violated"
    assert low.monitor.first_violation == (pytest.approx(0.01 * first), 3)
    assert 0 <= low.monitor.violations - np.sum(rims > 0.9 * rims.max()) <= 1
    (told,) = (item.text for item in low.remarks if item.key == "limit-violated")
    assert f"first by the speed of a wheel (filter.wheel_speed) at t = {0.01 * first:g} s" in told
    assert high.monitor.violations == 0
    unjudged = Monitor(low.monitor.max_abs_v)  # as in runs that were saved before wheels were
    earlier = replace(low, monitor=unjudged, outcome=outcome_of(unjudged))
    shown = [" ".join(summary_text(run).split()) for run in (low, high, earlier)]
    row = f"largest of a wheel {rims[:-1].max():.4g} m/s at samples, limit"
    assert f"{row} {0.9 * rims.max():g} m/s: BROKEN" in shown[0]
    assert f"{row} {0.9 * rims.max():g} m/s: BROKEN" in shown[2]
    assert f"{row} {1.001 * rims.max():g} m/s: kept" in shown[1]
    assert high.outcome.value == "completed"


def test_check_promises_a_limit_of_the_wheels_too():
    case = load_scenario("turtlebot3-burger", {"filter.wheel_speed": 0.2})
    said = promise(settle(case, "kanayama"))
    assert "|v1| <= 0.22 m/s, |omega| <= 2.84 rad/s and wheels' speeds <= 0.2 m/s are" in said
