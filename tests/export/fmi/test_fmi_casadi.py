"""CasADi's own importer on our plant, and repeated writing of fixed values."""

import zipfile

import casadi as ca
import numpy as np
import pytest

from tests.export.fmi.cases import both
from tests.export.fmi.raw import CS, ERROR, OK, WARNING
from wmr_ctrl.world.model.dynamics import plant
from wmr_ctrl.world.scenario import load_scenario

GRAPH = "extra/org.wmr-ctrl/evaluate.casadi"
INPUT = {"plant": "tau_left", "nn": "v1"}


@both
def test_dae_builder_evaluates_the_plant_and_its_jacobian(exported, tmp_path, version):
    """Also at another mass.  The file has the plant's graph, which `Function.load` reads."""
    with zipfile.ZipFile(exported("plant", version)) as archive:
        archive.extractall(tmp_path)
    dae = ca.DaeBuilder("wmr_plant", str(tmp_path), {})
    rates = dae.create("rates", ["x", "u", "p"], ["ode"], {})
    x, u = [0.2, -0.1, 0.4, 0.004, -0.003], [5.0, 4.0, 0.1, 0.0, 1.0, -0.5]
    heavier = [65.0 if n == "robot.m" else dae.attribute("start", n) for n in dae.p()]
    own = plant(load_scenario("paper-simulation", {"robot.m": 65.0}))
    slope = ca.jacobian(own.update, own.x)
    wanted = ca.Function("wanted", [own.u, own.x, own.p], [own.update, slope])(u, x, own.p0)
    found = rates(x, u, heavier)

    assert np.allclose(found, wanted[0], rtol=1e-14, atol=0)
    jacobian = rates.jacobian()(x, u, heavier, found)[0]
    assert np.allclose(jacobian, wanted[1], rtol=1e-9, atol=1e-9)
    assert abs(float(jacobian[3, 3])) > 1
    assert ca.Function.load(str(tmp_path / GRAPH)).size1_out(0) > 5


@both
@pytest.mark.parametrize("what, fixed", [("plant", "robot.r"), ("nn", "limits.v_u1[1]")])
def test_a_fixed_parameter_may_be_written_again_with_its_own_value(raw, version, what, fixed):
    """GEMSEO and OpenModelica set all parameters once more; another value is named as fixed."""
    fmu = raw(what, version)
    one = fmu.new(CS).begin()
    (value,) = one.get(fixed)

    assert one.put({fixed: value, INPUT[what]: 0.25}) == WARNING
    assert one.get(fixed, INPUT[what]) == [value, 0.25]
    assert one.put({INPUT[what]: 0.5, fixed: 2 * value}) == ERROR
    assert fmu.messages[-1].startswith(f"{fixed} is fixed by now: it is {value:.17g} and cannot")
    assert one.get(fixed, INPUT[what]) == [value, 0.25]


@both
def test_the_seed_may_be_written_again_too(raw, version):
    """It is an integer, which the runtime stores as a double and returns as it was set."""
    one = raw("closed-loop", version).new()
    for seed in (5, 2**31 - 1):
        assert one.integer("Set", "seed", seed) == (OK, seed) == one.integer("Get", "seed")
    one.begin()
    assert one.integer("Set", "seed", seed)[0] == WARNING
    assert one.integer("Set", "seed", 1)[0] == ERROR
