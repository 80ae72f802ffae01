"""Every function of the standards, and the states in which the standards allow it."""

from __future__ import annotations

import ctypes as ct
from collections.abc import Callable
from dataclasses import dataclass

from tests.export.fmi.raw import CS, ME, OK, Instance, reals, refs

START, INIT, STEP, EVENT, CONTINUOUS, STOPPED = (
    "start",
    "init",
    "step",
    "event",
    "continuous",
    "stopped",
)
MODES = {CS: (START, INIT, STEP, STOPPED), ME: (START, INIT, EVENT, CONTINUOUS, STOPPED)}
ALL = {START, INIT, STEP, EVENT, CONTINUOUS, STOPPED}
RUNNING = {STEP, EVENT, CONTINUOUS}
SOLVING = {INIT, EVENT, CONTINUOUS, STOPPED}
NEVER: set[str] = set()


@dataclass(frozen=True)
class Call:
    """A function, whether only instances for model exchange have it, its legal states, a call."""

    name: str
    exchange: bool
    legal: set[str]
    make: Callable[[Instance], int]

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


def _states(one):
    return len(one.fmu.description.derivatives) if one.fmu.description.derivatives else 0


def _vector(name):
    def call(one):
        count = _states(one)
        return getattr(one.fmu, name)(one.handle, reals(*[0.0] * count), ct.c_size_t(count))

    return call


def _plain(name):
    return lambda one: getattr(one.fmu, name)(one.handle)


def _answers(name, *kinds):
    return lambda one: getattr(one.fmu, name)(one.handle, *(ct.byref(kind()) for kind in kinds))


def _completed(one):
    kind = ct.c_int if one.fmu.version == 2 else ct.c_bool
    return one.fmu.CompletedIntegratorStep(one.handle, 1, ct.byref(kind()), ct.byref(kind()))


def _indicators(one):
    return one.fmu.GetEventIndicators(one.handle, None, ct.c_size_t(0))


def _tunable(one):
    name = next(n for n, v in one.fmu.variables.items() if v.variability == "tunable")
    return one.put({name: float(one.fmu.variables[name].start)})


def _fixed(one):
    name = next(
        n
        for n, v in one.fmu.variables.items()
        if v.variability == "fixed" and v.type in ("Real", "Float64") and not v.dimensions
    )
    return one.put({name: 1.001 * float(one.fmu.variables[name].start)})


def _output(one):
    name = next(
        n
        for n, v in one.fmu.variables.items()
        if v.causality == "output" and v.initial == "calculated"
    )
    return one.put({name: 0.0})


def _roundtrip(one):
    return one.restore(one.bytes_of_state())


def _time(one):
    return one.fmu.SetTime(one.handle, ct.c_double(0.0))


def _status2(name, kind, holder):
    return lambda one: getattr(one.fmu, name)(one.handle, kind, ct.byref(holder()))


def shared():
    """Functions that both versions have."""
    yield Call("ExitInitializationMode", False, {INIT}, Instance.leave)
    yield Call("Terminate", False, RUNNING, _plain("Terminate"))
    yield Call("Reset", False, ALL, Instance.reset)
    yield Call("Get", False, ALL, lambda one: OK if one.all() else 3)
    yield Call("Set fixed", False, {START, INIT}, _fixed)
    yield Call("Set tunable", False, ALL - {STOPPED}, _tunable)
    yield Call("Set output", False, NEVER, _output)
    yield Call("states", False, ALL, _roundtrip)
    yield Call("DoStep", False, {STEP}, lambda one: one.step(0.0, 0.01))
    yield Call("EnterEventMode", True, {CONTINUOUS}, _plain("EnterEventMode"))
    yield Call("EnterContinuousTimeMode", True, {EVENT}, _plain("EnterContinuousTimeMode"))
    yield Call("CompletedIntegratorStep", True, {CONTINUOUS}, _completed)
    yield Call("SetTime", True, {EVENT, CONTINUOUS}, _time)
    yield Call("SetContinuousStates", True, {CONTINUOUS}, _vector("SetContinuousStates"))
    yield Call("GetContinuousStates", True, SOLVING, _vector("GetContinuousStates"))
    yield Call(
        "GetNominalsOfContinuousStates", True, SOLVING, _vector("GetNominalsOfContinuousStates")
    )
    yield Call("GetEventIndicators", True, SOLVING, _indicators)


def second():
    """Those of FMI 2 alone."""
    yield from shared()
    yield Call(
        "SetupExperiment",
        False,
        {START},
        lambda one: one.fmu.SetupExperiment(
            one.handle, 0, ct.c_double(0), ct.c_double(0), 0, ct.c_double(0)
        ),
    )
    yield Call("EnterInitializationMode alone", False, NEVER, _plain("EnterInitializationMode"))
    yield Call("GetDerivatives", True, SOLVING, _vector("GetDerivatives"))
    yield Call(
        "NewDiscreteStates",
        True,
        {EVENT},
        lambda one: one.fmu.NewDiscreteStates(one.handle, (ct.c_double * 8)()),
    )
    yield Call("CancelStep", False, NEVER, _plain("CancelStep"))
    yield Call(
        "GetRealStatus",
        False,
        {STEP, EVENT, CONTINUOUS, STOPPED} - {EVENT, CONTINUOUS},
        _status2("GetRealStatus", 2, ct.c_double),
    )
    yield Call(
        "GetBooleanStatus", False, {STEP, STOPPED}, _status2("GetBooleanStatus", 3, ct.c_int)
    )
    yield Call("GetStatus", False, NEVER, _status2("GetStatus", 0, ct.c_int))
    yield Call("GetIntegerStatus", False, NEVER, _status2("GetIntegerStatus", 0, ct.c_int))
    yield Call("GetStringStatus", False, NEVER, _status2("GetStringStatus", 1, ct.c_char_p))
    for name in ("SetRealInputDerivatives", "GetRealOutputDerivatives"):
        yield Call(name, False, NEVER, _input_derivatives(name))


def _input_derivatives(name):
    return lambda one: getattr(one.fmu, name)(
        one.handle, refs(1), ct.c_size_t(1), (ct.c_int * 1)(1), reals(0.0)
    )


def third():
    """Those of FMI 3 alone."""
    yield from shared()
    flags = [ct.c_bool] * 5
    yield Call("EnterInitializationMode", False, {START}, lambda one: one.setup())
    yield Call(
        "GetContinuousStateDerivatives", True, SOLVING, _vector("GetContinuousStateDerivatives")
    )
    yield Call(
        "UpdateDiscreteStates", True, {EVENT}, _answers("UpdateDiscreteStates", *flags, ct.c_double)
    )
    yield Call("EvaluateDiscreteStates", True, {INIT, EVENT}, _plain("EvaluateDiscreteStates"))
    yield Call(
        "GetNumberOfContinuousStates",
        False,
        ALL,
        _answers("GetNumberOfContinuousStates", ct.c_size_t),
    )
    yield Call(
        "GetNumberOfEventIndicators",
        False,
        ALL,
        _answers("GetNumberOfEventIndicators", ct.c_size_t),
    )
    for name in ("EnterConfigurationMode", "ExitConfigurationMode", "EnterStepMode"):
        yield Call(name, False, NEVER, _plain(name))
    for name in (
        "GetClock",
        "SetClock",
        "GetShiftDecimal",
        "SetShiftDecimal",
        "SetIntervalDecimal",
    ):
        yield Call(name, False, NEVER, _listed(name, 1))
    for name in (
        "GetIntervalDecimal",
        "GetShiftFraction",
        "SetIntervalFraction",
        "SetShiftFraction",
    ):
        yield Call(name, False, NEVER, _listed(name, 2))
    yield Call("GetIntervalFraction", False, NEVER, _listed("GetIntervalFraction", 3))
    yield Call(
        "ActivateModelPartition",
        False,
        NEVER,
        lambda one: one.fmu.ActivateModelPartition(one.handle, 1, ct.c_double(0)),
    )
    for kind in (
        "Float32",
        "Int8",
        "UInt8",
        "Int16",
        "UInt16",
        "Int32",
        "UInt32",
        "UInt64",
        "Boolean",
        "String",
    ):
        for verb in ("Get", "Set"):
            yield Call(verb + kind, False, NEVER, _typed(verb + kind))


def _listed(name, arrays):
    return lambda one: getattr(one.fmu, name)(
        one.handle, refs(1), ct.c_size_t(1), *(reals(0.0) for _ in range(arrays))
    )


def _typed(name):
    return lambda one: getattr(one.fmu, name)(
        one.handle, refs(1), ct.c_size_t(1), reals(0.0), ct.c_size_t(1)
    )


def calls(fmu):
    """All calls that this FMU has a variable for."""
    tunable = any(v.variability == "tunable" for v in fmu.variables.values())
    every = second() if fmu.version == 2 else third()
    return [call for call in every if tunable or call.name != "Set tunable"]
