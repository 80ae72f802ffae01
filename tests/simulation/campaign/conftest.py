"""Synthetic runs of 80 s that are quick to make and differ by scenario, law and seed."""

import pytest

from tests.simulation.campaign.synthetic import made_up, simulate
from wmr_ctrl.simulation.campaign.engine import run_campaign
from wmr_ctrl.simulation.campaign.paper_runs import paper_plan


@pytest.fixture(scope="session")
def fake_simulate():
    return simulate


@pytest.fixture(scope="session")
def campaign():
    with made_up():
        return run_campaign(paper_plan(seeds=2), jobs=1)
