import pytest

from wmr_ctrl.world.scenario import load_scenario


@pytest.fixture(scope="session")
def nominal():
    """The paper's circle without noise and without a change of parameters."""
    return load_scenario("paper-simulation-nominal")
