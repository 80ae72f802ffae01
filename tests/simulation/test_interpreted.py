"""The loop without a compiler."""

import numpy as np

from tests.papers_robot import paper
from tests.tables import changes
from wmr_ctrl.codegen.functions import loop_functions
from wmr_ctrl.control.setup import settle
from wmr_ctrl.simulation.interpreted import run_interpreted
from wmr_ctrl.simulation.runnable import settings_of
from wmr_ctrl.world.scenario import override


def test_it_logs_every_sample_tells_how_far_it_is_and_repeats_itself():
    scenario = override(paper(), {"clock.duration": 2.5, "disturbance.std": 0.5})
    loop, shares = loop_functions(settle(scenario, "pid")), list[float]()

    columns, monitor = run_interpreted(loop, 7, settings_of(scenario), shares.append)
    again, _ = run_interpreted(loop, 7, settings_of(scenario))

    assert len(columns["t"]) == 250
    assert shares == [0.4, 0.8]
    assert monitor.stopped is None
    assert monitor.max_abs_v[0] >= np.abs(columns["v1"]).max()
    assert all(np.array_equal(columns[name], again[name]) for name in columns)


def test_a_loop_that_diverges_stops():
    away = changes("gains.pid.Kp = [1e9, 1e9]; gains.pid.Kd = [0.0, 0.0]; clock.duration = 5.0")
    scenario = override(paper(), away)
    loop = loop_functions(settle(scenario, "pid"))

    columns, monitor = run_interpreted(loop, 0, settings_of(scenario))
    assert monitor.stopped is not None
    assert len(columns["t"]) < 500
