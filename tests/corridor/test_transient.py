"""Starts from which limits act: enclosures of the loop against the tests' own loop."""

from __future__ import annotations

import re
from itertools import product

import casadi as ca
import numpy as np
import pytest
from flint import ctx

from tests.corridor.adversary import Attacked, worst_pushes
from wmr_ctrl.control.setup import settle
from wmr_ctrl.corridor import affine, find_corridor, transient
from wmr_ctrl.corridor.certificate import Certifier
from wmr_ctrl.corridor.inputs import NoCorridorError
from wmr_ctrl.corridor.limited import LimitedLoop, _secant_of
from wmr_ctrl.corridor.masses import certified
from wmr_ctrl.corridor.sample import SampleMatrices, doubles
from wmr_ctrl.corridor.settling import Settling
from wmr_ctrl.scenario import load_scenario, override


def driven(scenario, start, push):
    """Errors e at all plant steps (N, 3), velocities at samples, largest torque, of a run.

    It begins off by ``start``.
    """
    loop = Attacked(scenario, "prox", push)
    target = loop.reference(0.0)
    c, s = np.cos(target.theta - start[2]), np.sin(target.theta - start[2])
    # ahead is (-s, c), aside (-c, -s)
    x = target.x + (c * start[1] + s * start[0])
    y = target.y + (s * start[1] - c * start[0])
    loop.state = (x, y, target.theta - start[2], target.v1, target.v2)
    loop.run(None)
    columns = loop.log.columns()
    torque = max(np.abs(columns[name]).max() for name in ("tau_right", "tau_left"))
    v = np.stack([columns["v1"], columns["omega"]], axis=1)
    return np.array(loop.errors), v, torque


@pytest.fixture(scope="module")
def limited():
    return LimitedLoop(Certifier(settle(load_scenario("safe-simulation"), "prox")))


@pytest.mark.parametrize(
    "middle", [(0.045, 0.045, 0.13), (-0.045, 0.03, -0.13), (-0.02, 0.0, 0.0), (0.01, -0.01, 0.05)]
)
def test_cells_hold_all_runs_of_the_oracle_while_limits_act(limited, middle):
    scenario, samples = load_scenario("safe-simulation"), 16
    width, rng = np.array([0.002, 0.002, 0.01]), np.random.default_rng(3)
    inputs, steps = limited.certifier.inputs, scenario.clock.substeps
    cells, boxes, far = limited.start(np.array([middle]), width[None]), [], 0.0
    for _ in range(samples):
        cells, way, _ = limited.after(cells, inputs)
        boxes.append((cells.c[0, :3], cells.radius[0, :3], *(x[0] for x in cells.velocities)))
        far = max(far, way[0])

    reached = []
    for _ in range(12):
        start = np.array(middle) + width * rng.choice([-1.0, 1.0], size=3)
        push = 3.0 * rng.choice([-1.0, 1.0], size=(1 if rng.random() < 0.5 else samples, 2))
        e, v, torque = driven(scenario, start, np.broadcast_to(push, (samples, 2)))
        reached.append(torque)
        for (center, radius, *_), now in zip(boxes, e[steps - 1 :: steps], strict=True):
            assert (np.abs(now - center) <= radius).all()
        for (_, _, low, high), now in zip(boxes, v[1:samples], strict=False):
            assert (low <= now).all()
            assert (now <= high).all()
        assert np.hypot(e[:, 0], e[:, 1]).max() <= far

    if abs(middle[0]) > 0.03:
        assert max(reached) == pytest.approx(20.0)  # the wheels' limit did act


@pytest.mark.parametrize(
    "start",
    [
        (0.01, 0.01, 0.05),
        pytest.param((0.05, 0.01, 0.05), marks=pytest.mark.slow),
    ],
)
def test_a_start_from_which_limits_act_comes_into_its_corridor(start):
    scenario = override(load_scenario("safe-simulation"), {"corridor.start": start})
    alone = find_corridor(load_scenario("safe-simulation"), "prox")
    tube, samples = find_corridor(scenario, "prox"), 250
    assert tube.settling > 0
    assert "the limits of law and wheels may act for" in tube.sentence
    assert "most used in the end: " in tube.sentence
    assert "most used: " in alone.sentence
    assert tube.position_late == pytest.approx(alone.position, rel=1e-4)

    farthest = 0.0
    for push, signs in zip(
        worst_pushes(scenario, "prox", samples, 3.0)[:3], (0, 3, 6), strict=True
    ):
        corner = np.array(start) * (1 - 2 * np.array([signs & 1, signs >> 1 & 1, signs >> 2]))
        e, _, _ = driven(scenario, corner, push)
        assert np.hypot(e[:, 0], e[:, 1]).max() <= tube.position
        assert np.abs(e[:, 2]).max() <= tube.heading
        late = e[-100 * scenario.clock.substeps :]
        assert np.hypot(late[:, 0], late[:, 1]).max() <= 1.5 * alone.position
        beyond, _, _ = driven(scenario, 1.3 * corner, 1.3 * push)
        farthest = max(farthest, np.hypot(beyond[:, 0], beyond[:, 1]).max())
    assert farthest > tube.position


def test_a_start_aside_comes_in_as_far_off_as_pushes_lead_it_and_hardly_farther():
    """From each corner, by pushes that are held, and by some that change sides once."""
    start, tau, samples = np.array([0.004, 0.012, 0.025]), 10.0, 24
    told = {"clock.control": 0.02, "clock.plant": 0.01, "clock.duration": 1.0, "changes": [],
            "guard.enabled": False, "disturbance.std": 0.3, "actuator.tau_max": tau,
            "gains.prox": {"rho": [42.9, 21.74], "wo": 10.0}}  # fmt: skip
    scenario = override(load_scenario("safe-simulation"), told)
    alone = find_corridor(scenario, "prox")
    tube = find_corridor(override(scenario, {"corridor.start": start.tolist()}), "prox")

    far = turned = most = 0.0
    for *corner, right, left in product((1, -1), repeat=5):
        for change in (9, 12):
            push = np.full((samples, 2), 0.9) * (right, left)
            push[change:] *= -1
            e, _, torque = driven(scenario, start * corner, push)
            far, turned = (
                max(known, size.max())
                for known, size in ((far, np.hypot(e[:, 0], e[:, 1])), (turned, np.abs(e[:, 2])))
            )
            most = max(most, torque)
    assert most == pytest.approx(tau)  # the wheels' limit did act
    assert far < tube.position == pytest.approx(1.041 * far, rel=0.005)
    assert turned < tube.heading == pytest.approx(1.0746 * turned, rel=0.005)
    assert tube.position_late == pytest.approx(alone.position, rel=1e-4)
    assert tube.settling == 0.4
    assert tube.share == pytest.approx(1.0346 * alone.share, rel=0.002)  # what is left by then


def test_a_cell_is_held_by_its_halves(limited):
    cells = limited.start(np.zeros((1, 3)), np.array([[0.003, 0.003, 0.02]]))
    for _ in range(4):
        cells, _, _ = limited.after(cells, limited.certifier.inputs)
    rng, (c, G) = np.random.default_rng(7), (cells.c[0], cells.G[0])
    xi = rng.uniform(-1.0, 1.0, (G.shape[1], 300))
    xi[:, :150] = np.sign(xi[:, :150])
    x, n = c[:, None] + G @ xi, limited.n
    for row in (0, 2, 4):
        halves, held = cells.halves(row), np.zeros(300, dtype=bool)
        known = [
            (cells.velocities[i][0, row - 3] if row > 2 else (-1) ** (i + 1) * 9.0) for i in (0, 1)
        ]
        for middle, columns in zip(halves.c, halves.G, strict=True):
            width = columns[row, -1]
            share = (x[row] - middle[row]) / width
            assert width < 0.6 * np.abs(G[row]).sum()
            assert np.abs(columns[row, :-1]).max() < 1e-9 * width
            again = middle[:, None] + columns @ np.vstack([xi, np.zeros((n, 300)), share])
            assert again == pytest.approx(x, abs=1e-12)
            held |= np.abs(share) <= 1
        assert held[(x[row] >= known[0]) & (x[row] <= known[1])].all()
        assert not halves.pushes


@pytest.mark.slow
def test_runs_of_the_oracle_stay_in_one_of_the_halves(limited):
    scenario, first, samples = load_scenario("safe-simulation"), 10, 16
    middle, width = np.array([0.05, 0.05, 0.15]), np.array([0.001, 0.001, 0.005])
    inputs, steps, rng = limited.certifier.inputs, scenario.clock.substeps, np.random.default_rng(3)
    cells = limited.start(middle[None], width[None])
    for _ in range(first):
        cells, _, _ = limited.after(cells, inputs)
    whole, cells, boxes = cells, cells.halves(4), []
    for _ in range(first, samples):
        cells, _, _ = limited.after(cells, inputs)
        whole, _, _ = limited.after(whole, inputs)
        boxes.append((cells.c[:, :3], cells.radius[:, :3], *cells.velocities))
    narrower = cells.radius[:, 2] / whole.radius[:, 2]
    assert narrower.max() < 1
    assert narrower.min() < 0.9

    inside = np.zeros(2, dtype=int)
    for _ in range(12):
        start = middle + width * rng.choice([-1.0, 1.0], size=3)
        push = 3.0 * rng.choice([-1.0, 1.0], size=(1 if rng.random() < 0.5 else samples, 2))
        e, v, _ = driven(scenario, start, np.broadcast_to(push, (samples, 2)))
        held = np.ones(2, dtype=bool)
        for k, (center, radius, low, high) in enumerate(boxes, first):
            held &= (np.abs(e[steps * (k + 1) - 1] - center) <= radius).all(axis=1)
            if k + 1 < samples:
                held &= ((low <= v[k + 1]) & (v[k + 1] <= high)).all(axis=1)
        assert held.any()
        inside += held
    assert (inside > 0).all()


@pytest.mark.slow
def test_corners_of_a_start_five_centimetres_off_both_ways_come_in_some_cut_on_their_way(
    monkeypatch,
):
    """All eight, as wide as cells that are cut at their start: runs lead farthest from there."""
    start, width = np.array([0.05, 0.05, 0.15]), np.array([0.0025, 0.0025, 0.0125])
    told = {"corridor.start": tuple(start), "clock.plant": 0.005}
    scenario = override(load_scenario("safe-simulation"), told)
    middles = np.array([(start - width) * signs for signs in product((1, -1), repeat=3)])
    batches, run = [], transient._Search._run

    def counted(search, parts):
        batches.append((parts[0].k, len(parts)))
        return run(search, parts)

    monkeypatch.setattr(transient, "_cut", lambda _: (middles, np.full((8, 3), width)))
    monkeypatch.setattr(transient._Search, "_run", counted)
    certifier = Certifier(settle(scenario, "prox"))
    before, tube = transient.transient(certifier, certifier.inputs)
    assert sum(count for k, count in batches if k) > 1
    assert tube.position_late == pytest.approx(0.0044, abs=5e-5)

    far = turned = 0.0
    for push, signs in zip(worst_pushes(scenario, "prox", 200, 3.0), range(8), strict=True):
        corner = start * (1 - 2 * np.array([signs & 1, signs >> 1 & 1, signs >> 2]))
        e, _, _ = driven(scenario, corner, push)
        far = max(far, np.hypot(e[:, 0], e[:, 1]).max())
        turned = max(turned, np.abs(e[:, 2]).max())
    assert far <= before.position < 1.01 * far
    assert turned <= before.heading


def test_what_is_followed_without_limits_holds_runs_and_is_forgotten(limited):
    scenario, inputs, samples = load_scenario("safe-simulation"), limited.certifier.inputs, 120
    n, start = limited.n, np.array([0.003, 0.003, 0.02])
    settling = Settling(limited.certifier.started(np.zeros((n, 1))), inputs, samples)
    cells = limited.start(np.zeros((1, 3)), start[None])
    course = settling.course(limited.rest(cells, np.zeros((n, 0))))
    assert course.through.tolist() == [0]
    assert (np.abs(course.rest[0, :3]).sum(axis=1) < 0.9 * start).all()

    again, steps = settling.course(course.rest), samples * scenario.clock.substeps
    assert again.through.tolist() == [0]

    for push, signs in zip(worst_pushes(scenario, "prox", 2 * samples, 3.0), range(8), strict=True):
        corner = start * (1 - 2 * np.array([signs & 1, signs >> 1 & 1, signs >> 2]))
        e, _, _ = driven(scenario, corner, push)
        for part, stage in ((e[:steps], course), (e[steps:], again)):
            assert np.hypot(part[:, 0], part[:, 1]).max() <= stage.position
            assert np.abs(part[:, 2]).max() <= stage.heading


def test_what_would_reach_limits_does_not_come_through(limited):
    n = limited.n
    settling = Settling(
        limited.certifier.started(np.zeros((n, 1))), limited.certifier.inputs, samples=20
    )
    far = limited.start(np.array([[0.0, 0.05, 0.15], [0.0, 0.001, 0.0]]), np.full((2, 3), 1e-4))
    rest = limited.rest(far, np.zeros((n, 0)))
    assert settling.likely(rest).tolist() == [False, True]
    assert settling.course(rest).through.tolist() == [1]


def test_a_cell_of_which_the_guard_may_change_the_force_is_given_up(limited):
    cells = limited.start(np.zeros((2, 3)), np.full((2, 3), 1e-3))
    cells.c[0, 3] = 0.99  # of 1 m/s
    after, _, _ = limited.after(cells, limited.certifier.inputs)

    assert np.isnan(after.c[0]).all()
    assert np.isfinite(after.c[1]).all()


def test_what_is_too_far_off_after_a_stage_is_followed_on(monkeypatch):
    start = (0.005, 0.005, 0.025)
    scenario = override(load_scenario("safe-simulation"), {"corridor.start": start})
    certifier = Certifier(settle(scenario, "prox"))
    monkeypatch.setattr(transient, "SAMPLES", 10)
    before, tube = transient.transient(certifier, certifier.inputs)
    assert tube.share < 1
    assert tube.position_late < 0.0045
    assert 0.0088 > before.position > start[0]
    assert 0.064 > before.heading > start[2]

    monkeypatch.setattr(transient, "STAGES", 1)
    told = "0.1 s after limits may act last, what is left of the start may be (0.0014, "
    with pytest.raises(NoCorridorError, match=re.escape(told)):
        transient.transient(certifier, certifier.inputs)


@pytest.mark.parametrize(
    ("limits", "start", "words"),
    [
        ({"CELLS": 80}, (0.01, 0.01, 0.25),
         "0.3 s after it limits may act still, and more than 80"),
        ({}, (0.01, 0.01, 0.4), "0.3 s after it limits may act still, also without pushes"),
        ({"FINEST": 2.0, "WIDEST": (1, 1, 1)}, (0.001, 0.05, 0.02),
         "0.05 s after it its turning velocity is known too coarsely"),
        ({"FINEST": 2.0, "WIDEST": (1, 1, 1)}, (0.1, 0.001, 0.02),
         "0.06 s after it its speed is known too coarsely"),
        ({"FINEST": 2.0, "WIDEST": (1, 1, 1)}, (0.001, 0.001, 0.3),
         "0.01 s after it its heading is known too coarsely"),
    ],
)  # fmt: skip
def test_a_start_that_is_too_far_off_is_refused_with_its_place(monkeypatch, limits, start, words):
    for name, value in {"LOOKS": (20, 30), "SAMPLES": 20, **limits}.items():
        monkeypatch.setattr(transient, name, value)
    certifier = Certifier(
        settle(override(load_scenario("safe-simulation"), {"corridor.start": start}), "prox")
    )
    place = r"limits may act, and from a start off by about \(\S+, \S+, \S+\) m, m, rad it is not"
    more = " cells were tried" * ("CELLS" in limits)
    with pytest.raises(NoCorridorError, match=f"^{place} known to come back: {words}{more}$"):
        transient.transient(certifier, certifier.inputs)


@pytest.mark.parametrize(
    ("law", "changes", "words"),
    [
        ("mb", {}, "covered for prox"),
        ("prox", {"sensor.pose_noise": 1e-5}, "errors of measurements"),
        ("prox", {"gains.prox.transport": "level"}, "covered for prox"),
        (
            "prox",
            {"actuator.jitter": 2e-3, "guard.enabled": False, "disturbance.std": 0.1},
            "jitter of",
        ),
        (
            "prox",
            {"sensor.pose_period": 0.05, "disturbance.std": 0.1},
            "poses that are rare or lost",
        ),
    ],
)
def test_what_a_transient_does_not_cover_is_refused_by_name(law, changes, words):
    far = {"corridor.start": (0.02, 0.02, 0.1), **changes}
    tube = find_corridor(override(load_scenario("safe-simulation"), far), law)

    assert words in tube.refused
    assert "from which limits act" in tube.refused
    told = re.search(r"it closes from a start moved by (\S+) % of that", tube.sentence)
    assert 0.9 * tube.near <= float(told[1]) / 100 <= tube.near < 1
    for share, closes in ((0.98, True), (1.1, False)):
        near = {**far, "corridor.start": [share * tube.near * x for x in far["corridor.start"]]}
        setup = settle(override(load_scenario("safe-simulation"), near), law)
        assert (certified(setup, closing=False).position is not None) == closes


def test_an_operation_without_a_rule_is_refused_by_name(monkeypatch):
    monkeypatch.delitem(affine._RULES, ca.OP_TANH)
    changes = {"corridor.start": (0.01, 0.01, 0.05), "clock.plant": 0.01}
    refused = find_corridor(override(load_scenario("safe-simulation"), changes), "prox").refused

    assert f"limits act (operation {ca.OP_TANH} of CasADi is not covered" in refused


def test_the_proximal_map_lies_between_the_lines_that_enclose_it(limited):
    rng = np.random.default_rng(5)
    for graph in limited.maps:
        low = rng.uniform(-3.0, 2.0, 40)
        high = low + rng.uniform(0.0, 1.0, 40)
        slope, least, most, _ = _secant_of(graph, low, high)
        for share in np.linspace(0.0, 1.0, 51):
            y = low + share * (high - low)
            x = _secant_of(graph, y, y)
            value = x[0] * y + x[1]
            assert (value - slope * y <= most).all()
            assert (value - slope * y >= least - 1e-11).all()
        assert ((slope >= 0) & (slope <= 1)).all()


def test_what_a_circle_is_off_its_steps_is_counted():
    changes = {
        "reference.rate": 1.5, "reference.radius": 0.2, "disturbance.std": 0.0,
        "clock.control": 0.02, "clock.plant": 0.02, "guard.enabled": False,
        "limits.v_u1": (3.0, 9.0), "limits.v_u2": (2.5, 8.0),
    }  # fmt: skip
    scenario = override(load_scenario("safe-simulation"), changes)
    limited = LimitedLoop(Certifier(settle(scenario, "prox")))
    e, _, _ = driven(scenario, np.zeros(3), np.zeros((10, 2)))
    cells = limited.start(np.zeros((1, 3)), np.full((1, 3), 1e-15))
    for now in e:
        cells, _, _ = limited.after(cells, limited.certifier.inputs)
        assert (np.abs(now - cells.c[0, :3]) <= cells.radius[0, :3]).all()


def test_what_plant_steps_leave_is_counted_with_any_signs(limited):
    loop, n, samples = limited.loop, limited.n, 30
    settling = Settling(
        limited.certifier.started(np.zeros((n, 1))), limited.certifier.inputs, samples
    )
    with ctx.workprec(1000):
        step = doubles(SampleMatrices(loop).step)
    nz, most = len(step), 0.0
    for age in range(samples):
        rows = settling.every @ settling.powers[age]
        each = [rows[:, :nz] @ np.linalg.matrix_power(step, s) for s in range(loop.steps)]
        worst = np.sum(np.abs(each), axis=0)  # by one push of any sign after each plant step
        within = len(settling.rows)
        fast = worst[:within].reshape(loop.steps, settling.count, nz).max(axis=0)
        worst = np.concatenate([fast, worst[within:]]).T
        told = settling.ways[age][-nz:]
        assert (told >= worst * (1 - 1e-12)).all()
        most = max(most, (told / np.maximum(worst, 1e-9 * told.max())).max())
    assert most == pytest.approx(1.0, rel=1e-3)  # and no more
