"""When the corridor starts to hold a run, and what leaving it proves."""

from copy import copy
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.corridor_adversary import attack
from tests.papers_robot import safe
from tests.simulation.physics.shove import SHOVE
from tests.tables import changes
from wmr_ctrl import load_run, simulate
from wmr_ctrl.control.setup import settle
from wmr_ctrl.theory.corridor import find_corridor
from wmr_ctrl.world.registry import EFFECTS
from wmr_proofs.corridor.certificate import Certifier
from wmr_proofs.corridor.latch import STAGES, latch_of

SHORT = changes("changes = []; clock.duration = 32.0")


@pytest.fixture(scope="module")
def certifier():
    return Certifier(settle(safe(), "prox"))


def test_what_is_left_of_a_start_is_that_of_its_largest_deviation(certifier):
    held = certifier.tube(certifier.inputs).peaks
    most = (held.state / certifier.gains.scale).max()

    def settled(left):
        parts = ("fast", "state", "law")
        given = [replace(getattr(certifier.gains, name), left=left) for name in parts]
        other = copy(certifier)
        other.gains = replace(certifier.gains, **dict(zip(parts, given, strict=True)))
        return other.settled(certifier.inputs, held).every

    assert settled(1.0) - settled(0.0) == pytest.approx(most)


@pytest.mark.slow
def test_what_holds_after_the_latch_comes_down_to_the_corridor(certifier):
    latch = latch_of(certifier, certifier.inputs)
    alone = certifier.tube(certifier.inputs).position

    assert list(latch.position) == sorted(latch.position, reverse=True)
    assert len(latch.position) == STAGES
    assert 1.3 * alone > latch.position[0] > latch.position[-1] >= alone
    assert latch.position[-1] == pytest.approx(alone, rel=0.01)


def test_no_sample_from_the_box_goes_farther_than_it_says(certifier):
    """The tests' own loop starts within the box and is pushed at random."""
    scenario, rng = safe(), np.random.default_rng(5)
    held = certifier.tube(certifier.inputs).peaks.times(1.2)
    box = 0.3 * held.state
    most = certifier.next_sample(certifier.inputs, box, held).fast[:3]
    quiet, rest = np.zeros((20, 2)), scenario.clock.substeps
    before = 20 - 1 / rest  # one plant step before the sample
    for _ in range(20):
        jump = 0.95 * rng.choice([-1.0, 1.0], size=3) * box[:3]
        push = 3.0 * rng.choice([-1.0, 1.0], size=(1, 2))
        e = attack(scenario, "prox", np.vstack([quiet, push]), jump=jump, at=before).e[-rest:]
        assert (np.abs(e).max(axis=0) <= most).all()


@pytest.mark.slow
def test_a_push_that_nobody_told_of_is_proved_to_have_been(monkeypatch, tmp_path):
    """An effect's bound says that it does nothing; the run proves that wrong."""
    monkeypatch.setitem(EFFECTS.__dict__, "plugins", (SHOVE,))
    shoved = SHORT | changes("shove.force = 300.0; shove.start = 30.0; shove.time = 0.5")
    run = simulate("safe-simulation", "prox", seed=3, overrides=shoved)
    calm = simulate("safe-simulation", "prox", seed=3, overrides={**shoved, "shove.force": 20.0})
    run.save(tmp_path / "run.npz")
    left = run.corridor_left

    assert "corridor-left" in [item.key for item in run.remarks]
    assert 30.0 < left.time < 30.5
    assert left.since < 15.0
    assert left.distance > left.most
    assert left.most >= find_corridor(safe(SHORT), "prox").position
    assert "3 N m and M = 50 kg: one of these was not so" in left.sentence
    assert load_run(tmp_path / "run.npz").corridor_left == left
    assert calm.corridor_left is None

    shown = {**shoved, "frames": "rep103"}  # orientations from +X: the same run
    assert simulate("safe-simulation", "prox", seed=3, overrides=shown).corridor_left == left
