"""What is identified holds the truth, and follows the symmetries of the robot."""

from dataclasses import fields, replace
from types import SimpleNamespace

import numpy as np
import pytest

import wmr_ctrl.identification.identification as identifying
from benchmarks.own_plant import log_of, simulate
from tests.identification.conftest import KNOWN, STEP, TRUTH
from tests.papers_robot import paper
from wmr_ctrl.identification import identify
from wmr_ctrl.identification.estimate import searched
from wmr_ctrl.identification.fit import PHYSICAL, packed
from wmr_ctrl.identification.kalman import NAMES, SKIPPED, WATCHED, CompiledFilter
from wmr_ctrl.identification.logs.log import LogError
from wmr_ctrl.identification.logs.samples import Samples
from wmr_ctrl.world.scenario import loads_scenario

MAIN = ("m", "I", "delay", "lag")


@pytest.mark.slow
def test_the_truth_is_near_every_interval(found):
    """Three half-widths: an interval of 95 % misses by that much once in 1e8."""
    for name in PHYSICAL:
        item = found.parameters[name]
        middle, half = (item.low + item.high) / 2, (item.high - item.low) / 2
        assert abs(getattr(TRUTH, name) - middle) <= 3 * half, name


@pytest.mark.slow
def test_mass_inertia_delay_and_lag_are_near_the_truth(found):
    for name in MAIN:
        assert found.parameters[name].value == pytest.approx(getattr(TRUTH, name), rel=0.2)
    assert found.parameters["m"].verdict == "determined"


@pytest.mark.slow
def test_wheels_exchanged_in_all_columns_give_the_same_robot(driven, found):
    log = log_of(driven, 0)
    pairs = [
        (f"wheel_counts[{k}] [1]", f"tau_{side} [N.m]") for k, side in ((1, "right"), (2, "left"))
    ]
    (a, b), (c, d) = pairs
    swapped = {"t [s]": log["t [s]"], a: log[c], c: log[a], b: log[d], d: log[b]}

    other = identify(swapped, overrides=KNOWN)

    for name in PHYSICAL:
        half = (found.parameters[name].high - found.parameters[name].low) / 2
        assert abs(other.parameters[name].value - found.parameters[name].value) < 0.05 * half


@pytest.fixture
def read(monkeypatch, found):
    """What `identify` reads of a log before it fits: samples, scenario, remarks."""
    seen = []

    def fit(*item):
        seen.append(item[1:4])
        return found

    monkeypatch.setattr(identifying, "_of_torques", fit)

    def of(log, **options):
        identify(log, **options)
        return seen.pop()

    return of


def assert_same_samples(one, other):
    """All that the fit takes of a log, but for when its clock began."""
    for item in fields(Samples):
        a, b = (getattr(samples, item.name) for samples in (one, other))
        if a is None or b is None:
            assert a is b, item.name
            continue
        if item.name in ("t", "command_t"):
            a, b = a - one.t[0], b - other.t[0]
        assert a == pytest.approx(b, rel=1e-9, abs=1e-6), item.name


@pytest.mark.slow
def test_a_bag_tells_what_its_columns_tell(driven, read, tmp_path):
    """Angles of joints, whose steps are the counts, and their efforts, stamped on another day."""
    pytest.importorskip("rosbags", reason="NOT RUN: rosbags is not there")
    from tests.results.test_bag_topics import EPOCH, JOINTS, bag, joints

    log = {key: np.array(value) for key, value in log_of(driven, 0).items()}
    angle = np.column_stack([log[f"wheel_counts[{k}] [1]"] for k in (1, 2)])
    angle = angle * (2 * np.pi / TRUTH.counts)
    effort = np.column_stack([log["tau_right [N.m]"], log["tau_left [N.m]"]])
    stamps = EPOCH + log["t [s]"]
    rows = zip(stamps, angle, effort, strict=True)
    place = bag(tmp_path, [("/joint_states", JOINTS, s, joints(s, a, (), e)) for s, a, e in rows])

    columns, _, _ = read(log_of(driven, 0), overrides=KNOWN)
    other, scenario, remarks = read(place, overrides={"robot.r": TRUTH.r, "robot.l": TRUTH.l})

    assert scenario.value("encoder.counts")[0] == TRUTH.counts
    assert any("smallest step" in text for text in remarks)
    assert_same_samples(other, columns)


@pytest.mark.parametrize(
    "name, known",
    [
        ("current_{} [A]", {"torque_constant": 0.5}),
        ("voltage_{} [V]", {"torque_constant": 1.0, "resistance": 2.0}),
        ("voltage_{} [mV]", {"torque_constant": 1000.0, "resistance": 2e3}),
    ],
)
def test_currents_and_voltages_tell_what_torques_tell_once_the_motor_is_known(
    driven, read, name, known
):
    log = log_of(driven, 0)
    for side in ("right", "left"):
        torque = log.pop(f"tau_{side} [N.m]")
        scale = 1e3 if "mV" in name else 1.0
        log[name.format(side)] = [2 * scale * value for value in torque]

    with pytest.raises(LogError, match="--torque-constant"):
        identify(log, overrides=KNOWN)
    torques, _, _ = read(log_of(driven, 0), overrides=KNOWN)
    other, _, remarks = read(log, overrides=KNOWN, **known)

    assert any(f"torques are {name.split('_')[0]}" in text for text in remarks)
    assert any("viscous friction" in text for text in remarks) is ("V]" in name)
    assert_same_samples(other, torques)


@pytest.mark.slow
def test_missing_rows_and_a_gap_leave_the_truth_in_reach(driven):
    log = {key: np.array(value) for key, value in log_of(driven, 1).items()}
    keep = np.random.default_rng(0).random(len(log["t [s]"])) > 0.1
    keep[400:500] = False
    thinned = {
        f"{key}": np.where(keep, value, np.nan) for key, value in log.items() if "counts" in key
    }
    rows = {**log, **thinned}
    text = [",".join(rows)]
    text += [
        ",".join("" if np.isnan(v) else repr(float(v)) for v in row)
        for row in zip(*rows.values(), strict=True)
    ]

    found = identify_text("\n".join(text) + "\n")

    for name in MAIN:
        item = found.parameters[name]
        middle, half = (item.low + item.high) / 2, (item.high - item.low) / 2
        assert abs(getattr(TRUTH, name) - middle) <= 3 * half, name


def identify_text(text):
    from tempfile import TemporaryDirectory

    with TemporaryDirectory() as folder:
        path = f"{folder}/log.csv"
        with open(path, "w") as file:
            file.write(text)
        return identify(path, overrides=KNOWN)


@pytest.mark.slow
def test_the_guard_has_room_for_the_delay_and_lag_that_creeping_tyres_hide():
    columns = simulate(replace(TRUTH, creep=1500.0), 1, 40.0, seed=0, step=STEP)

    found = identify(log_of(columns, 0), overrides=KNOWN)

    for name, (least, most) in (("delay", found.bounds.delay), ("lag", found.bounds.lag)):
        assert found.parameters[name].high < getattr(TRUTH, name), f"{name} is not hidden here"
        assert least <= getattr(TRUTH, name) <= most, name
    assert found.scenario.guard.enabled, found.remarks


@pytest.mark.slow
def test_the_scenario_loads_and_its_numbers_are_the_estimates(found):
    text = found.to_toml()

    scenario = loads_scenario(text, found.scenario.name)

    assert scenario == found.scenario
    assert scenario.robot.m == pytest.approx(found.parameters["m"].value, rel=5e-4)
    assert scenario.guard.M_min[0] <= found.parameters["m"].low * (1 + 1e-9)
    assert "determined" in text
    assert scenario.guard.enabled, found.remarks


@pytest.mark.parametrize("nll, information", [(np.nan, 1.0), (1.0, np.nan), (1.0, np.inf)])
def test_fit_that_is_not_finite_is_refused_in_words(nll, information, driven, monkeypatch):
    bad = SimpleNamespace(nll=nll, information=lambda: np.full((2, 2), information))
    monkeypatch.setattr(identifying, "white_fit", lambda problem: bad)
    monkeypatch.setattr(identifying, "coloured_if_likelier", lambda white: white)

    with pytest.raises(LogError, match=r"no model of the robot explains .* time stamps"):
        identify(log_of(driven, 0), overrides=KNOWN)


def test_gradient_and_likelihood_agree():
    """Derivatives that the filter carries along, against differences of the likelihood.

    Without them the likelihood has the same bits: a trial may go without.  The log has a gap,
    after which nothing is known but what is measured.
    """
    rng = np.random.default_rng(1)
    t = np.arange(200) * 0.02
    log = Samples(
        t, np.cumsum(rng.normal(size=(200, 2)) * 1e-3, axis=0), np.array([1e-8, 1e-7]),
        t, rng.normal(size=(200, 2)), np.array([0, 90]),
    )  # fmt: skip
    filter_ = CompiledFilter(paper())
    values = dict.fromkeys(("s1", "n1", "n2"), 1.0) | {"q1": 3.0, "q2": 0.5, "s2": 0.3, "time": 0.5}
    values |= {"m": 30.0, "I": 1.6, "Fc": 12.0, "Fv": 6.0, "c": 3.0, "Mv": 0.3}
    values |= {"delay": 0.033, "lag": 0.05}
    theta = searched(values)
    known, covariance = (
        np.array([0.08, 0.2, 9.81, 0.01, 0.02]),
        packed(np.array([1e-8, 1e-7, 1.0, 1.0, 0.1, 0.1])),
    )

    def read(theta, slopes=True):
        parameters = np.concatenate((theta, known))
        return filter_(log, np.zeros((2, 8)), parameters, covariance, slopes=slopes)

    def of_kind(kind, seen):
        given = np.zeros((2, 8)), np.concatenate((theta, known)), covariance
        return filter_(replace(log, seen=seen), *given, slopes=False, kinds=kind)

    whole, alone = read(theta), read(theta, slopes=False)
    assert (alone.nll == whole.nll).all()
    assert (alone.mean == whole.mean).all()
    skipped = of_kind(SKIPPED, log.seen)  # they are taken in, and not counted
    assert (skipped.mean == alone.mean).all()
    assert not skipped.nll.any()
    watched = [of_kind(WATCHED, seen).mean for seen in (log.seen, log.seen + 0.1)]
    assert (watched[0] == watched[1]).all()  # they are not taken in
    assert (watched[0] != alone.mean).any()
    gradient = whole.gradient.sum(axis=0)
    for k, name in enumerate(NAMES):
        step = np.zeros(len(NAMES))
        step[k] = 1e-5
        slope = (read(theta + step).nll.sum() - read(theta - step).nll.sum()) / 2e-5
        assert gradient[k] == pytest.approx(
            slope, rel=1e-5, abs=1e-3 * abs(gradient).max() * 1e-3
        ), name


def test_the_filter_is_the_kalman_filter_of_a_linear_robot():
    """Without friction the model is linear: likelihood by matrices, of exact discrete steps."""
    from scipy.linalg import expm

    m, inertia, r, half, T, q, var = 20.0, 1.1, 0.09, 0.21, 0.02, (2.0, 0.4), (1e-6, 2e-6)
    rng = np.random.default_rng(2)
    t, tau = np.arange(120) * T, rng.normal(size=(120, 2))
    seen = np.cumsum(rng.normal(size=(120, 2)) * 2e-3, axis=0)
    log = Samples(t, seen, np.array(var), t, tau, np.array([0]))
    filter_ = CompiledFilter(paper())
    values = dict.fromkeys(("Fc", "Fv", "c", "Mv", "s1", "s2"), 0.0)
    values |= {"m": m, "I": inertia, "delay": 0.0, "lag": 5e-4, "q1": q[0], "q2": q[1], "time": 1.0,
               "n1": 1.0, "n2": 1.0}  # fmt: skip
    theta = searched(values)
    covariance = packed(np.array([*var, 0.5, 0.5, 0.0, 0.0]))
    parameters = np.concatenate((theta, [r, half, 9.81, 0.01, T]))
    told = filter_(log, np.zeros((1, 8)), parameters, covariance, slopes=False)

    whole = 0.0
    forces = np.column_stack((tau.sum(axis=1), half * (tau[:, 0] - tau[:, 1]))) / r
    for axis, mass in enumerate((m, inertia)):
        a = expm(np.array([[0.0, 1.0], [0.0, 0.0]]) * T)
        b = np.array([T**2 / 2, T]) / mass
        x, p, late = np.zeros(2), np.diag([var[axis], 0.5]), 0.0
        for k in range(120):
            if k:
                # The lag of half a millisecond: its mean over a period, as the filter has it.
                decay = np.exp(-T / 5e-4)
                after = forces[k - 1, axis] + decay * (late - forces[k - 1, axis])
                mean = forces[k - 1, axis] + 5e-4 * (late - after) / T
                late = after
                x = a @ x + b * mean
                p = a @ p @ a.T + np.outer(b, b) * q[axis] ** 2
            s = p[0, 0] + var[axis]
            e = seen[k, axis] - x[0]
            whole += (e**2 / s + np.log(s)) / 2
            gain = p[:, 0] / s
            x, p = x + gain * e, p - np.outer(gain, p[0])
    # Pieces of 10 ms halve the noise's grain: its way is off by a quarter of b's square term.
    assert told.nll.sum() == pytest.approx(whole, rel=5e-3)


def test_scoring_ends_where_the_gradient_is_nothing(found):
    fit = found.white
    gradient = np.abs(fit.last.gradient.sum(axis=0)[fit.free])
    scale = np.sqrt(np.diag(fit.information()))

    assert np.all(gradient <= 0.05 * scale)


@pytest.mark.slow
def test_a_fit_on_exact_numbers_finds_them():
    """Speeds without noise, made by the product: every mass and time within 1 %."""
    from wmr_ctrl import simulate as run

    made = run("paper-simulation-noise-free", "kanayama", overrides={
        "clock.duration": 20.0, "actuator.delay": 0.02, "actuator.lag": 0.03, "robot.v_s": 0.05,
    })  # fmt: skip
    columns = {f"{k} [{u}]": made[k] for k, u in (("t", "s"), ("v1", "m/s"), ("omega", "rad/s"),
               ("tau_right", "N.m"), ("tau_left", "N.m"))}  # fmt: skip
    found = identify({k: v.tolist() for k, v in columns.items()},
                     overrides={"robot.r": 0.1, "robot.l": 0.25, "robot.v_s": 0.05})  # fmt: skip

    assert found.parameters["m"].value == pytest.approx(50.0, rel=0.01)
    assert found.parameters["I"].value == pytest.approx(5.4, rel=0.01)
    late = found.parameters["delay"].value + found.parameters["lag"].value
    assert late == pytest.approx(0.05, abs=0.002)


@pytest.mark.slow
def test_intervals_cover():
    """One of three may miss; `benchmarks.intervals` tries hundreds."""
    robots = 3
    columns = simulate(TRUTH, robots, 40.0, seed=100, step=2e-3)
    hits = dict.fromkeys(MAIN, 0)
    for robot in range(robots):
        found = identify(log_of(columns, robot), overrides=KNOWN)
        for name in MAIN:
            item = found.parameters[name]
            hits[name] += item.low <= getattr(TRUTH, name) <= item.high

    assert min(hits.values()) >= robots - 1, hits
