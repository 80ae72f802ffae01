"""The clip of linear loops: its peak gain against quadrature, and against the worst commands."""

import re

import flint
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.signal import lti, step

from benchmarks.filter_trials.linear_base import second_order_base
from tests.tables import cases, changes
from wmr_ctrl import command_filter, load_scenario
from wmr_ctrl.control.filter.enclosure import Span
from wmr_ctrl.control.filter.peak_gain import (
    PiLoop,
    _arc,
    _gain_bound,
    _push_bound,
    largest,
    less_damped,
    overshoot,
    peak_gains,
    second_order,
)
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.world.scenario import override

WIDE = {"mass": (50.0, 65.0), "kp": (135.0, 165.0), "ki": (270.0, 330.0), "friction": (0.0, 20.0)}
LOOP = PiLoop((50.0, 65.0), (135.0, 165.0), (270.0, 330.0), (0.0, 20.0))
PUSH = 10.0


def scenario(**stated):
    """The family "wide" on both axes, whose inertia is as heavy at the rim as its mass."""
    given = {"kind": "clip", "loop": "pi", "inertia": (50 / 16, 65 / 16), "push": (PUSH, 0.0)}
    keys = changes("""
        limits.v_u1 = [1.0, 1.0]
        limits.v_u2 = [0.7, 0.7]
        clock.control = 0.05
    """)
    return load_scenario(
        "paper-simulation",
        keys | {f"filter.{name}": value for name, value in (WIDE | given | stated).items()},
    )


def variation(base, column):
    """Integral of the impulse response's size, by the trapezoidal rule."""
    slowest = -np.linalg.eigvals(base.A).real.max()
    times = np.linspace(0, 25 / slowest, 20001)
    return float(np.trapezoid(np.abs(base.impulse(column, times)), times))


def test_a_bound_of_an_arc_is_less_by_the_next_term_of_its_series():
    q = np.array([1e-3, 0.1, 0.3])
    less = np.arcsin(q) / q - _arc(Span.of(q**2))
    assert ((less >= -1e-15) & (less <= 0.04 * q**8 + 1e-15)).all()


def test_a_box_that_is_done_with_counts_while_others_are_halved():
    def bound(x, y):
        return np.where(x.hi < 2, 1.0, 0.3 + 2 * (y.hi - y.lo))

    boxes = Span(np.array([0.0, 2.0]), np.array([1.0, 3.0]))
    assert largest(bound, boxes, boxes) == 1.0


shares = st.floats(0, 1)


@pytest.mark.parametrize("z", [0.1, 0.7, 0.999, 1.0, 1.3, 4.0])
@pytest.mark.slow_but("0.7", "1.3")
def test_peak_gain_of_second_order_loops_is_that_of_quadrature(z):
    base, peak = second_order_base(3.0, z, 1.1), second_order(z, 1.1, 0.2)
    assert variation(base, base.b) == pytest.approx(peak.gain, rel=2e-4)
    assert 0.2 * variation(base, base.e) == pytest.approx(peak.push, rel=2e-4)


@pytest.mark.parametrize(
    "stated, words",
    cases("""
        filter.ki = [330, 270]                                | wrong way round
        filter.ki = [0, 330]                                  | filter.ki
        filter.kind = governor; filter.tau = [0.2, 0.3]       | responds at once
        filter.gain = [0.9, 1.1]                              | reaches its command at rest
        filter.push = [110, 0]                                | alone drives the base to 1.07
        filter.channels = wheels                              | different masses
        filter.loop = second-order                            | filter.damping is missing
        filter.loop = second-order; filter.damping = [1e-160, 0.05]; filter.push = [0, 0] \
                                                      | v to any speed .* State filter.damping
    """),
)
def test_what_cannot_be_met_is_refused(stated, words):
    with pytest.raises(ScenarioError, match=words):
        command_filter(override(scenario(), changes(stated)))
    with pytest.raises(ScenarioError, match=r"filter\.kp is missing"):
        command_filter(scenario(kp=None))


def test_the_parameters_are_the_peak_gain_and_what_pushes_lead_to():
    system = command_filter(scenario()).system
    found = {item.signal.name: item.value for item in system.params}
    peak = LOOP.peak(PUSH)
    assert found["filter.peak_gain"] == pytest.approx((peak.gain, peak.gain), rel=1e-5)
    assert found["filter.delta"] == pytest.approx((peak.push, 0.0), abs=1e-12)


@pytest.mark.parametrize("z", [0.2, 0.45, 0.8, 1.0, 1.6])
@pytest.mark.slow_but("0.45", "1.0")
def test_overshoot_is_that_of_a_step_and_its_price_that_of_less_damping(z):
    def of(z):
        stated = {"loop": "second-order", "damping": (z, 2.0), "frequency": (3.0, 4.0)}
        return scenario(**stated, push=(0.0, 0.0))

    share, _ = overshoot(of(z))
    _, S = step(lti([1], [1, 2 * z, 1]), T=np.linspace(0, 40, 40001))
    assert share == pytest.approx(max(S.max() - 1, 0), abs=1e-6)
    less = z * less_damped(of(z), 0, 0.01)
    assert overshoot(of(less))[0] == pytest.approx(share + 0.01, abs=1e-9)


def test_overshoot_of_a_pi_loop_is_that_of_its_worst_corner():
    share, _ = overshoot(scenario())
    _, S = step(lti([135, 330], [65, 135, 330]), T=np.linspace(0, 20, 20001))
    assert share == pytest.approx(S.max() - 1, abs=1e-6)


@pytest.mark.parametrize("name, end, stated", [
    ("damping", 0, {"loop": "second-order", "damping": (1e-4, 1.0)}),
    pytest.param("kp", 0, {"kp": (0.1, 165.0)}, marks=pytest.mark.slow),
    pytest.param("mass", 1, {"mass": (1.0, 1e6)}, marks=pytest.mark.slow),
])  # fmt: skip
def test_a_loop_that_hardly_damps_is_refused_and_what_is_advised_is_enough(name, end, stated):
    stated = {"push": (0.0, 0.0), **stated}
    with pytest.raises(ScenarioError, match=r"N <= 100 .*is") as error:
        command_filter(scenario(**stated))
    advised = list(stated[name])
    words = rf"filter\.{name}\[{end + 1}\] of at (?:least|most) (\S+),"
    advised[end] = float(re.search(words, str(error.value))[1])
    better = scenario(**stated | {name: tuple(advised)})

    assert command_filter(better).step((1.0, 1.0)).command[0] > 0
    assert 90 < max(item.gain for item in peak_gains(better)) <= 100


def test_a_push_that_only_rounding_stops_is_told_with_digits_that_differ():
    told = changes("filter.kind = clip; filter.d = [0.999999999999, 0]; limits.v_u1 = [1, 2]")
    words = (
        r"to 0\.999999999999, which must be below limits\.v_u1\[1\] less 1\.5e-8 of it"
        r".*0\.999999985.*State a push below 0\.99, or a limit above 1\.01\."
    )
    with pytest.raises(ScenarioError, match=words):
        command_filter(load_scenario("paper-simulation", told))


def test_a_push_beyond_the_limit_is_told_with_the_largest_that_is_below():
    with pytest.raises(ScenarioError, match=r"State a push below \S+, or a limit above") as error:
        command_filter(scenario(push=(500.0, 0.0)))
    most = float(str(error.value).split("push below ")[1].split(",")[0])
    assert command_filter(scenario(push=(0.98 * most, 0.0))).step((1.0, 0.0)).command[0] > 0


def exact_gain(b, drag):
    """N of one PI loop in balls, b = kp/sqrt(ki M) and drag = c/sqrt(ki M)."""
    b, drag = flint.arb(b), flint.arb(drag)
    z = (b + drag) / 2
    y, w = b * z - 1, abs(1 - z * z).sqrt()
    rho = (y * y + (b * w) ** 2 if z < 1 else y * y - (b * w) ** 2).sqrt()
    if z < 1:
        t0 = flint.arb.atan2(b * w, y) / w
        return 1 + 2 * rho * (-z * t0).exp() / (1 - (-flint.arb.pi() * z / w).exp())
    if not y > b * w:
        return flint.arb(1)
    return 1 + 2 * rho * (-z * ((b * w / y).atanh() / w)).exp()


def exact_push(k, s):
    """Largest velocity [m/s] that pushes up to 1 N can cause; k = kp + c and s = sqrt(ki M)."""
    k, s = flint.arb(k), flint.arb(s)
    z = k / (2 * s)
    w = abs(1 - z * z).sqrt()
    if z < 1:
        left = (-flint.arb.pi() * z / w).exp()
        return 2 * (-z * z.acos() / w).exp() / (1 - left) / s
    return 2 * (-z * (z + w).log() / w).exp() / s


@pytest.mark.parametrize("family", [
    ((80.0, 96.0), (140.0, 160.0), (280.0, 320.0), (0.0, 0.0)),
    ((50.0, 50.0), (150.0, 150.0), (300.0, 300.0), (0.0, 0.0)),
    ((0.9, 1.1), (1.79, 2.2), (0.9, 1.1), (0.0, 0.3)),
    ((1.0, 1.2), (4.0, 5.0), (1.0, 1.1), (1.0, 10.0)),
    ((50.0, 60.0), (150.0, 165.0), (300.0, 320.0), (20.0, 40.0)),
    ((1.0, 1.0), (1.9985, 1.9985), (1.0, 1.0), (0.0, 0.0)),
    ((1.0, 1.0), (1.6, 1.6), (1.0, 1.0), (0.401, 0.401)),
])  # fmt: skip
def test_the_search_ends_where_the_corner_is_that_is_known_to_be_the_worst(family):
    """The peaks are those of the worst corner, also for boxes with sides of length 0.

    The least friction of the box is taken into account.
    """
    M, kp, ki, c = family
    found = PiLoop(*family).peak(1.0)
    with flint.ctx.workprec(200):
        s, least = (ki[1] * M[1]) ** 0.5, (ki[0] * M[0]) ** 0.5
        N, P = exact_gain(kp[0] / s, c[0] / s), exact_push(kp[0] + c[0], least)
        assert N * 0.9999999 <= found.gain <= N * (1 + flint.arb(2) ** -14)
        assert P * 0.9999999 <= found.push <= P * (1 + flint.arb(2) ** -14)


sizes = st.floats(0.02, 4.0)


@pytest.mark.parametrize("bound, exact", [(_gain_bound, exact_gain), (_push_bound, exact_push)])
@settings(max_examples=150, deadline=None)
@given(sizes, sizes, shares, shares, st.floats(-12, 0))
@pytest.mark.slow_but("_push_bound-exact_push")
def test_bounds_of_boxes_hold_every_member(bound, exact, x, y, i, j, width):
    """Boxes of every size, with z beside, near and across 1, against balls of 200 bits."""
    share = 10.0**width
    box = [Span.of(np.array([v]), np.array([v * (1 + share)])) for v in (x, y)]
    assume(abs(x + y - 2) > 1e-9)
    assume(abs(x - 2 * y) > 1e-9)  # the formulas' own gap at z = 1
    member = [min(v * (1 + share * part), v * (1 + share)) for v, part in ((x, i), (y, j))]
    with flint.ctx.workprec(200):
        assert flint.arb(float(bound(*box)[0])) >= exact(*member)
