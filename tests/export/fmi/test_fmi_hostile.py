"""Calls that no importer should make: refused with a sentence, and nothing else happens."""

import ctypes as ct
import math
from itertools import pairwise, product

import pytest
from fmpy.fmi3 import fmi3IntermediateUpdateCallback
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.export.fmi.cases import FMUS
from tests.export.fmi.raw import CS, ERROR, ME, OK, ONE, REFUSED, WARNING, reals, refs
from tests.export.fmi.sequences import MODES, calls, reach
from tests.export.fmi.test_fmi_extreme_inputs import begins, overflow
from wmr_ctrl.core.signals import LARGEST

full = pytest.mark.parametrize("what, version", [*product(("plant", "nn"), (2, 3))])
everywhere = pytest.mark.parametrize("what, version", FMUS)
NAN, INF = math.nan, math.inf
STATE = ("x", "y", "theta", "v1", "omega", "psi")


@full
@pytest.mark.slow_but("plant-2", "plant-3")
def test_every_function_in_every_state(raw, what, version):
    """Legal calls succeed, others are refused; afterwards the instance can be reset and used."""
    fmu = raw(what, version)
    for interface in fmu.interfaces:
        for call in calls(fmu):
            for mode in MODES[interface]:
                one = reach(fmu, interface, mode)
                fmu.messages.clear()
                status = call.make(one)
                where = f"{call.name} in {mode} ({interface}): {status}"
                if call.is_legal(mode, interface):
                    assert status == OK, where
                else:
                    assert status in REFUSED, where
                    assert fmu.messages, where
                assert one.reset() == OK
                one.begin().free()


@pytest.mark.parametrize(
    "what, version",
    [("reference", 2), ("closed-loop", 3), ("plant", 2), ("guard", 3), ("nn", 3), ("kanayama", 2)],
)
@pytest.mark.slow_but("reference-2", "closed-loop-3")
def test_bad_steps(raw, what, version):
    """Invalid sizes and times are refused immediately, and the next valid step is taken."""
    fmu = raw(what, version)
    one = fmu.new().begin(stop=1.0)
    before = one.all()
    steps = [(0.0, h) for h in (0.0, -0.01, NAN, INF, -INF, 1e300, 1.1)]
    steps += [(t, 0.01) for t in (NAN, INF, 0.5, -0.01, 1e-6)]
    for t, h in steps:
        assert one.step(t, h) in REFUSED, (t, h)
    assert one.all() == before
    assert fmu.new().begin().step(0.0, 1e9) in REFUSED
    assert one.step(0.0, 0.01) == OK
    assert one.step(0.01 * (1 + 1e-12), 0.01) == OK
    assert one.step(0.02, 1.0) in REFUSED


@everywhere
def test_numbers_that_are_none_and_values_out_of_range(raw, what, version):
    fmu = raw(what, version)
    one, same = fmu.new().begin(), fmu.new().begin()
    before = one.all()
    for name, v in fmu.variables.items():
        if v.type == fmu.real and not v.dimensions and v.causality in ("input", "parameter"):
            most = float(v.max or LARGEST)
            for wrong in (NAN, INF, -INF, most * 1.1 + 1, float(v.min or -most) * 1.1 - 1):
                assert one.put({name: wrong}) == ERROR, name
    assert one.all() == before
    assert one.step(0.0, 0.01) == same.step(0.0, 0.01) == OK
    assert one.all() == same.all()


@everywhere
def test_unknown_references_wrong_types_and_missing_places(raw, what, version):
    fmu = raw(what, version)
    one = fmu.new().begin()
    for wrong in (2**32 - 1, 100_000):
        assert one.get_refs([wrong])[0] == one.put_refs([wrong], [0.0]) == ERROR
    length = fmu.length(1)
    for kind in (fmu.real, fmu.int64, "Boolean", "String", *["Int32"] * len(length)):
        for verb in ("Get", "Set"):
            call = getattr(fmu, verb + kind)
            assert call(one.handle, None, ONE, reals(0.0), *length) == ERROR, kind
            assert call(one.handle, refs(1), ONE, None, *length) == ERROR, kind
            assert call(one.handle, None, ct.c_size_t(0), None, *fmu.length(0)) == OK, kind
    integer = getattr(fmu, f"Get{fmu.int64}")
    assert integer(one.handle, refs(1), ONE, reals(0.0), *length) == ERROR
    for verb in ("Get", "Free", "Set"):
        assert one.of_state(verb, None) == ERROR
    assert one.of_state("Serialized", None, None, end="Size") == ERROR
    assert one.of_state("Serialize", None, None, ct.c_size_t(0)) == ERROR
    if version == 3:
        nowhere = [None] * 4
        assert fmu.DoStep(one.handle, ct.c_double(0), ct.c_double(0.01), True, *nowhere) == ERROR
    assert one.step(0.0, 0.01) == OK
    for category, status in ((None, ERROR), (b"no such category", ERROR), (b"logEvents", OK)):
        named = category and (ct.c_char_p * 1)(category)
        assert fmu.SetDebugLogging(one.handle, 1, ONE, named) == status


@everywhere
def test_wrong_instances_and_experiments(raw, what, version):
    """No name, another token, invalid times: the logger receives the reason."""
    fmu = raw(what, version)
    deaf = {"callbacks": None} if version == 2 else {"log": None}
    wrong = {"token": b"{other}"}, {"token": None}, {"name": None}, {"name": b""}
    for given_ in (*wrong, *[{"events": True}] * (version == 3)):
        fmu.messages.clear()
        assert not fmu.instantiate(**given_)
        assert fmu.messages
        assert not fmu.instantiate(**given_, **deaf)
    if ME not in fmu.interfaces:
        assert not fmu.instantiate(ME)
    assert fmu.Terminate(None) == ERROR
    fmu.FreeInstance(None)
    for given_ in (deaf, {"resources": None}):
        one = fmu.new(**given_)
        assert one.step(0.0, 0.01) == ERROR
        assert one.begin().step(0.0, 0.01) == OK
        one.free()
    starts = {"start": NAN}, {"start": INF}, {"stop": NAN}, {"start": 1.0, "stop": 0.5}
    for given_ in (*starts, {"tolerance": NAN}, {"tolerance": -1.0}):
        one = fmu.new()
        assert one.setup(**given_) == ERROR
        assert one.reset() == OK
        one.begin().free()
    assert fmu.new().setup(1.0, 1.0) == OK  # it ends where it begins


def test_a_plant_step_too_short_for_a_closed_loop_is_refused(raw):
    """More than 1e5 plant steps in a period, or not a whole number of them."""
    for version in (2, 3):
        fmu = raw("closed-loop", version)
        wrong, right = (0.01 / 2e5, 0.004, 0.02), (0.01, 0.01 / 1e4)
        begins(fmu, "clock.plant", *product(wrong, [ERROR]), *product(right, [OK]))


@pytest.mark.parametrize("version, rest", [(2, 5e-6), (3, 5e-6), (2, 5e-4)])
def test_a_rest_of_a_step_is_a_step_however_short(raw, version, rest):
    found = []
    for times in ([0.0, 0.01 + rest], [0.0, 0.01, 0.01 + rest], [0.0, 0.01]):
        one = raw("plant", version).new().begin()
        assert one.put({"tau_right": 2.0, "tau_left": 1.0}) == OK
        assert {one.step(start, end - start) for start, end in pairwise(times)} == {OK}
        found.append(one.get(*STATE))
    assert found[0] == pytest.approx(found[1], rel=1e-9)
    assert found[0][3] > found[2][3] > 0


def test_states_of_solvers_must_be_numbers(raw):
    for version in (2, 3):
        fmu = raw("plant", version)
        one = reach(fmu, ME, "continuous")
        for given_, size in ((reals(0, 0, NAN, 0, 0), 5), (reals(0, 0), 2), (None, 5)):
            assert fmu.SetContinuousStates(one.handle, given_, ct.c_size_t(size)) in REFUSED
        assert fmu.SetTime(one.handle, ct.c_double(INF)) == ERROR
        assert any("state 3 is not finite" in text for text in fmu.messages)
        assert fmu.GetContinuousStates(one.handle, reals(*[0] * 4), ct.c_size_t(4)) == ERROR


@full
@settings(max_examples=3 * settings.default.max_examples // 2)
@given(script=st.lists(st.integers(0, 10_000), max_size=25))
@pytest.mark.slow_but("nn-2")
def test_any_sequence_of_calls_ends_in_order(raw, what, version, script):
    """For any calls in any order: a status, and an instance that works after a reset."""
    fmu = raw(what, version)
    listed = calls(fmu)
    interface = fmu.interfaces[script[0] % len(fmu.interfaces)] if script else CS
    one = reach(fmu, interface, MODES[interface][len(script) % len(MODES[interface])])
    for number in script:
        assert listed[number % len(listed)].make(one) in (OK, WARNING, *REFUSED)
    assert one.reset() == OK
    one.begin()
    assert one.get("time") == [0.0]


def test_intermediate_updates_and_early_returns(raw):
    """FMI 3: each internal step is reported; a requested return happens there."""
    seen, held = [], []

    @fmi3IntermediateUpdateCallback
    def update(_env, time, _put, _get, _done, _may, early, until):
        one = held[-1]
        legal = one.fmu.SetDebugLogging(one.handle, 0, ct.c_size_t(0), None)
        assert (one.get("time"), one.step(0.0, 0.01), legal) == ([time], ERROR, OK)
        seen.append(time)  # a failure is not told from here, but its time is missing then
        early[0] = len(seen) in (1, 2)  # which counts for nothing where it may not
        until[0] = time + (len(seen) == 1)

    def hearing(what, **given_):
        seen.clear()
        held.append(raw(what, 3).new(update=update, **given_))
        return held[-1]

    for what, h, wanted in (("plant", 0.0105, 10), ("nn", 0.05, 4), ("closed-loop", 0.05, 4)):
        assert hearing(what).begin().step(0.0, h) == OK
        assert len(seen) == wanted
        one = hearing(what, early=True).begin()
        # At the first one a return is asked for at a later time.
        assert one.stepped(0.0, h) == (OK, False, False, True, seen[1])
        assert one.get("time") == seen[1:]
        assert one.step(seen[1], h) == OK
    overflow(hearing("plant"))  # a step that is taken back after it was shown
