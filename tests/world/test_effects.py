"""The effects of this package: against twins, against their bounds, and everywhere alike.

That a scenario's numbers reach all engines is tried on runs; what an effect computes is tried on
its System alone, fed with a motion that wanders.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping
from typing import Any

import casadi as ca
import numpy as np
import pytest

from tests import oracle
from tests.matrix import quick
from tests.world import twins
from wmr_ctrl.api import (
    cosimulate,
    export_fmu,
    scenario_of,
    simulate,
    simulate_runs,
)
from wmr_ctrl.control.loop import LoopGraphs
from wmr_ctrl.control.setup import settle
from wmr_ctrl.errors import ArgumentError, ScenarioError
from wmr_ctrl.model.dynamics import wheel_to_force
from wmr_ctrl.model.system import System
from wmr_ctrl.results import Run
from wmr_ctrl.scenario import Scenario
from wmr_ctrl.signals import TORQUE
from wmr_ctrl.world.effect import Bound, Effect, total
from wmr_ctrl.world.encoder import ENCODER
from wmr_ctrl.world.gust import GUST
from wmr_ctrl.world.gyro import GYRO
from wmr_ctrl.world.jitter import JITTER
from wmr_ctrl.world.motor import MOTOR
from wmr_ctrl.world.pose_delay import POSE_DELAY
from wmr_ctrl.world.resistance import RESISTANCE
from wmr_ctrl.world.slope import SLOPE
from wmr_ctrl.world.velocity_mean import VELOCITY_MEAN
from wmr_ctrl.world.wheels import WHEELS

pytestmark = pytest.mark.usefixtures("one_set_of_instructions")

Changes = Mapping[str, Any]
Rows = list[dict[str, list[float]]]

SHORT: Changes = {"clock.duration": 0.5, "disturbance.std": 0.5, "disturbance.truncate": 3.0}
EFFECTS: Mapping[str, Changes] = {
    "encoder": {"encoder.counts": 1024},
    "encoder over a window": {"encoder.counts": 1024, "encoder.window": 0.03},
    "encoder by time": {"encoder.counts": 1024, "encoder.method": "time"},
    "averaged velocity": {"sensor.velocity_window": 0.02},
    "late velocity": {"sensor.velocity_age": 0.01},
    "gyro": {"gyro.enabled": True, "gyro.bias": 0.01, "gyro.noise": 0.01},
    "late pose": {"sensor.pose_delay": 0.05},
    "lost poses": {"sensor.pose_dropout": 0.3, "sensor.pose_noise": 0.02},
    "jitter": {"actuator.jitter": 0.005},
    "jitter of a delay": {"actuator.jitter": 0.01, "actuator.delay": 0.007},
    "untold delay": {"actuator.unmodelled_delay": 0.004},
    "lag that varies": {"actuator.lag": 0.02, "actuator.lag_spread": 0.5},
    "motor": {"motor.step": 0.2, "motor.dead_zone": 0.1, "motor.stall": 20.0, "motor.free": 30.0},
    "wheels": {"wheels.radius": [0.02, -0.01], "wheels.track": 0.02},
    "slope": {"slope.angle": 0.03, "slope.direction": 0.5, "slope.offset": 0.02},
    "resistance": {"resistance.rolling": [0.01, 0.012], "resistance.viscous": [2.0, 0.1]},
    "gust": {"gust.size": [5.0, 1.0], "gust.time": 0.1},
}
PARTS = ("encoder over a window", "gyro", "late pose", "lost poses", "jitter of a delay",
         "lag that varies", "motor", "wheels", "slope", "resistance", "gust")  # fmt: skip
TOGETHER = {key: value for part in PARTS for key, value in EFFECTS[part].items()}
ALL: Mapping[str, Changes] = {**EFFECTS, "all at once": TOGETHER}
TWINNED = ("lost poses", "untold delay", "lag that varies")
LAW = "mb"


def scenario(changes: Changes) -> Scenario:
    return scenario_of("paper-simulation", {**SHORT, **changes})


def run_of(name: str) -> Run:
    return simulate(scenario(ALL[name]), LAW, seed=3)


def different(one: Run, other: Run) -> list[str]:
    return [
        name for name in one.columns if not np.array_equal(one[name], other[name], equal_nan=True)
    ]


@pytest.mark.parametrize("name", quick(ALL, "all at once", "encoder by time"))
def test_it_matters_and_lanes_have_the_bits_of_one_robot(name):
    run = run_of(name)
    plain = simulate(scenario({}), LAW, seed=3)
    lanes = simulate_runs(scenario(ALL[name]), LAW, [1, 2, 3])

    assert run.rows == 50
    assert not np.array_equal(run["x"], plain["x"])
    assert different(run, lanes[2]) == []


DRIVES = {**EFFECTS["jitter of a delay"], **EFFECTS["lag that varies"], **EFFECTS["motor"],
          **EFFECTS["wheels"], **EFFECTS["gust"], **EFFECTS["lost poses"]}  # fmt: skip
COUPLED = {**EFFECTS, "drives": DRIVES}


@pytest.mark.parametrize("name", quick([*list(EFFECTS)[1::2], "drives"], "drives"))
def test_co_simulation_has_the_bits_of_the_native_loop(name):
    coupled = cosimulate(scenario(COUPLED[name]), LAW, seed=3)
    run = simulate(scenario(COUPLED[name]), LAW, seed=3)

    assert set(different(run, coupled)) <= {"e"}
    assert run.monitor == coupled.monitor


def test_a_package_refuses_each_by_its_table(tmp_path):
    for name, changes in EFFECTS.items():
        table = next(iter(changes)).split(".")[0]
        calm = {**changes, "disturbance.std": 0.0}
        with pytest.raises(ArgumentError, match=rf"\[{table}\].*closed-loop FMU"):
            export_fmu("ssp", law=LAW, scenario=scenario(calm), out=tmp_path)
        assert list(tmp_path.iterdir()) == [], name


@pytest.mark.parametrize("name", EFFECTS)
def test_the_engine_without_a_compiler_and_the_twin_agree(name):
    run, numpy = run_of(name), simulate(scenario(EFFECTS[name]), LAW, seed=3, engine="numpy")
    assert max(np.abs(run[s.name] - numpy[s.name]).max() for s in run.signals) < 1e-9
    if name in TWINNED:
        slow = oracle.simulate(scenario(EFFECTS[name]), LAW, seed=3)
        assert max(np.abs(run[c] - slow[c]).max() for c in ("x", "theta", "v1", "omega")) < 1e-9


# What a System computes, against its twin.


def rows(count: int, rng: np.random.Generator, size: float = 1.0) -> Rows:
    """A motion that wanders with its way, torques of up to 10 N m, and random numbers."""
    v = np.cumsum(rng.normal(0, 0.05 * size, count))
    w = np.cumsum(rng.normal(0, 0.1 * size, count))
    columns = {
        "x": rng.normal(size=count), "y": rng.normal(size=count), "v1": v, "omega": w,
        "path": np.cumsum(v) * 0.01, "theta": np.cumsum(w) * 0.01, "skid": 0.0 * v,
    }  # fmt: skip
    numbers = {n: rng.uniform(-1, 1, (count, 2)) for n in ("gyro", "jitter", "gust")}
    torque = np.repeat(rng.uniform(-10, 10, (count // 10 + 1, 2)), 10, axis=0)
    return [
        {name: [float(values[k])] for name, values in columns.items()}
        | {name: values[k].tolist() for name, values in numbers.items()}
        | {"torque": torque[k].tolist(), "tau_right": [torque[k, 0]], "tau_left": [torque[k, 1]]}
        | {"sample": [float(k)], "step": [float(k)]}
        | {f"{n}_measured": [float(columns[n][k])] for n in ("x", "y", "theta")}
        for k in range(count)
    ]


def fed(system: System, motion: Rows) -> np.ndarray:
    """Outputs of a System, one row for each of ``motion``."""
    graph = system.function("fed", [system.update, system.y])
    x, shown = ca.DM(system.x0), []
    for row in motion:
        given = [v for item in system.inputs for v in row[item.signal.name]]
        draws = [v for item in system.draws for v in row[item.port.signal.name]]
        x, y = graph(given, x, system.p0, *([draws] if draws else []))
        shown.append(np.array(y).ravel())
    return np.array(shown)


WHEELED = {"r": 0.1, "l": 0.25, "radius": (0.02, -0.01), "track": 0.02}
PLAIN = {"r": 0.1, "l": 0.25, "radius": (0.0, 0.0), "track": 0.0}
GROUND = {"m": 50.0, "g": 9.81, "l": 0.25, "v_s": 0.01}


def each(twin: Callable[..., tuple[float, float]], n: Changes) -> Callable[..., Any]:
    return lambda k, row: twin(n, row)


CASES: list[tuple[str, Effect, Changes, Callable[[], Callable[..., Any]]]] = [
    ("encoder", ENCODER, {"encoder.counts": 512},
     lambda: twins.EncoderTwin({**PLAIN, "counts": 512, "periods": 1, "T": 0.01})),
    ("encoder on other wheels", ENCODER,
     {"encoder.counts": 512, "encoder.window": 0.04, **EFFECTS["wheels"]},
     lambda: twins.EncoderTwin({**WHEELED, "counts": 512, "periods": 4, "T": 0.01})),
    ("mean", VELOCITY_MEAN, {"sensor.velocity_window": 0.03, "sensor.velocity_age": 0.02},
     lambda: twins.MeanTwin({"window": 3, "age": 2, "T": 0.01})),
    ("age", VELOCITY_MEAN, {"sensor.velocity_age": 0.02},
     lambda: twins.MeanTwin({"window": 0, "age": 2, "T": 0.01})),
    ("jitter", JITTER, {"actuator.jitter": 0.006},
     lambda: twins.JitterTwin({"delay": 0, "steps": 10, "most": 6})),
    ("jitter of a whole period", JITTER, {"actuator.jitter": 0.01, "actuator.delay": 0.013},
     lambda: twins.JitterTwin({"delay": 13, "steps": 10, "most": 10})),
    ("motor", MOTOR, EFFECTS["motor"],
     lambda: each(twins.motor_twin, {"step": 0.2, "dead_zone": 0.1, "stall": 20.0, "free": 30.0,
                                     "r": 0.1, "l": 0.25})),
    ("slope", SLOPE, EFFECTS["slope"],
     lambda: each(twins.slope_twin, {**GROUND, "angle": 0.03, "direction": 0.5, "offset": 0.02})),
    ("resistance", RESISTANCE, EFFECTS["resistance"],
     lambda: each(twins.resistance_twin, {**GROUND, "rolling": (0.01, 0.012),
                                          "viscous": (2.0, 0.1)})),
    ("gust", GUST, EFFECTS["gust"],
     lambda: twins.GustTwin({"size": (5.0, 1.0), "time": 0.1, "T": 0.01})),
]  # fmt: skip


@pytest.mark.parametrize(("effect", "changes", "twin"), [c[1:] for c in CASES],
                         ids=[c[0] for c in CASES])  # fmt: skip
def test_a_system_is_its_twin(effect, changes, twin):
    motion, other = rows(400, np.random.default_rng(7)), twin()
    if effect is JITTER:
        late = 13 if "actuator.delay" in changes else 0
        motion = delayed(motion, late)
    wanted = np.array([other(k, row) for k, row in enumerate(motion)])

    assert np.abs(fed(effect.build(scenario(changes)), motion) - wanted).max() < 1e-12


def delayed(motion: Rows, steps: int) -> Rows:
    """The same with torques behind a constant delay of so many steps."""
    names = ("torque", "tau_right", "tau_left")
    zero = {"torque": [0.0, 0.0], "tau_right": [0.0], "tau_left": [0.0]}
    return [
        row | {n: motion[k - steps][n] if k >= steps else zero[n] for n in names}
        for k, row in enumerate(motion)
    ]


def test_wheels_turn_torque_into_force_as_their_size_says():
    motion = rows(100, np.random.default_rng(8))
    shown = fed(WHEELS.build(scenario(EFFECTS["wheels"])), motion)
    forces = [wheel_to_force(ca.SX(0.1), ca.SX(0.25), ca.SX(torque)) for torque in shown.tolist()]
    wanted = [twins.wheels_twin(WHEELED, row) for row in motion]

    assert np.allclose([[float(f[0]), float(f[1])] for f in forces], wanted, rtol=1e-13)


def test_late_poses_are_old_poses():
    motion = rows(30, np.random.default_rng(9))
    shown = fed(POSE_DELAY.build(scenario({"sensor.pose_delay": 0.05})), motion)
    pose = [[row[n][0] for n in ("x", "y", "theta")] for row in motion]

    assert np.array_equal(shown, [pose[max(0, k - 5)] for k in range(30)])


def test_the_time_between_counts_shows_a_steady_speed_to_rounding():
    """Forwards, backwards, and so slow that a count takes many samples."""
    effect = ENCODER.build(scenario(EFFECTS["encoder by time"]))
    for speed in (0.5, -0.3, 0.004):
        motion = rows(400, np.random.default_rng(1))
        for k, row in enumerate(motion):
            row |= {"path": [0.01 * k * speed], "theta": [0.0], "skid": [0.0]}
        shown = fed(effect, motion)

        assert np.abs(shown[-100:, 0] - speed).max() < 1e-9 * abs(speed)
        assert np.abs(shown[:, 0]).max() <= abs(speed) * (1 + 1e-9)
        assert not shown[:, 1].any()


def test_the_time_between_counts_forgets_a_speed_when_the_robot_stops():
    motion = rows(300, np.random.default_rng(1))
    for k, row in enumerate(motion):
        row |= {"path": [0.005 * min(k, 100)], "theta": [0.0], "skid": [0.0]}
    shown = fed(ENCODER.build(scenario(EFFECTS["encoder by time"])), motion)[:, 0]
    count = 2 * math.pi * 0.1 / 1024

    assert shown[99] == pytest.approx(0.5)
    assert (np.diff(shown[102:]) < 0).all()
    assert shown[-1] < count / 1.9


# Why the time between counts has no bound.

COUNTS = pytest.mark.parametrize("counts", [64, 1024, 65536])


def timed(counts: int, v1: np.ndarray, omega: np.ndarray) -> np.ndarray:
    """(v1, omega) shown for velocities (n,) that hold over a sample each."""
    motion = rows(len(v1) + 1, np.random.default_rng(1))
    way, turn = (np.concatenate([[0.0], np.cumsum(0.01 * item)]) for item in (v1, omega))
    for k, row in enumerate(motion):
        row |= {"path": [float(way[k])], "theta": [float(turn[k])], "skid": [0.0]}
    changes = {"encoder.counts": counts, "encoder.method": "time"}
    return fed(ENCODER.build(scenario(changes)), motion)[1:]


@COUNTS
def test_the_first_counts_after_a_stand_show_the_mean_over_all_of_it(counts):
    v1 = np.concatenate([np.full(50, 0.5), np.zeros(1000), np.full(5, 0.9)])
    shown = timed(counts, v1, 0 * v1)[:, 0]

    assert v1[1050] == 0.9
    assert shown[1050] < 0.01
    assert shown[1052] == pytest.approx(0.9)


@COUNTS
def test_two_windows_mix_turn_and_thrust_whatever_the_counts(counts):
    """The left wheel stands while the right one drives, then friction stops the turn."""
    omega = np.concatenate([np.full(300, 1.5), np.zeros(20)])
    v1 = np.full(320, 0.25 * 1.5)
    v1[0] += 0.4 * 2 * math.pi * 0.1 / counts / 0.01  # so that the left wheel stands between edges
    shown = timed(counts, v1, omega)
    off = v1[300:] - shown[300:, 0]

    assert off.max() == pytest.approx(0.25 * 1.5 / 2, rel=0.05)
    assert bound_of(ENCODER, {"encoder.counts": counts, "encoder.method": "time"}).void


@COUNTS
def test_a_wheel_turns_by_nearly_a_count_unseen(counts):
    """As far as a difference over one period may be off, of the mean over that period."""
    count = 2 * math.pi * 0.1 / counts
    speed = 0.98 * count / 0.01
    v1 = np.zeros(2002)
    v1[0], v1[2001] = 1.01 * count / 0.01, speed
    shown = timed(counts, v1, 0 * v1)[2001, 0]
    nbar = bound_of(ENCODER, {"encoder.counts": counts}).nbar[0]

    assert 0.97 * nbar < speed - shown < nbar


# What an effect does is within its bound.


def bound_of(effect: Effect, changes: Changes) -> Bound:
    assert effect.bound is not None
    return effect.bound(scenario(changes))


LIMITED = {"actuator.tau_max": 10.0}


def force_of(torque: np.ndarray) -> np.ndarray:
    return np.stack((torque.sum(-1), 0.25 * (torque[..., 0] - torque[..., 1])), -1) / 0.1


@pytest.mark.parametrize("changes", [
    {"motor.step": 0.4}, {"motor.dead_zone": 0.3}, {"motor.stall": 11.0, "motor.free": 40.0},
    {"wheels.radius": [0.02, 0.02]}, {"wheels.radius": [0.02, -0.02], "wheels.track": -0.03},
    {"wheels.track": 0.05},
], ids=str)  # fmt: skip
def test_a_drive_is_off_by_its_bound_and_sometimes_nearly_by_all_of_it(changes):
    """Torques at the edges of what they may be, wheels at the edges of the limits."""
    effect = MOTOR if next(iter(changes)).startswith("motor") else WHEELS
    system = effect.build(scenario({**LIMITED, **changes}))
    bound = bound_of(effect, {**LIMITED, **changes})
    assert bound.void == ""
    edges = [-10.0, -9.8001, -0.3, -0.19999, 0.0, 0.2, 0.3, 9.8, 10.0]
    speeds = itertools.product((-1.0, 0.0, 1.0), (-1.5, 0.0, 1.5))
    motion = [
        {"tau_right": [a], "tau_left": [b], "v1": [v], "omega": [w]}
        for (v, w), a, b in itertools.product(speeds, edges, edges)
    ]
    told = np.array([[row["tau_right"][0], row["tau_left"][0]] for row in motion])
    off = np.abs(force_of(fed(system, motion)) - force_of(told)).max(axis=0)

    assert (off <= np.array(bound.dbar) + 1e-12).all()
    assert (off >= 0.98 * np.array(bound.dbar)).all()


@pytest.mark.parametrize("window", [0.01, 0.05])
@pytest.mark.parametrize("wheels", [{}, EFFECTS["wheels"]], ids=["believed", "others"])
def test_an_encoder_is_off_the_mean_by_less_than_its_bound(window, wheels):
    changes = {"encoder.counts": 256, "encoder.window": window, **wheels}
    bound, n = bound_of(ENCODER, changes), round(window / 0.01)
    system, worst = ENCODER.build(scenario(changes)), np.zeros(2)
    rng = np.random.default_rng(11)
    for _ in range(6):
        motion, place = rows(300, rng), np.zeros(2)
        for row in motion:
            row |= {"path": [place[0]], "theta": [place[1]], "skid": [0.0]}
            place = place + 0.01 * rng.choice([-1.0, 1.0], 2) * rng.uniform(0.9, 1, 2) * (1.0, 1.5)
        shown = fed(system, motion)
        true = np.array([[row["path"][0], row["theta"][0]] for row in motion])
        worst = np.maximum(worst, np.abs(shown[n:] - (true[n:] - true[:-n]) / window).max(axis=0))

    assert bound.window == (window, window)
    assert (worst <= bound.nbar).all()
    assert (worst > 0.4 * np.array(bound.nbar)).all()


@pytest.mark.parametrize(
    ("radius", "track"),
    [([0.1, -0.2], 0.3), ([-0.1, 0.15], -0.3), ([0.2, 0.1], 0.0), ([0.0, 0.0], 0.4)],
    ids=str,
)
def test_other_wheels_misstate_the_velocity_by_their_bound_and_by_all_of_it(radius, track):
    """What true wheels turn, converted with r = 0.1 m and l = 0.25 m, over all velocities."""
    wheels = {"wheels.radius": radius, "wheels.track": track}
    with_them, without = (
        bound_of(ENCODER, {"encoder.counts": 1e6, **changes}).nbar for changes in (wheels, {})
    )
    v, omega = np.meshgrid(np.linspace(-1.0, 1.0, 9), np.linspace(-1.5, 1.5, 9))
    sides = [
        (v + side * 0.25 * (1 + track) * omega) / (0.1 * (1 + share))
        for side, share in zip((1, -1), radius, strict=True)
    ]
    shown = 0.1 * (sides[0] + sides[1]) / 2, 0.1 * (sides[0] - sides[1]) / (2 * 0.25)
    worst = [np.abs(shown[0] - v).max(), np.abs(shown[1] - omega).max()]

    assert np.subtract(with_them, without) == pytest.approx(worst, rel=1e-9, abs=1e-12)


def test_a_gyro_takes_the_place_of_the_encoders_omega():
    changes = {"encoder.counts": 256, "gyro.enabled": True, "gyro.bias": -0.02, "gyro.noise": 0.01}
    both = settle(scenario(changes), LAW).bound
    alone = bound_of(ENCODER, {"encoder.counts": 256})
    shown = fed(GYRO.build(scenario(changes)), rows(50, np.random.default_rng(2)))[:, 0]
    true = [row["omega"][0] for row in rows(50, np.random.default_rng(2))]

    assert both.window == (0.01, 0.0)
    assert both.nbar == (alone.nbar[0], pytest.approx(0.03))
    assert np.abs(shown - true).max() <= 0.03


def test_the_ground_pulls_and_resists_within_its_bound():
    exact = {"guard.M_max": [50.0, 5.4]}
    slope = {"slope.angle": 0.05, "slope.direction": 1.0, "slope.offset": -0.03, **exact}
    rolling = {"resistance.rolling": [0.01, 0.015], "resistance.viscous": [5.0, 0.2]}
    motion = rows(2000, np.random.default_rng(3), size=3.0)
    pulled = np.abs(fed(SLOPE.build(scenario(slope)), motion)).max(axis=0)
    force = fed(RESISTANCE.build(scenario(rolling)), motion)
    v = np.array([[row["v1"][0], row["omega"][0]] for row in motion])
    driven = (force * np.sign(v)).max(axis=0)
    slope_bound, bound = bound_of(SLOPE, slope).dbar, bound_of(RESISTANCE, rolling).dbar

    assert (pulled <= slope_bound).all()
    assert (pulled > 0.99 * np.array(slope_bound)).all()
    assert (driven <= bound).all()


def test_gusts_keep_their_size():
    motion = rows(300, np.random.default_rng(4))
    for row in motion:
        row["gust"] = [1.0, -1.0]
    shown = np.abs(fed(GUST.build(scenario(EFFECTS["gust"])), motion))

    assert (shown <= (5.0, 1.0)).all()
    assert shown[-1] == pytest.approx((5.0, 1.0))


def test_a_delay_that_varies_stays_between_its_ends():
    """The command of each period takes over within [delay, delay + jitter] after its own sample."""
    motion = delayed(rows(4000, np.random.default_rng(5)), 7)
    changes = {"actuator.jitter": 0.006, "actuator.delay": 0.007}
    shown = fed(JITTER.build(scenario(changes)), motion)
    switch = np.flatnonzero(np.any(np.diff(shown, axis=0), axis=1)) + 1
    late = switch % 10

    bound = bound_of(JITTER, changes)
    assert (bound.delay, bound.jitter) == (0.006, 0.006)
    assert {int(k) for k in late} == {(7 + k) % 10 for k in range(7)}
    assert len(switch) in (399, 400)  # the last may come after the end


def test_laws_see_what_is_measured_alone():
    """With encoders, a gyro and late poses no torque depends on true velocity or pose by itself.

    What the graph of a sample reads of the plant is the way and the orientation that encoders
    count, omega for the gyro, and the pose; with the pose's sensor frozen, nothing else.
    """
    changes = {**EFFECTS["encoder"], "actuator.lag": 0.02, "disturbance.std": 0.0}
    for law in ("nn", "prox"):
        loop = LoopGraphs(settle(scenario(changes), law))
        true = {item.signal.name: item.sym for item in loop.plant.state}
        torque = loop.sample.column(TORQUE)
        seen = {name for name, sym in true.items() if ca.depends_on(torque, sym)}
        assert seen == {"x", "y", "theta", "path"}


def test_effects_add_up_and_two_means_are_none():
    changes = {
        **EFFECTS["jitter of a delay"],
        "actuator.unmodelled_delay": 0.004,
        **EFFECTS["encoder"],
    }
    bound = settle(scenario(changes), LAW).bound

    assert (bound.delay, bound.jitter) == (pytest.approx(0.021), 0.01)
    assert bound.window == (0.01, 0.01)
    assert "average" in total([bound, bound]).void
    assert "lag" in total([Bound(lag=(0.01, 0.02))] * 2).void
    assert "0.01 s cannot vary by 0.02" in total([Bound(delay=0.01, jitter=0.02)]).void


@pytest.mark.parametrize(("changes", "message"), [
    ({"encoder.counts": 0}, r"encoder\.counts = 0 must be above 0"),
    ({"encoder.counts": -8}, r"encoder\.counts = -8 must be above 0"),
    ({"encoder.counts": 10.5}, r"encoder\.counts = 10\.5 must be a whole number"),
    ({"encoder.counts": float("nan")}, r"encoder\.counts = nan must be a finite number"),
    ({"encoder.counts": 64, "encoder.window": 0.015}, r"encoder\.window = 0\.015 s .*control"),
    ({"encoder.counts": 64, "sensor.velocity_window": 0.01}, r"encoder\.counts = 64 both"),
    ({"actuator.jitter": -0.001}, r"actuator\.jitter = -0\.001 must be at least 0"),
    ({"actuator.jitter": 0.02}, r"actuator\.jitter = 0\.02 s must be at most clock\.control"),
    ({"guard.delay": [0.02, 0.01]}, r"guard\.delay = \[0\.02, 0\.01\].*wrong way.*\[0\.01, 0\.02"),
    ({"guard.lag": [0.02, 0.01]}, r"guard\.lag = \[0\.02, 0\.01\].*wrong way.*\[0\.01, 0\.02"),
    ({"guard.delay": [0.0, 0.02]}, r"guard\.delay = .* may not vary by more than clock\.control"),
    ({"guard.delay": [-0.01, 0.01]}, r"guard\.delay\[1\] = -0\.01 must be at least 0"),
    ({"actuator.lag": [0.02, 0.03]}, r"actuator\.lag = "),
    ({"actuator.jitter": [0.0, 0.005]}, r"actuator\.jitter = "),
    ({"actuator.jitter": 0.0015}, r"actuator\.jitter = 0\.0015 s .*clock\.plant"),
    ({"actuator.lag": 0.01, "actuator.lag_spread": 1.0}, r"lag_spread = 1.* must be below 1"),
    ({"motor.free": 20.0}, r"motor\.free = 20\.0 rad/s does nothing without motor\.stall"),
    ({"sensor.pose_dropout": 1.0}, r"pose_dropout = 1.* must be below 1"),
    ({"wheels.radius": [0.6, 0.0]}, r"wheels\.radius\[1\] = 0\.6 must be at most 0\.5"),
    ({"gust.time": 0.0}, r"gust\.time = 0.* must be above 0"),
], ids=str)  # fmt: skip
def test_bad_numbers_are_refused_with_key_and_remedy(changes, message):
    with pytest.raises(ScenarioError, match=message):
        scenario(changes)


@pytest.mark.parametrize(
    ("name", "key"),
    [
        ("motor", "motor.stall"),
        ("wheels", "actuator.tau_max"),
        ("encoder by time", "encoder.method"),
    ],
)
def test_what_has_no_bound_voids_the_guarantee_by_its_key(name, key):
    changes = {**EFFECTS[name], "disturbance.std": 0.0}

    assert settle(scenario(changes), LAW).bound.void.startswith(key)
