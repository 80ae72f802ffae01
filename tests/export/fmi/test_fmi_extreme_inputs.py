"""Inputs that no robot has, into every law's FMU and the guard's: refused, or finite outputs."""

import numpy as np
import pytest

from tests.export.fmi.cases import OTHER_LAWS, both
from tests.export.fmi.raw import DISCARD, ERROR, OK
from wmr_ctrl.core.signals import LARGEST

STEP = 0.01
every_law = pytest.mark.parametrize(
    "what, version", [("nn", 2), ("nn", 3), ("guard", 2), ("guard", 3), *OTHER_LAWS]
)


def overflow(plant):
    """A step that is undone."""
    assert plant.put({"v1": 1.7e308}) == OK
    before = plant.begin().all()
    assert plant.step(0.0, 10.0) == DISCARD
    assert plant.all() == before


@every_law
@pytest.mark.slow_but("nn-3", "guard-3")
def test_what_is_just_small_enough_gives_finite_outputs(raw, what, version):
    """Many times, in all mixtures; then the inputs of the start again."""
    fmu = raw(what, version)
    one, draw, names = fmu.new().begin(), np.random.default_rng(0), fmu.inputs
    start = one.get(*names)
    for k in range(200):
        size = LARGEST * draw.choice([0.0, 1e-12, 1e-6, 1.0], len(names))
        given = size * draw.choice([-1.0, 1.0], len(names)) if k < 100 else start
        assert one.put(dict(zip(names, map(float, given), strict=True))) == OK
        assert one.step(k * STEP, STEP) == OK
        assert np.isfinite(one.all()).all()


def test_a_step_that_overflows_is_taken_back_whole(raw):
    """States are start values, which may be any finite numbers."""
    for version in (2, 3):
        one = raw("plant", version).new()
        overflow(one)
        assert one.reset() == OK
        assert one.begin().step(0.0, STEP) == OK


UNSTABLE = {"gains.nn.sigma[1]": 1e12}
"""Forgets far more than the whole memory a sample: weights that grow without end."""


@both
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


def begins(fmu, name, *tries):
    """Assert that initialisation ends with the status that belongs to each value."""
    for value, status in tries:
        one = fmu.new()
        assert (one.put({name: value}), one.setup(), one.leave()) == (OK, OK, status)


BARRIER, MASSES = ("limits.v_u2", "limits.v_u1"), ("guard.M_min", "guard.M_max")
"""Parameters of which the first one has to be below the other, and not above the other."""


@pytest.mark.parametrize(
    "what, version, names",
    [
        ("nn", 2, BARRIER), ("prox", 3, BARRIER), ("prox", 3, MASSES), ("guard", 2, MASSES),
        ("closed-loop", 3, MASSES), ("pid", 2, MASSES),
    ],
)  # fmt: skip
@pytest.mark.parametrize("axis", [1, 2])
def test_parameters_out_of_order_are_refused_at_the_start(raw, what, version, names, axis):
    fmu = raw(what, version)
    least, most = (f"{name}[{axis}]" for name in names)
    (height,) = fmu.new().get(most)
    wrong, right, said = (1.01, 1.0, "not be above") if names == MASSES else (1.0, 0.5, "be below")
    begins(fmu, least, (2.0 * height, ERROR), (wrong * height, ERROR), (right * height, OK))
    assert sum(f"{least} = " in m and f"must {said} {most}" in m for m in fmu.messages) >= 2
