"""The checker shares no code with the computation.  It accepts what that states, and rejects bounds
that are too small.
"""

from dataclasses import fields, replace

import casadi as ca
import numpy as np
import pytest
from flint import arb, ctx

from tests.corridor.further import burger
from tests.papers_robot import safe
from tests.tables import cases, changes
from wmr_ctrl.control.setup import settle
from wmr_ctrl.theory.corridor import find_corridor
from wmr_ctrl.world.scenario import load_scenario
from wmr_proofs.corridor import stated
from wmr_proofs.corridor.along import Along
from wmr_proofs.corridor.certificate import Certifier
from wmr_proofs.corridor.following import Following
from wmr_proofs.corridor.inputs import NoCorridorError, bounded_inputs
from wmr_proofs.corridor.instant import RunBounds
from wmr_proofs.corridor.latch import DUST, latch_of
from wmr_proofs.corridor.latch import LARGER as LARGER_BOXES
from wmr_proofs.corridor.passage import Passing
from wmr_proofs.corridor.peaks import Tube
from wmr_proofs.corridor_check import check as checker
from wmr_proofs.corridor_check.certificate import Certificate
from wmr_proofs.corridor_check.check import check, in_the_long_run, latched
from wmr_proofs.corridor_check.graphs import Graph
from wmr_proofs.corridor_check.intervals import RULES, RefusedError

FREE = {"guard.enabled": False}
NOISY = {**FREE, "sensor.velocity_noise": [0.002, 0.004]}
CASES = {
    "prox": ("safe-simulation", "prox", {}),
    "mb": ("safe-simulation", "mb", {}),
    "an observer, velocities with noise": ("safe-simulation", "kanayama", NOISY),
    "a base with a dead band": ("irobot-create3", "kanayama", {}),
    "a start": ("safe-simulation", "prox", {"corridor.start": [0.002, 0.002, 0.02]}),
    "jitter": ("safe-simulation", "prox", {**FREE, "actuator.jitter": 0.003}),
    "a lag": ("safe-simulation", "prox", {**FREE, "actuator.lag": 0.01}),
    "late commands behind the guard": ("safe-simulation", "prox", {"actuator.delay": 0.02}),
    "rare poses": ("safe-simulation", "prox", {"sensor.pose_period": 0.05}),
    "another friction": ("far-start-friction-overestimated", "kanayama", {}),
    "estimated poses": ("safe-simulation", "mb", {"sensor.correction": 0.4, "disturbance.std": 0.2,
                                                  "sensor.pose_noise": 1e-5}),
}  # fmt: skip
DEFAULT = tuple(case for case in CASES if case != "a base with a dead band")


def certifier_of(case):
    preset, law, changes = CASES[case]
    return Certifier(settle(load_scenario(preset, changes), law))


def standing(changes):
    certifier = Certifier(settle(load_scenario("safe-simulation", changes), "prox"))
    return stated.of_loop(certifier, certifier.inputs, certifier.tube(certifier.inputs).peaks)


@pytest.fixture(scope="module")
def circle():
    """Certificate with a start, errors of poses and velocities, and jitter."""
    return standing({
        **FREE, "actuator.jitter": 0.002, "corridor.start": [1e-4, 1e-4, 1e-3],
        "sensor.pose_noise": 1e-5, "sensor.velocity_noise": [1e-4, 2e-4],
    })  # fmt: skip


def passed(told, law="mb"):
    setup = settle(safe("reference.kind = lemniscate; clock.duration = 1.5", told), law)
    passing = Passing(Along(setup), bounded_inputs(setup), np.array(setup.scenario.corridor.start))
    return passing, passing.run()


@pytest.fixture(scope="module")
def eight():
    """Certificate of a run on an eight, with a change of the robot, a start and pose errors."""
    return stated.of_run(*passed({
        "changes": [{"t": 0.505, "m": 60.0}], "corridor.start": [1e-4, 1e-4, 1e-3],
        "sensor.pose_noise": 1e-5, "sensor.velocity_noise": [1e-4, 2e-4],
    }))  # fmt: skip


@pytest.mark.parametrize("case", CASES)
@pytest.mark.slow_but(*DEFAULT)
def test_checker_finds_the_width_that_the_computation_states(case):
    certifier = certifier_of(case)
    tube = certifier.tube(certifier.inputs)
    written = stated.of_loop(certifier, certifier.inputs, tube.peaks)
    position, heading = (float(item[0]) for item in check(written))

    assert 0.97 * tube.position < position < 1.003 * tube.position
    assert 0.97 * tube.heading < heading < 1.003 * tube.heading
    late = tube.position_late
    assert 0.97 * late < in_the_long_run(written) < 1.01 * late
    shown = stated.checked(certifier, certifier.inputs, tube)
    assert tube.position <= shown.position >= position


WAYS = cases("""
    torques         | prox     | disturbance.std = 0.5
    observer, noise | kanayama | sensor.velocity_noise = [1e-3, 2e-3]; guard.enabled = false
    late drives     | prox     | actuator = {delay = 0.01, lag = 0.01}; guard.enabled = false; \
disturbance.std = 0.3
    nothing         | mb       | disturbance.std = 0.0
    a start alone   | mb       | disturbance.std = 0.0; corridor.start = [2e-3, 2e-3, 0.02]; \
clock.duration = 3.0
""")


@pytest.mark.parametrize("name, law, told", WAYS)
def test_checker_finds_the_width_of_a_whole_run(name, law, told):
    passing, bounds = passed(told, law)
    position, heading = check(stated.of_run(passing, bounds))

    assert (position < 1.004 * bounds.position + 1e-6).all()
    assert (heading < 1.004 * bounds.heading + 1e-5).all()
    assert position.max() > 0.93 * bounds.position.max()
    shown = stated.checked_run(passing, bounds)
    assert (shown.position >= np.maximum(position, bounds.position)).all()
    assert (shown.heading >= np.maximum(heading, bounds.heading)).all()


@pytest.mark.parametrize("name", ["fast", "state", "out"])
def test_no_size_of_the_box_may_be_smaller(circle, eight, name):
    for written, step in ((circle, 9), (eight, 1500)):
        box = getattr(written, name)
        rows = np.argwhere(box > 1e-9)[::step]
        for k, i in rows if written is eight else rows[rows[:, 0] == 0]:
            less = box.copy()
            less[k:, i] *= 0.9
            if written is circle:
                less[:] = less[0]
            with pytest.raises(RefusedError, match="reaches"):
                check(replace(written, **{name: less}))


LARGER = {
    "push": 0.1, "pose": 1e-5, "velocity": 1e-4, "reckoned": 1e-4, "wide": 1.0, "command": 0.1,
    "dead": 100.0, "start": 1e-4, "law_gap": 0.1, "step_gap": 1e-4, "gap": 1e-4, "off": 0.1,
}  # fmt: skip
"""Increase of each input."""


@pytest.mark.parametrize("name", LARGER)
def test_no_input_may_be_larger_than_what_the_box_is_for(circle, eight, name):
    for written in (circle, *[eight] * (name != "off")):
        with pytest.raises(RefusedError):
            check(replace(written, **{name: getattr(written, name) + LARGER[name]}))


def test_what_a_run_is_aside_counts(eight):
    assert check(replace(eight, aside=eight.aside + 1e-3))[0] == pytest.approx(
        check(eight)[0] + 1e-3
    )
    assert check(replace(eight, aside=eight.aside + 1e-3))[1] == pytest.approx(
        check(eight)[1] + 1e-3
    )


@pytest.mark.parametrize(
    "name", ["push", "velocity", "reckoned", "wide", "command", "dead", "fast", "aside"]
)
def test_a_size_of_the_other_sign_is_refused(circle, name):
    with pytest.raises(RefusedError, match="negative"):
        check(replace(circle, **{name: -getattr(circle, name) - 1e-9}))


def scaled(graph, share, rows):
    """The graph with deviations of some outputs from their values at the centre multiplied."""
    by = [ca.SX.sym("by", graph.numel_in(k)) for k in (0, 1)]
    output = ca.densify(graph(*by))
    output[rows] = share * output[rows]
    return ca.Function("graph", by, [output])


@pytest.mark.parametrize(
    "name, row, share",
    [("law", 0, -1.0), ("law", 1, 0.9), *(("step", row, 1.01) for row in range(5))],
)
def test_the_box_of_another_law_or_robot_is_refused(circle, eight, name, row, share):
    for written in (circle, eight):
        with pytest.raises(RefusedError):
            check(replace(written, **{name: scaled(getattr(written, name), share, row)}))


def test_no_limit_may_act_on_the_box(circle, eight):
    for written in (circle, eight):
        for k in range(written.sizes.numel_out(0)):
            with pytest.raises(RefusedError, match="limit"):
                check(replace(written, sizes=scaled(written.sizes, -1.0, k)))
        with pytest.raises(RefusedError, match="limit"):
            check(replace(written, lower=written.lower + 1e6))


def test_another_delay_other_pairs_or_another_course_are_refused(circle, eight):
    changes = [{"late": 5}, {"ratios": np.full(10, 5.0)}]
    wrong = [replace(circle, **change) for change in changes]
    for name, place in (("states", (60, 1)), ("fine", (60, 3, 1)), ("outs", (60, 0))):
        moved = getattr(eight, name).copy()
        moved[place] += 1.0
        wrong.append(replace(eight, **{name: moved}))
    wrong += [replace(eight, body=eight.body[:1] + 0 * eight.body), replace(eight, lags=20)]
    wrong += [replace(circle, knots=k) for k in ([], [1], [0, 0], [0, circle.fine.shape[1] - 1])]
    for written in wrong:
        with pytest.raises(RefusedError):
            check(written)


def test_every_part_of_a_certificate_is_altered_here():
    """Exceptions are numbers of columns, and points around which the graphs are expanded."""
    altered = {*LARGER, "fast", "state", "out", "law", "step", "sizes", "lower", "late", "ratios",
               "states", "fine", "outs", "body", "aside", "lags"}  # fmt: skip
    sizes = {"queue", "memory", "acting", "share", "knots", "pairs", "disc"}
    numbers = {"law_numbers", "step_numbers"}

    assert {item.name for item in fields(Certificate)} == altered | sizes | numbers


ALTERED = {
    "_remainders": lambda given: tuple(0.9 * part for part in given),
    "_changes": lambda given: 0.9 * given,
    "_given": lambda given: 0.99 * given,
}
"""Results of the computation's steps, made too small."""


@pytest.mark.parametrize("name", ALTERED)
def test_a_computation_that_forgets_something_states_what_is_refused(name, monkeypatch):
    right = getattr(Certifier, name)
    monkeypatch.setattr(Certifier, name, lambda *given: ALTERED[name](right(*given)))
    certifier = certifier_of("jitter")
    tube = certifier.tube(certifier.inputs)
    with pytest.raises(NoCorridorError, match="do not pass their check"):
        stated.checked(certifier, certifier.inputs, tube)


def test_a_run_whose_bounds_forget_something_has_no_width(monkeypatch):
    right = Following._law_added
    monkeypatch.setattr(Following, "_law_added", lambda *given: 0.2 * right(*given))
    tube = find_corridor(
        safe("reference.kind = lemniscate; clock.duration = 1.0"), "mb", whole=True
    )

    assert tube.position is None
    assert "do not pass their check (" in tube.refused
    assert "please report it" in tube.sentence


def test_the_wider_of_computed_and_checked_bounds_is_stated(monkeypatch):
    found = np.array([1.0, 4.0]), np.array([0.1, 0.4])
    for name, value in (("of_loop", None), ("of_run", None), ("check", found),
                        ("in_the_long_run", 0.8)):  # fmt: skip
        monkeypatch.setattr(stated, name, lambda *_, value=value: value)
    each = [stated.checked(None, None, Tube(None, *sizes, "", 0.5))
            for sizes in ((2.0, 0.5, 0.05), (0.5, 0.9, 0.2))]  # fmt: skip
    part = np.array([2.0, 3.0])
    run = stated.checked_run(None, RunBounds(part, part, part / 10, part, part, None))

    assert [(x.position, x.position_late, x.heading) for x in each] == [
        (2.0, 0.8, 0.1), (1.0, 0.9, 0.2),
    ]  # fmt: skip
    assert run.position.tolist() == [2.0, 4.0]
    assert run.heading.tolist() == [0.2, 0.4]


def test_no_box_of_a_monitor_may_be_larger_and_no_time_in_it_shorter():
    certifier = certifier_of("mb")
    latch = latch_of(certifier, certifier.inputs)
    held = certifier.tube(certifier.inputs).peaks.times(LARGER_BOXES[0], DUST)
    written = stated.of_loop(certifier, certifier.inputs, held)
    shown = latched(written, latch.box, latch.samples, 4)

    assert shown == pytest.approx(latch.position, rel=0.02)
    assert np.all(np.array(shown) <= latch.position)
    with pytest.raises(RefusedError, match="reaches"):
        latched(written, 1.1 * latch.box, latch.samples, 4)
    with pytest.raises(RefusedError, match="reaches"):
        latched(written, latch.box, 10, 4)


def test_smaller_inputs_have_a_smaller_box(circle):
    assert check(replace(circle, push=0.5 * circle.push))[0] < 0.9 * check(circle)[0]


STOPS = changes("""
    reference.kind = stop-and-go
    reference.radius = 2.0
    reference.period = 4.0
    reference.speed = 0.2
    changes = []
    clock.control = 0.02
    clock.duration = 2.2
    robot.mu = 0.02
    disturbance.std = 0.25
""")


@pytest.mark.parametrize("law", ["prox", "mb"])
def test_a_robot_that_stops_is_checked(law):
    passing, bounds = passed(STOPS, law)
    written = stated.of_run(passing, bounds)
    position, _ = check(written)

    assert (position < 1.004 * bounds.position).all()
    assert position.max() > 0.93 * bounds.position.max() > 1.2e-3
    for name, i in (("fast", 3), ("state", 1), ("out", 0)):
        less = getattr(written, name).copy()
        less[40:, i] *= 0.95
        with pytest.raises(RefusedError, match="reaches"):
            check(replace(written, **{name: less}))


def test_a_dead_band_counts_in_samples_whose_commands_may_be_in_it():
    """Some commands of 0.2 rad/s may be within 0.18 rad/s of 0, others are not."""
    told = {"base.deadband": [0.0, 0.18], "filter.kind": "clip", "disturbance.std": 1e-4,
            "base.delay": 0.03, "base.quantum": [2e-3, 1e-2], "sensor.pose_noise": 1e-4,
            "disturbance.truncate": 3.0, "clock.control": 0.06, "clock.plant": 0.03,
            "clock.duration": 1.2}  # fmt: skip
    setup = settle(burger(told), "kanayama")
    passing = Passing(Along(setup), bounded_inputs(setup), np.zeros(3))
    bounds = passing.run()
    written = stated.of_run(passing, bounds)
    free = np.abs(written.outs[:, 1]) - written.out[:, 1] > written.dead[1]

    assert 0 < free.sum() < len(free)
    assert (check(written)[0] < 1.004 * bounds.position).all()
    with pytest.raises(RefusedError, match="reaches"):
        check(replace(written, dead=1.05 * written.dead))


@pytest.mark.parametrize("wide", [1e-6, 0.1, 3.0])
@pytest.mark.parametrize("apart", [0.0, 0.02])
def test_slopes_and_what_they_leave_hold_at_every_point(wide, apart):
    """For points up to ``apart`` from each other."""
    x, p = ca.SX.sym("x", 3), ca.SX.sym("p")
    inner = ca.tanh(2 * x[0] - x[1] + p)
    f = ca.vertcat(x[0] * x[1] - 3 * inner, ca.sin(x[1]) + ca.tanh(x[2] + 0.5 * inner) * x[0])
    function, rng = ca.Function("f", [x, p], [f]), np.random.default_rng(5)
    low = rng.uniform(-1.0, 1.0, (40, 1, 4))
    sizes = wide * rng.uniform(0.0, 1.0, (40, 3))
    products = sizes[:, :, None] * sizes[:, None]
    slopes, left = Graph(function).linear(np.array([low, low + apart]), sizes, products)
    at = low + apart * rng.random((40, 200, 4))
    d = sizes[:, None] * rng.choice([-1.0, -0.6, -0.3, 0.0, 0.3, 0.6, 1.0], (40, 200, 3))
    every = np.concatenate([at, at + np.pad(d, [(0, 0), (0, 0), (0, 1)])]).reshape(-1, 4).T
    values = np.array(function.map(every.shape[1])(every[:3], every[3:]))
    before, after = np.split(values.T.reshape(80, 200, 2), 2)
    off = np.abs(after - before - np.einsum("kij,kpj->kpi", slopes[:, 0], d))

    assert (off <= left + 1e-15).all()
    assert np.median(off.max(axis=1) / (left[:, 0] + 1e-15)) > (0.3 if apart == 0 else 0.0)


@pytest.mark.parametrize(
    "op, exact, most",
    [(ca.OP_SIN, arb.sin, 0.6), (ca.OP_COS, arb.cos, 0.6), (ca.OP_EXP, arb.exp, 50.0),
     (ca.OP_TANH, arb.tanh, 25.0), (ca.OP_EXPM1, arb.expm1, 1.0), (ca.OP_SIN, arb.sin, 3.0),
     (ca.OP_INV, lambda x: 1 / x, 2.0), (ca.OP_SQ, lambda x: x * x, 2.0)],
)  # fmt: skip
@pytest.mark.parametrize("wide", [0.0, 1e-6, 0.05])
def test_intervals_hold_what_balls_of_high_precision_say(op, exact, most, wide):
    x = np.random.default_rng(1).uniform(-most, most, 100) * (1 - wide)
    x = x[np.abs(x) > 0.2 * most] if op == ca.OP_INV else x
    low, high = RULES[op]((x - wide * most, x + wide * most))
    with ctx.workprec(200):
        for share in (-1.0, 0.3, 1.0):
            for k, point in enumerate((x + share * wide * most).tolist()):
                assert arb(low[k]) <= exact(arb(point)) <= arb(high[k])
    assert wide > 0 or (high - low <= 2e-13 * np.abs(high) + 1e-300).all()


def test_what_a_tiny_rounding_leaves_counts(circle, eight, monkeypatch):
    monkeypatch.setattr(checker, "UNIT", 1e-3)
    for written in (circle, eight):
        with pytest.raises(RefusedError):
            check(written)
