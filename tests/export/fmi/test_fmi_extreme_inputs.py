"""Inputs that no robot has, into every law's FMU and the guard's: refused, or finite outputs."""

import ctypes as ct
import math

import numpy as np
import pytest
from fmpy import simulate_fmu
from fmpy.fmi1 import FMICallException

from tests.export.fmi.cases import OTHER_LAWS
from tests.export.fmi.raw import DISCARD, ERROR, OK
from wmr_ctrl.core.signals import LARGEST

STEP = 0.01
SIZES = (1.7e308, 1.0001 * LARGEST, math.inf, math.nan)
every_law = pytest.mark.parametrize(
    "what, version", [("nn", 2), ("nn", 3), ("guard", 2), ("guard", 3), *OTHER_LAWS]
)


def inputs_of(fmu):
    return [v.name for v in fmu.description.modelVariables if v.causality == "input"]


def overflow(plant):
    """A step that is taken back."""
    assert plant.put({"v1": 1.7e308}) == OK
    before = plant.begin().all()
    assert plant.step(0.0, 10.0) == DISCARD
    assert plant.all() == before


@every_law
@pytest.mark.slow_but("nn-2", "nn-3", "guard-2")
def test_what_is_too_large_is_refused_and_leaves_no_trace(raw, what, version):
    fmu = raw(what, version)
    plain, tried = fmu.new().begin(), fmu.new().begin()
    for k in range(4):
        for name in inputs_of(fmu):
            for size in SIZES:
                assert tried.put({name: size}) == ERROR
                assert tried.put({name: -size}) == ERROR
        for one in (plain, tried):
            assert one.step(k * STEP, STEP) == OK
        assert tried.all() == plain.all()
    plain.free()
    tried.free()


@every_law
@pytest.mark.slow_but("nn-3", "guard-3")
def test_what_is_just_small_enough_gives_finite_outputs(raw, what, version):
    """Many times, in all mixtures; then the inputs of the start again."""
    fmu = raw(what, version)
    one, draw, names = fmu.new().begin(), np.random.default_rng(0), inputs_of(fmu)
    start = one.get(*names)
    for k in range(200):
        size = LARGEST * draw.choice([0.0, 1e-12, 1e-6, 1.0], len(names))
        given = size * draw.choice([-1.0, 1.0], len(names)) if k < 100 else start
        assert one.put(dict(zip(names, map(float, given), strict=True))) == OK
        assert one.step(k * STEP, STEP) == OK
        assert np.isfinite(one.all()).all()
    one.free()


def test_a_step_that_overflows_is_taken_back_whole(raw):
    """States are start values, and may be anything finite."""
    for version in (2, 3):
        one = raw("plant", version).new()
        overflow(one)
        assert one.reset() == OK
        assert one.begin().step(0.0, STEP) == OK
        one.free()


UNSTABLE = {"gains.nn.sigma[1]": 1e12}
"""Forgets far more than the whole memory a sample: weights that grow without end."""


@pytest.mark.parametrize("version", [2, 3])
def test_a_closed_loop_that_overflows_gives_error_for_it_has_no_inputs(raw, version):
    one = raw("closed-loop", version).new()
    assert one.put(UNSTABLE) == OK
    one.begin()
    k, before, kept = 0, one.all(), one.bytes_of_state()
    while k < 1000 and (status := one.step(k * STEP, STEP)) == OK:
        k, before, kept = k + 1, one.all(), one.bytes_of_state()
    assert status == ERROR
    assert "no longer finite" in one.fmu.messages[-1]
    assert one.all() == before
    assert one.bytes_of_state() == kept
    assert one.step(k * STEP, STEP) == ERROR
    assert one.reset() == OK
    assert one.begin().step(0.0, STEP) == OK
    one.free()


def test_a_closed_loop_that_is_pushed_beyond_all_speeds_has_ended_and_says_so(raw):
    """FMI 2 asks for that by itself; 1000 m/s end it, from the first sample on."""
    one, told = raw("closed-loop", 2).new(), ct.c_int(-1)
    assert one.put({"disturbance.push[1]": 1e7}) == OK
    one.begin()
    for k, status in enumerate((DISCARD, ERROR)):
        assert one.fmu.GetBooleanStatus(one.handle, 3, ct.byref(told)) == OK
        assert told.value == k
        assert one.step(k * STEP, STEP) == status
    one.free()


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize(
    "given", [UNSTABLE, {"limits.v_u1[1]": 0.1}], ids=["not finite", "no room for the barrier"]
)
def test_fmpy_ends_where_a_closed_loop_cannot_go_on(exported, version, given):
    path = str(exported("closed-loop", version))
    with pytest.raises(FMICallException):
        simulate_fmu(path, stop_time=10, step_size=0.02, output_interval=0.02, start_values=given)


def begins(fmu, name, *tries):
    """Initialisation ends with the status that belongs to each value."""
    for value, status in tries:
        one = fmu.new()
        assert one.put({name: value}) == OK
        assert one.setup() == OK
        assert one.leave() == status
        one.free()


@pytest.mark.parametrize(
    "what, version, axis",
    [("nn", 2, 1), ("nn", 3, 2), ("pid", 2, 2), ("mb", 3, 1), ("mb", 3, 2), ("prox", 2, 2)],
)
@pytest.mark.slow_but("nn-2-1")
def test_a_barrier_without_room_is_refused_at_the_start(raw, what, version, axis):
    fmu = raw(what, version)
    limit, begin = (f"limits.v_u{i}[{axis}]" for i in (1, 2))
    if begin not in fmu.variables:
        pytest.skip("has no barrier")
    (height,) = fmu.new().get(limit)
    begins(fmu, begin, (height, ERROR), (2.0 * height, ERROR), (0.5 * height, OK))
    assert sum(f"{begin} = " in m and f"must be below {limit}" in m for m in fmu.messages) >= 2


@pytest.mark.parametrize(
    "what, version",
    [("nn", 2), ("prox", 3), ("guard", 2), ("guard", 3), ("closed-loop", 3), *OTHER_LAWS],
)
@pytest.mark.parametrize("axis", [1, 2])
def test_masses_out_of_order_are_refused_at_the_start(raw, what, version, axis):
    fmu = raw(what, version)
    least, most = (f"guard.{name}[{axis}]" for name in ("M_min", "M_max"))
    (height,) = fmu.new().get(most)
    begins(fmu, least, (1.01 * height, ERROR), (height, OK))
    assert any(f"{least} = " in m and f"must not be above {most}" in m for m in fmu.messages)
