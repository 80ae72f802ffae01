"""Every function of the standards, and the states in which the standards allow it."""

from __future__ import annotations

import ctypes as ct
from collections.abc import Callable
from dataclasses import dataclass

from tests.export.fmi.raw import CS, ME, OK, ONE, Instance, reals, refs

START, INIT, STEP, EVENT, CONTINUOUS, STOPPED = [
    "start",
    "init",
    "step",
    "event",
    "continuous",
    "stopped",
]
MODES = {CS: (START, INIT, STEP, STOPPED), ME: (START, INIT, EVENT, CONTINUOUS, STOPPED)}
ALL = {START, INIT, STEP, EVENT, CONTINUOUS, STOPPED}
RUNNING = {STEP, EVENT, CONTINUOUS}
SOLVING = {INIT, EVENT, CONTINUOUS, STOPPED}


@dataclass(frozen=True)
class Call:
    """A function, its legal states, a call, and whether only instances for model exchange have
    it.
    """

    name: str
    legal: set[str]
    make: Callable[[Instance], int]
    exchange: bool = False

    def is_legal(self, mode, interface):
        return mode in self.legal and (interface == ME or not self.exchange)


def reach(fmu, interface, mode):
    """A fresh instance in one state."""
    one = fmu.new(interface)
    if mode == START:
        return one
    assert one.setup() == OK
    if mode == INIT:
        return one
    assert one.leave() == OK
    if mode == CONTINUOUS:
        assert fmu.EnterContinuousTimeMode(one.handle) == OK
    if mode == STOPPED:
        assert fmu.Terminate(one.handle) == OK
    return one


def call(name, legal, *arguments, exchange=False):
    """A function of an instance with the same arguments each time."""
    return Call(name, legal, lambda one: getattr(one.fmu, name)(one.handle, *arguments), exchange)


def never(names, *arguments):
    """Functions that exist and are always refused."""
    return (call(name, set(), *arguments) for name in names.split())


def _vector(name, legal):
    def make(one):
        count = len(one.fmu.description.derivatives or ())
        return getattr(one.fmu, name)(one.handle, reals(*[0.0] * count), ct.c_size_t(count))

    return Call(name, legal, make, True)


def _answer(kind):
    return ct.byref(kind())


def _completed(one):
    kind = ct.c_int if one.fmu.version == 2 else ct.c_bool
    return one.fmu.CompletedIntegratorStep(one.handle, 1, _answer(kind), _answer(kind))


def _set(wanted, factor):
    """Set the first wanted variable to a multiple of its start value."""

    def make(one):
        v = next(v for v in one.fmu.variables.values() if wanted(v))
        return one.put({v.name: factor * float(v.start or 0)})

    return make


def is_fixed(v):
    return v.variability == "fixed" and v.type in ("Real", "Float64") and not v.dimensions


def is_tunable(v):
    return v.variability == "tunable"


def is_calculated(v):
    return v.causality == "output" and v.initial == "calculated"


def shared():
    """Functions that both versions have."""
    yield Call("ExitInitializationMode", {INIT}, Instance.leave)
    yield call("Terminate", RUNNING)
    yield Call("Reset", ALL, Instance.reset)
    yield Call("Get", ALL, lambda one: OK if one.all() else 3)
    yield Call("Set fixed", {START, INIT}, _set(is_fixed, 1.001))
    yield Call("Set tunable", ALL - {STOPPED}, _set(is_tunable, 1))
    yield Call("Set output", set(), _set(is_calculated, 0))
    yield Call("states", ALL, lambda one: one.restore(one.bytes_of_state()))
    yield Call("DoStep", {STEP}, lambda one: one.step(0.0, 0.01))
    yield call("EnterEventMode", {CONTINUOUS}, exchange=True)
    yield call("EnterContinuousTimeMode", {EVENT}, exchange=True)
    yield Call("CompletedIntegratorStep", {CONTINUOUS}, _completed, True)
    yield call("SetTime", {EVENT, CONTINUOUS}, ct.c_double(0.0), exchange=True)
    yield _vector("SetContinuousStates", {CONTINUOUS})
    yield _vector("GetContinuousStates", SOLVING)
    yield _vector("GetNominalsOfContinuousStates", SOLVING)
    yield call("GetEventIndicators", SOLVING, None, ct.c_size_t(0), exchange=True)


def second():
    """Calls of FMI 2: the shared ones and its own."""
    zero = ct.c_double(0)
    yield from shared()
    yield call("SetupExperiment", {START}, 0, zero, zero, 0, zero)
    yield from never("EnterInitializationMode CancelStep")
    yield _vector("GetDerivatives", SOLVING)
    yield call("NewDiscreteStates", {EVENT}, (ct.c_double * 8)(), exchange=True)
    yield call("GetRealStatus", {STEP, STOPPED}, 2, _answer(ct.c_double))
    yield call("GetBooleanStatus", {STEP, STOPPED}, 3, _answer(ct.c_int))
    yield from never("GetStatus GetIntegerStatus", 0, _answer(ct.c_int))
    yield from never("GetStringStatus", 1, _answer(ct.c_char_p))
    derivatives = "SetRealInputDerivatives GetRealOutputDerivatives"
    yield from never(derivatives, refs(1), ONE, (ct.c_int * 1)(1), reals(0.0))


def third():
    """Calls of FMI 3: the shared ones and its own."""
    yield from shared()
    yield Call("EnterInitializationMode", {START}, lambda one: one.setup())
    yield _vector("GetContinuousStateDerivatives", SOLVING)
    answers = map(_answer, [ct.c_bool] * 5 + [ct.c_double])
    yield call("UpdateDiscreteStates", {EVENT}, *answers, exchange=True)
    yield call("EvaluateDiscreteStates", {INIT, EVENT}, exchange=True)
    for name in ("GetNumberOfContinuousStates", "GetNumberOfEventIndicators"):
        yield call(name, ALL, _answer(ct.c_size_t))
    yield from never("EnterConfigurationMode ExitConfigurationMode EnterStepMode")
    yield from never("ActivateModelPartition", 1, ct.c_double(0))
    clocks = "GetClock SetClock GetShiftDecimal SetShiftDecimal SetIntervalDecimal"
    yield from never(clocks, refs(1), ONE, reals(0.0))


def calls(fmu):
    """All calls that this FMU has a variable for."""
    tunable = any(map(is_tunable, fmu.variables.values()))
    every = second() if fmu.version == 2 else third()
    return [item for item in every if tunable or item.name != "Set tunable"]
