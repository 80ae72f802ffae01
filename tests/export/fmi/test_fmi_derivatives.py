"""Directional and adjoint derivatives against CasADi's Jacobian of the same System."""

import ctypes as ct

import casadi as ca
import numpy as np
import pytest

from tests.export.fmi.raw import CS, ERROR, ME, OK, reals, refs
from wmr_ctrl.control.controller import asking_controller
from wmr_ctrl.control.setup import settle
from wmr_ctrl.world.model.dynamics import plant
from wmr_ctrl.world.references.kind import reference
from wmr_ctrl.world.scenario import load_scenario

SCENARIO = load_scenario("paper-simulation")
FMI2 = [("plant", 2, ME), ("nn", 2, CS)]
FMI3 = [
    ("plant", 3, ME),
    ("plant", 3, CS),
    ("reference", 3, ME),
    ("nn", 3, CS),
    pytest.param("mb", 3, CS, marks=pytest.mark.slow),
    pytest.param("kanayama", 3, CS, marks=pytest.mark.slow),
]


def system_of(what):
    if what in ("plant", "reference"):
        return {"plant": plant, "reference": reference}[what](SCENARIO)
    return asking_controller(settle(SCENARIO, what))


def setting(fmu, what, interface):
    """An instance at a random point, names of unknowns and knowns, and CasADi's Jacobian there."""
    system, is_plant, instance = system_of(what), what == "plant", fmu.new(interface)
    states = [p.signal.name for p in system.state] if is_plant else []
    knowns = [*(n for p in system.inputs for n in p.signal.elements), *states]
    point = np.random.default_rng(0).uniform(-0.4, 0.4, len(knowns)).round(3)
    if what == "reference":
        knowns, point = ["time"], np.zeros(1)
    else:
        instance.put(dict(zip(knowns, point.tolist(), strict=True)))
    results = [*system.outputs, *system.diagnostics]
    unknowns = [*(f"der({n})" for n in states), *(n for o in results for n in o.signal.elements)]
    found = ca.vertcat(*[system.update] * is_plant, *(item.expr for item in results))
    by = ca.vertcat(system.u, system.x) if is_plant else system.u
    f = ca.Function("J", [system.u, system.x, system.p], [ca.jacobian(found, by)])
    u, x = np.split(point, [system.u.numel()])
    jacobian = f(u, x if is_plant else system.x0, system.p0)
    return instance.begin(), unknowns, knowns, np.array(jacobian)


def call(instance, name, unknowns, knowns, seed, count):
    found = reals(*[0.0] * count)
    fmu = instance.fmu
    lists = [(refs(*map(fmu.ref, group)), ct.c_size_t(len(group))) for group in (unknowns, knowns)]
    given = (
        (reals(*seed), found)
        if fmu.version == 2
        else (reals(*seed), ct.c_size_t(len(seed)), found, ct.c_size_t(count))
    )
    status = getattr(fmu, name)(instance.handle, *lists[0], *lists[1], *given)
    return status, np.array(found[:])


def seeds(names):
    """One unit vector for each of the names, and a random vector."""
    return (*np.eye(len(names)), np.random.default_rng(1).normal(size=len(names)))


@pytest.mark.parametrize("what, version, interface", FMI2 + FMI3)
@pytest.mark.slow_but("plant-2-ModelExchange", "reference-3-ModelExchange", "nn-2-CoSimulation")
def test_directional_derivatives_are_casadis(raw, what, version, interface):
    instance, unknowns, knowns, jacobian = setting(raw(what, version), what, interface)
    name = "GetDirectionalDerivative"
    for seed in seeds(knowns):
        status, found = call(instance, name, unknowns, knowns, seed, len(unknowns))
        assert status == OK
        assert np.abs(found - jacobian @ seed).max() <= 1e-12 * (1 + np.abs(jacobian).max())


@pytest.mark.parametrize("what, version, interface", FMI3)
def test_adjoint_derivatives_are_casadis(raw, what, version, interface):
    """FMI 2 has none."""
    instance, unknowns, knowns, jacobian = setting(raw(what, version), what, interface)
    for seed in seeds(unknowns):
        status, found = call(instance, "GetAdjointDerivative", unknowns, knowns, seed, len(knowns))
        assert status == OK
        assert np.abs(found - seed @ jacobian).max() <= 1e-12 * (1 + np.abs(jacobian).max())


def test_wrong_requests_are_refused(raw):
    instance = raw("plant", 2).new(ME).begin()
    name = "GetDirectionalDerivative"
    assert call(instance, name, ["tau_right"], ["x"], [1.0], 1)[0] == ERROR
    assert call(instance, name, ["psi"], ["psi"], [1.0], 1)[0] == ERROR
    assert call(instance, name, ["psi"], ["der(x)"], [1.0], 1)[0] == ERROR
    assert call(instance, name, ["psi"], ["theta"], [float("nan")], 1)[0] == ERROR
    assert (
        instance.fmu.GetDirectionalDerivative(
            instance.handle, None, ct.c_size_t(1), None, ct.c_size_t(1), None, None
        )
        == ERROR
    )
    assert call(instance, name, ["psi"], ["theta"], [1.0], 1) == (OK, np.array([1.0]))
    assert call(instance, name, ["psi"], ["theta"] * 2, [1.0, 0.5], 1) == (OK, np.array([1.5]))


def test_a_closed_loop_has_none(raw):
    instance = raw("closed-loop", 2).new().begin()
    assert call(instance, "GetDirectionalDerivative", ["x"], ["robot.m"], [1.0], 1)[0] == ERROR
