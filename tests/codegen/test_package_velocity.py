"""Laws of bases that take velocities as C: the run's commands, refused samples, guard_acted."""

import ctypes as ct

import numpy as np
import pytest

from tests.board.emulated import HostBuild
from tests.codegen.packages import write_package
from tests.codegen.test_package import needs, programs
from wmr_ctrl.codegen.package import packaged
from wmr_ctrl.control.controller import controller
from wmr_ctrl.control.filter.channels import ELAPSED
from wmr_ctrl.control.filter.channels import REFUSED as NO_NUMBER
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.signals import GUARD_ACTED, GUARD_DIAGNOSTICS, ODOMETRY_AGE, REFUSED, places
from wmr_ctrl.world.scenario import load_scenario, scenario_hash

BAND = {
    "filter.kind": "band", "filter.loop": "second-order", "filter.damping": (0.5, 1.0),
    "filter.frequency": (8.0, 9.0), "filter.delay": (0.02, 0.02), "filter.trust": True,
    "filter.odometry": None,
}  # fmt: skip
FORMS = {"governor": {}, "band": BAND} | {kind: {"filter.kind": kind} for kind in ("clip", "none")}
LIMIT = 1 + 1e-9


def burger(form, **stated):
    return load_scenario("turtlebot3-burger", {**FORMS[form], **stated})


def stepped(system, rows):
    """Outputs of a System, sample by sample."""
    graph = system.function("step", [system.update, system.y])
    x, shown = system.x0, []
    for row in rows:
        x, y = graph(row, x, system.p0)
        shown.append(y.full().ravel())
    return np.array(shown)


def motions(count=40):
    """Samples of a law's twelve inputs, some far from the path and some at the limit."""
    draw = np.random.default_rng(3)
    rows = draw.uniform(-1, 1, (count, 12)) * 0.15
    rows[:, 3] += 0.1
    rows[::5, 7:9] += 1.0
    return rows


@pytest.mark.parametrize(
    "law, form",
    [("kanayama", "governor"), ("pursuit", "clip"), ("prox", "none"), ("nn", "band")],
)
def test_commands_are_those_of_the_run(law, form):
    """If nothing is refused or late, the commands are those of the run's controller, to the bit."""
    setup = settle(burger(form), law)
    plain, packed = controller(setup), packaged(setup)
    rows = motions()
    at = places(item.signal for item in packed.inputs)
    told = rows[:, : plain.u.numel()]
    for signal in (ODOMETRY_AGE, ELAPSED, REFUSED):
        if signal.name in at:
            told = np.insert(told, at[signal.name].start, 0.0, axis=1)
    wanted, found = stepped(plain, rows[:, : plain.u.numel()]), stepped(packed, told)
    assert np.array_equal(wanted, found[:, :2])
    acts = packed.outputs[-1].signal == GUARD_ACTED
    assert acts == (form != "none")
    assert not acts or set(found[:, -1]) == {0, 1}


@pytest.mark.parametrize(
    "law, form, float32",
    [
        ("kanayama", "governor", False),
        ("pursuit", "clip", False),
        ("prox", "band", False),
        ("nn", "governor", True),
    ],
)
def test_refused_samples_keep_the_limit(law, form, float32, tmp_path):
    """Each third sample has NaN, infinity or too large a number; the base is sluggish."""
    needs("cc")
    scenario, governed = burger(form), form == "governor"
    package = HostBuild(law, scenario, tmp_path, float32=float32)
    draw, v, limits = np.random.default_rng(5), np.zeros(2), np.array(scenario.limits.v_u1)
    tau, gain = scenario.filter.tau if governed else (0.1, 0.1), scenario.filter.gain[1]
    fades = np.exp(-scenario.clock.control / np.array(tau))
    for k, row in enumerate(np.tile(motions(60), (4, 1))):
        row[3], row[10:12], wrong = 0.3, v, k % 3 == 2
        if wrong:
            place = draw.choice([0, 1, 3, 4, 5, 6, 7, 8, 10, 11])  # an angle has no bound
            row[place] = draw.choice([np.nan, np.inf, -np.inf, 2e12])
        with np.errstate(over="ignore"):
            status, _ = package.step([*row, *[0.0] * (1 + governed)])
        out = package.outputs.astype(float)
        assert (status, int(out[2]) & NO_NUMBER) == ((1, NO_NUMBER) if wrong else (0, 0))
        assert np.all(np.abs(out[:2]) <= limits * (1.5 if governed else 1) + 1e-6)
        v = gain * out[:2] + (v - gain * out[:2]) * fades
        if form != "band":  # whose base is of second order
            assert np.all(np.abs(v) <= limits * LIMIT), k
    told = ct.string_at(package.library[f"wmr_{law}_scenario_hash"])
    assert told.decode() == scenario_hash(scenario)


@pytest.mark.parametrize("float32", [False, True])
@pytest.mark.parametrize("form", FORMS)
def test_package_of_a_velocity_base_passes_its_vectors(form, float32, tmp_path):
    scenario = burger(form, **({"encoder.counts": 4096} if form == "clip" else {}))
    write_package("kanayama", tmp_path, scenario, float32=float32)
    checked, example = programs("kanayama", tmp_path)
    assert "largest error" in checked
    assert float(example.split()[1]) < 0.05


def test_guard_acted_is_what_the_guard_did():
    """If a robot takes torques, 1 marks samples in which the run's guard changed the force."""
    setup = settle(load_scenario("safe-simulation"), "prox")
    system, plain = packaged(setup), controller(setup)
    (active,) = (i.expr for i in plain.diagnostics if i.signal == GUARD_DIAGNOSTICS[0])
    graph = plain.function("guard", [plain.update, active])
    rows = np.random.default_rng(1).normal(size=(60, 12))
    rows[:, 10] *= 0.5
    x, wanted = plain.x0, []
    for row in rows:
        x, acted = graph(row, x, plain.p0)
        wanted.append(float(acted.full().any()))
    assert system.outputs[-1].signal == GUARD_ACTED
    assert stepped(system, rows)[:, -1].tolist() == wanted
    assert 0 < sum(wanted) < len(wanted)
    unguarded = packaged(settle(load_scenario("paper-simulation"), "prox"))
    assert GUARD_ACTED not in [item.signal for item in unguarded.outputs]
