"""Claims of the story's steps hold with the page's seed."""

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
    """Offer no other period or delay in a scene."""
    for name in ("PERIODS", "LATE"):
        monkeypatch.setattr(f"wmr_ctrl.export.page.scenes.{name}", ())


def runs_of(key, *laws):
    return [wmr_ctrl.simulate(STEPS[key].scenario, law) for law in laws]


def first_time(run):
    return run.monitor.first_violation[0]


def test_the_barrier_holds_near_and_far_away_both_laws_break_mb_for_good():
    near, pid = runs_of("barrier", "mb", "pid")
    mb, nn = runs_of("far", "mb", "nn")

    assert near.monitor.violations == 0
    assert pid.monitor.max_abs_v[0] == pytest.approx(3.0, abs=0.15)
    assert 3.0 < first_time(mb) < 3.1
    assert abs(mb["v1"][-1000:]).min() > 1.0
    assert 0 < nn.monitor.violations < 1000
    assert first_time(nn) > 3.0


def test_at_100_ms_the_papers_laws_break_at_once_and_prox_needs_no_guard():
    mb, nn = runs_of("slow", "mb", "nn")
    prox, guarded = (run.summary() for run in runs_of("tuned", "prox", "nn"))

    assert max(first_time(mb), first_time(nn)) < 0.1
    assert mb.summary()["position_rms"]["last_quarter"] > 1.0
    assert prox["tracked"]
    assert max(prox["guard_share"]) == pytest.approx(1 / 200)
    assert max(guarded["guard_share"]) > 0.5


def test_a_page_has_the_certified_corridors():
    brief = {"clock.duration": 3.0, "changes": [{"t": 1.5, "m": 60.0}]}
    scenario = load_scenario("safe-simulation", brief)
    scene = PageScene("near", "Near", "", scenario, ("prox",))

    tubes = content_of([scene], ("prox", "pid"), 0, lambda share: None).data["scenes"][0]["tubes"]

    course = run_corridor(scenario, "prox").course[0]
    assert tubes == {"prox": {
        "widths": [max(course[k : k + 10]) for k in range(0, 300, 10)],
        "every": pytest.approx(0.1), "shown": length(course.max()), "until": 3.0,
    }}  # fmt: skip


def test_a_robot_has_room_for_delay_that_no_law_is_told():
    known = {"actuator.delay": 0.01, "actuator.unmodelled_delay": 0.9, "clock.plant": 0.001}
    scenario = load_scenario("paper-simulation-nominal", known)
    scene = PageScene("late", "Late", "", scenario, ("pid",))

    room = content_of([scene], ("pid",), 0, lambda share: None).room

    assert room.delay_steps > 900
