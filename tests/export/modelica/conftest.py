"""The package as text, and compilers that read it."""

import numpy as np
import pytest

from wmr_ctrl.export.modelica import FILE, modelica_package
from wmr_ctrl.world.scenario import load_scenario


@pytest.fixture(scope="session")
def text():
    """The package of the paper's circle without noise or change."""
    return modelica_package(load_scenario("paper-simulation-nominal"))


@pytest.fixture(scope="session")
def simulated():
    """A function (text, model, end) -> columns: at each multiple of 10 ms, after its sample."""
    rumoca = pytest.importorskip("rumoca", reason="NOT RUN: rumoca is not there")

    def simulate(text, model, end):
        compiled = rumoca.Session().loads(text, model=model, filename=FILE)
        solver = rumoca.SimConfig(solver="rk-like", rtol=1e-8, atol=1e-10, max_wall_seconds=300.0)
        result = compiled.simulate(t=(0.0, end), dt=0.01, config=solver)
        times = np.arange(round(end / 0.01)) * 0.01
        rows = np.searchsorted(np.asarray(result.time), times + 1e-6) - 1
        return {name: np.asarray(result[name])[rows] for name in result.names}

    return simulate
