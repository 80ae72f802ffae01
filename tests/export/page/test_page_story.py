"""What the steps of the story claim, with the seed of the page."""

import pytest

import wmr_ctrl
from wmr_ctrl.core.fields.units import length
from wmr_ctrl.export.page.content import content_of
from wmr_ctrl.export.page.scenes import PageScene, story
from wmr_ctrl.world.scenario import load_scenario
from wmr_proofs.corridor.asked import run_corridor

pytestmark = pytest.mark.slow

STEPS = {step.key: step for step in story()}


@pytest.fixture(autouse=True)
def one_variant(monkeypatch):
    """Of a scene no other period or delay is offered."""
    for name in ("PERIODS", "LATE"):
        monkeypatch.setattr(f"wmr_ctrl.export.page.scenes.{name}", ())


def run_of(key, law):
    return wmr_ctrl.simulate(STEPS[key].scenario, law)


def first_time(run):
    return run.monitor.first_violation[0]


def test_the_barrier_holds_and_pid_does_not():
    assert run_of("barrier", "mb").monitor.violations == 0
    assert run_of("barrier", "pid").monitor.max_abs_v[0] == pytest.approx(3.0, abs=0.15)


def test_far_away_both_break_and_mb_for_good():
    mb, nn = run_of("far", "mb"), run_of("far", "nn")

    assert 3.0 < first_time(mb) < 3.1
    assert abs(mb["v1"][-1000:]).min() > 1.0
    assert 0 < nn.monitor.violations < 1000
    assert first_time(nn) > 3.0


def test_at_100_ms_the_papers_laws_break_at_once():
    mb, nn = run_of("slow", "mb"), run_of("slow", "nn")

    assert max(first_time(mb), first_time(nn)) < 0.1
    assert mb.summary()["position_rms"]["last_quarter"] > 1.0


def test_prox_needs_no_guard_where_nn_does():
    prox, nn = run_of("tuned", "prox"), run_of("tuned", "nn")

    assert prox.summary()["tracked"]
    assert max(prox.summary()["guard_share"]) == pytest.approx(1 / 200)
    assert max(nn.summary()["guard_share"]) > 0.5


def test_a_page_has_the_certified_corridors():
    brief = {"clock.duration": 3.0, "changes": [{"t": 1.5, "m": 60.0}]}
    scenario = load_scenario("safe-simulation", brief)
    scene = PageScene("near", "Near", "", scenario, ("prox",))

    tubes = content_of([scene], ("prox", "pid"), 0, lambda share: None).data["scenes"][0]["tubes"]

    course = run_corridor(scenario, "prox").course
    assert list(tubes) == ["prox"]
    assert len(tubes["prox"]["widths"]) == 30
    assert tubes["prox"]["widths"] == [max(course[0, k : k + 10]) for k in range(0, 300, 10)]
    shown = length(course[0].max())
    assert {**tubes["prox"], "widths": 0} == {
        "widths": 0, "every": pytest.approx(0.1), "shown": shown, "until": 3.0,
    }  # fmt: skip


def test_a_robot_has_room_for_delay_that_no_law_is_told():
    known = {"actuator.delay": 0.01, "actuator.unmodelled_delay": 0.9, "clock.plant": 0.001}
    scenario = load_scenario("paper-simulation-nominal", known)
    scene = PageScene("late", "Late", "", scenario, ("pid",))

    room = content_of([scene], ("pid",), 0, lambda share: None).room

    assert room.delay_steps > 900
