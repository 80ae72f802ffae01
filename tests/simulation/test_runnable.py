"""The Run from an engine's results."""

import numpy as np

from tests.papers_robot import paper
from tests.tables import changes
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.signals import LOG_HEAD
from wmr_ctrl.results import Monitor
from wmr_ctrl.simulation.runnable import assemble_run, provenance, settings_of, versions
from wmr_ctrl.world.scenario import loads_scenario, override


def test_a_run_carries_its_scenario_and_who_made_it():
    scenario = override(paper(), {"clock.duration": 0.1, "robot.m": 47.0})
    columns = {s.name: np.full((10, s.size) if s.size > 1 else 10, 0.5) for s in LOG_HEAD}
    log = LOG_HEAD, {**columns, "t": np.arange(10) * 0.01}, Monitor((0.5, 0.5))
    told = settle(scenario, "mb").assumptions
    run = assemble_run(scenario, "mb", 7, "native", log, {"kernel_hash": "x"}, told)

    assert (run.law, run.seed, run.engine) == ("mb", 7, "native")
    assert run.provenance["kernel_hash"] == "x"
    assert run.provenance["version"] == versions()["version"]
    text = provenance(scenario)["scenario_toml"]
    assert "#" not in text
    assert loads_scenario(text, scenario.name) == scenario


def test_settings_are_the_scenarios():
    found = settings_of(
        override(
            paper(),
            changes("""
            clock.duration = 8.0; body.radius = 0.3; metrics.tolerance = 0.2; metrics.rms_from = 7.0
            reference.keep_out = [[5.0, 5.0, 1.0]]
        """),
        )
    )

    assert (found.duration, found.split, found.radius) == (8.0, 4.0, 0.3)
    assert (found.tolerance, found.rms_from, found.keep_out) == (0.2, 7.0, ((5.0, 5.0, 1.0),))
