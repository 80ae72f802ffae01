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
    *(("plant", 3, ME), ("plant", 3, CS), ("reference", 3, ME), ("nn", 3, CS)),
    *(pytest.param(law, 3, CS, marks=pytest.mark.slow) for law in ("mb", "kanayama")),
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
    u, x = np.split(point, [system.u.numel()])
    slope = system.function("J", [ca.jacobian(found, by)])
    jacobian = slope(u, x if is_plant else system.x0, system.p0)
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
def test_derivatives_are_casadis(raw, what, version, interface):
    """FMI 2 has no adjoint derivatives."""
    instance, unknowns, knowns, jacobian = setting(raw(what, version), what, interface)
    bound = 1e-12 * (1 + np.abs(jacobian).max())
    for seed in seeds(knowns):
        name = "GetDirectionalDerivative"
        status, found = call(instance, name, unknowns, knowns, seed, len(unknowns))
        assert status == OK
        assert np.abs(found - jacobian @ seed).max() <= bound
    for seed in seeds(unknowns) if version == 3 else ():
        status, found = call(instance, "GetAdjointDerivative", unknowns, knowns, seed, len(knowns))
        assert status == OK
        assert np.abs(found - seed @ jacobian).max() <= bound


def test_wrong_requests_are_refused(raw):
    """So is every request to a closed loop, which has no derivatives."""
    fmu, loop = raw("plant", 2), raw("closed-loop", 2)
    instance = fmu.new(ME).begin()

    def asked(one, unknown, knowns, *seed):
        return call(one, "GetDirectionalDerivative", [unknown], knowns, seed, 1)

    assert asked(loop.new().begin(), "x", ["robot.m"], 1.0)[0] == ERROR
    wrong = ("tau_right", "x", 1.0), ("psi", "psi", 1.0), ("psi", "der(x)", 1.0)
    for unknown, known, seed in (*wrong, ("psi", "theta", float("nan"))):
        assert asked(instance, unknown, [known], seed)[0] == ERROR
    none = (None, ct.c_size_t(1)) * 2
    assert fmu.GetDirectionalDerivative(instance.handle, *none, None, None) == ERROR
    assert asked(instance, "psi", ["theta"], 1.0) == (OK, np.array([1.0]))
    assert asked(instance, "psi", ["theta"] * 2, 1.0, 0.5) == (OK, np.array([1.5]))
