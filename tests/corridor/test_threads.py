"""Corridors computed in several threads concurrently, or after other uses of balls."""

import time
from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace

import pytest
from flint import ctx

from tests.papers_robot import safe
from wmr_ctrl.theory import corridor
from wmr_proofs.corridor import asked, latch, masses, whole

MADE_BY = ((masses, "certified"), (whole, "certified_run"), (latch, "monitor_of"),
           (latch, "left_by"))  # fmt: skip


@pytest.fixture
def together(monkeypatch):
    """Numbers of threads that compute simultaneously, one entry per computation."""
    now, found = [], []

    def certifying(*given, **more):
        now.append(1)
        time.sleep(0.02)
        found.append(len(now))
        now.pop()
        return corridor.Corridor("prox", refused="nothing is certified here")

    def forget():
        for kept in (asked._found, asked._of_run, asked._course_of):
            kept.cache_clear()

    for module, name in MADE_BY:
        monkeypatch.setattr(module, name, certifying)
    forget()
    yield found
    forget()


def test_one_thread_certifies_at_a_time(together, monkeypatch):
    """Threads share python-flint's precision; one would change it during another's sums."""
    scenario = safe()
    monkeypatch.setattr(corridor, "scenario_of_run", lambda run: scenario)
    run = SimpleNamespace(law="prox", settings=SimpleNamespace(plant_kind="mujoco"))
    tasks = [
        lambda: corridor.find_corridor(scenario, "prox"),
        lambda: corridor.certified_corridor(scenario, "prox"),
        lambda: asked.run_corridor(scenario, "prox"),
        lambda: corridor.corridor_course(scenario, "prox", whole=False),
        lambda: corridor.corridor_monitor(scenario, "prox"),
        lambda: corridor.left_corridor(run),
    ]

    with ThreadPoolExecutor(len(tasks)) as pool:
        for done in [pool.submit(task) for task in tasks]:
            done.result()

    assert together == [1] * len(tasks)


def test_a_precision_that_others_left_changes_no_figure():
    scenario, found = safe(), []
    for bits in (53, 30, 300):
        asked._found.cache_clear()
        with ctx.workprec(bits):
            found.append(corridor.find_corridor(scenario, "mb"))
            assert ctx.prec == bits

    assert found[0].position is not None
    assert found[0] == found[1] == found[2]
