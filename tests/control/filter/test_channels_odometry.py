"""Odometry that comes late or not at all: its age is told, and the limit is kept."""

import numpy as np
import pytest

import wmr_ctrl
from tests.control.bases import GOVERNED, based
from tests.tables import changes
from wmr_ctrl.control.filter.channels import UNUSED
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.world.effect import EffectRole
from wmr_ctrl.world.registry import EFFECTS

AGED = [(0, 3), (2, 0), (2, 2)]
"""Samples by which odometry is late, and how many in a row may be lost."""


def aged(late, lost, **more):
    stated = {"sensor.velocity_age": 0.05 * late, "sensor.velocity_losses": lost}
    return based({**GOVERNED, **stated, **more})


def ages_shown(scenario, count):
    """Shown v1 and its age at each sample, from the sensors' graphs, where v1 is the number."""
    systems = [item.system(scenario) for item in EFFECTS.present(scenario, EffectRole.SENSOR)]
    named = [s for s in systems if any(o.signal.name in ("v1_measured",) for o in s.outputs)]
    states, rows = [np.array(s.x0) for s in named], []
    rng = np.random.default_rng(7)
    for k in range(count):
        known = {"sample": [k], "v1": [float(k)], "omega": [0.0]}
        known |= {"v1_measured": [float(k)], "omega_measured": [0.0]}
        for i, system in enumerate(named):
            graph = system.function("see", [system.update, system.y])
            given = [x for item in system.inputs for x in known[item.signal.name]]
            draws = [rng.uniform(-1, 1, 2)] if system.draws else []
            states[i], y = graph(given, states[i], system.p0, *draws)
            values = y.full().ravel().tolist()
            known |= {o.signal.name: [values[j]] for j, o in enumerate(system.outputs)}
        rows.append((known["v1_measured"][0], known["odometry_age"][0]))
    return np.array(rows).T[0], np.array(rows).T[1]


@pytest.mark.parametrize("late, lost", AGED)
@pytest.mark.slow_but("2-2")
def test_the_age_that_is_told_is_that_of_the_velocity_that_is_shown(late, lost):
    shown, age = ages_shown(aged(late, lost), 200)
    told = age >= 0
    number = np.arange(200) - np.round(age / 0.05)
    assert shown[told] == pytest.approx(number[told])
    assert age.max() == pytest.approx(0.05 * (late + lost))  # and no more in a row
    assert not told[:late].any()
    assert told[late + lost :].all()


@pytest.mark.parametrize("late, lost", AGED)
@pytest.mark.slow_but("2-2")
def test_odometry_that_is_late_or_lost_leaves_the_limit_kept(late, lost):
    far = changes("initial.pose = [-2, -2, -0.7]; base.tau = [0.2, 0.25]; base.gain = [1.1, 1.1]")
    for age in (0.0, 0.2):
        heard = aged(late, lost, **far, **{"filter.age": age})
        run = wmr_ctrl.simulate(heard, "kanayama", engine="numpy")
        unused = has(run["filter_flags"], UNUSED)
        assert run.monitor.violations == 0
        assert unused.any() if age == 0 else unused.mean() < 0.1  # the start, where late


def has(flags, bit):
    return (flags.astype(int) & bit) > 0


def test_odometry_that_is_late_on_one_axis_alone_is_refused():
    one = based(GOVERNED, "sensor.velocity_age = 0.1; gyro.enabled = true")
    with pytest.raises(ScenarioError, match=r"sensor.velocity_age: one axis.*gyro"):
        settle(one, "kanayama")
