"""The corridor's monitor, as C and as an FMU, gives the verdict by which runs are judged."""

import ctypes as ct
import subprocess

import numpy as np
import pytest
from click.testing import CliRunner

from tests.papers_robot import safe
from tests.simulation.physics.shove import SHOVE
from tests.tables import changes
from wmr_ctrl import simulate
from wmr_ctrl.cli import root
from wmr_ctrl.codegen.package import CORRIDOR, files_of
from wmr_ctrl.codegen.toolchain import build_library, find_toolchain
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.export.fmi.fmu_files import export_fmu
from wmr_ctrl.theory.corridor import corridor_monitor
from wmr_ctrl.theory.corridor.monitor import OUTPUTS, Latch
from wmr_ctrl.theory.corridor.monitor import monitor as watching
from wmr_ctrl.world.registry import EFFECTS
from wmr_ctrl.world.scenario import override
from wmr_proofs.corridor import latch
from wmr_proofs.corridor.certificate import Certifier
from wmr_proofs.corridor.latch import latch_of

CASE = safe("changes = []; clock.duration = 32.0")
SHOVED = changes("shove.force = 300.0; shove.start = 30.0; shove.time = 0.5")


@pytest.fixture(scope="module")
def monitor():
    return corridor_monitor(CASE, "prox")


@pytest.fixture(scope="module")
def shoved():
    """A run with an undeclared push, and the inputs of a monitor beside it."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(EFFECTS.__dict__, "plugins", (SHOVE,))
        run = simulate(CASE, "prox", seed=3, overrides=SHOVED)
        left = run.corridor_left
    return run, left


def given(monitor, run):
    """Names of the monitor's inputs and their values, a row a sample."""
    names = [name for item in monitor.inputs for name in item.signal.elements]
    return names, np.column_stack([run[name] for name in names])


def told(monitor, rows):
    step = monitor.function("step", [monitor.update, monitor.y])
    x, outputs = monitor.x0, []
    for u in rows:
        x, y = step(u, x, monitor.p0)
        outputs.append(y.full().ravel())
    return np.array(outputs)


@pytest.mark.slow
def test_it_tells_when_the_corridor_begins_to_hold_and_that_it_was_left(monitor, shoved):
    run, left = shoved
    held, gone, most, distance = told(monitor, given(monitor, run)[1]).T
    since, first = held.argmax(), gone.argmax()

    assert (run.time[since], run.time[first]) == (left.since, left.time)
    assert (most[first], distance[first]) == pytest.approx((left.most, left.distance), rel=1e-12)
    assert held[since:].all()
    assert gone[first:].all()
    assert not gone[:first].any()
    assert not most[: since + 1].any()
    assert (np.diff(most[since + 1 :]) <= 0).all()


def test_what_is_measured_amiss_leaves_less_of_the_box_and_more_of_the_distance():
    noise = changes("""
        sensor.velocity_noise = [1e-4, 2e-4]
        sensor.pose_noise = 1e-4
    """)
    off = {**noise, "guard.enabled": False, "disturbance.std": 0.5}
    setup = settle(override(CASE, off), "prox")
    certifier = Certifier(setup)
    latch = latch_of(certifier, certifier.inputs)
    numbers = {
        p.signal.name: np.array(p.value) for p in watching(setup, latch, measured=True).params
    }
    pose = 2**0.5 * 1e-4
    less = [pose, pose, 0.0, 1e-4, 2e-4]

    assert latch.box[:5] - numbers["corridor.box"][:5] == pytest.approx(less, rel=1e-9)
    assert numbers["corridor.position"] - latch.position == pytest.approx(pose, rel=1e-9)


@pytest.mark.slow
def test_as_c_it_tells_the_same(monitor, shoved):
    _, rows = given(monitor, shoved[0])
    files = files_of(CORRIDOR, monitor, CASE)
    shown = '__attribute__((visibility("default"))) int wmr_corridor_step'
    source = files["wmr_corridor.c"].replace("int wmr_corridor_step", shown)
    kept = {name: files[name] for name in ("wmr_corridor.h", "arithmetic.h")}
    path = build_library({"wmr_corridor.c": source, **kept}, find_toolchain())
    entry, sizes = ct.CDLL(str(path)).wmr_corridor_step, (monitor.p0, monitor.x0)
    p, x = ((ct.c_double * len(item))(*item) for item in sizes)
    y, found = (ct.c_double * len(OUTPUTS))(), []
    for u in rows:
        assert entry(p, x, (ct.c_double * len(u))(*u), y) == 0
        found.append(list(y))
    wanted = told(monitor, rows)

    assert np.array_equal(np.array(found)[:, :3], wanted[:, :3])
    assert np.abs(np.array(found) - wanted).max() < 1e-13


def test_its_example_ends_as_it_says(monitor, tmp_path):
    for name, text in files_of(CORRIDOR, monitor, CASE).items():
        (tmp_path / name).write_text(text)
    compiler = find_toolchain().command
    for program in ("example", "check"):
        line = [*compiler, "-std=c99", "-ffp-contract=off", f"{program}.c", "wmr_corridor.c", "-lm",
                "-o", program]  # fmt: skip
        subprocess.run(line, cwd=tmp_path, check=True, timeout=120)
        done = subprocess.run(
            [f"./{program}"], cwd=tmp_path, check=True, capture_output=True, timeout=60
        )
    assert b"78 samples" in done.stdout


@pytest.mark.slow
def test_as_an_fmu_it_tells_the_same(monitor, shoved, tmp_path):
    fmpy = pytest.importorskip("fmpy")
    from fmpy.validation import validate_fmu

    names, rows = given(monitor, shoved[0])
    (path,) = export_fmu("corridor", law="prox", scenario=CASE, fmi=2, out=tmp_path)
    T, wanted = CASE.clock.control, told(monitor, rows)
    times = shoved[0].time
    table = np.array(
        [(t, *row) for t, row in zip(times, rows, strict=True)],
        dtype=[(name, float) for name in ("time", *names)],
    )
    outputs = [item.name for item in OUTPUTS]
    found = fmpy.simulate_fmu(
        str(path), stop_time=len(rows) * T, output_interval=T, step_size=T, input=table,
        output=outputs,
    )  # fmt: skip
    assert validate_fmu(str(path)) == []
    for name, column in zip(outputs, wanted.T, strict=True):
        assert np.abs(found[name][1:] - column).max() < 1e-13


@pytest.mark.parametrize(
    "case, law, words",
    [
        (
            changes("clock.control = 0.1; guard.enabled = false"),
            "prox",
            "has no corridor to be watched",
        ),
        ({}, "kanayama", "that a monitor cannot see"),
    ],
)
@pytest.mark.slow
def test_what_cannot_be_watched_is_refused(case, law, words):
    with pytest.raises(ScenarioError, match=words):
        corridor_monitor(safe(case), law)


def test_errors_larger_than_the_box_are_refused(monkeypatch):
    """Poses are off by more than the box, velocities are exact."""
    monkeypatch.setattr(latch, "latch_of", lambda certifier, inputs: Latch(
        np.full(len(certifier.loop.at), 0.01), 5, (0.1,), certifier.loop.at, inputs.push, 0.02,
        np.zeros(2),
    ))  # fmt: skip
    with pytest.raises(ScenarioError, match="off by more than the box"):
        corridor_monitor(override(CASE, {"disturbance.std": 0.7}), "prox")


@pytest.mark.parametrize(
    "line", [("prox", "--law", "prox"), ("corridor", "--law", "prox", "--float32")]
)
def test_the_option_that_does_not_belong_there_is_named(line, tmp_path):
    done = CliRunner().invoke(root, ["codegen", *line, "--out", str(tmp_path / "c")])

    assert done.exit_code == 2
    said = " ".join(done.stderr.split())
    assert f"Invalid value for {'--float32' if '--float32' in line else '--law'}: codegen" in said
    assert not (tmp_path / "c").exists()
