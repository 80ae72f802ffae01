"""The numbers of the page are those of the native engine, bit for bit."""

import json
from pathlib import Path

import numpy as np
import pytest

import wmr_ctrl
from tests.commands import finished
from tests.compilers import NODE, where
from tests.papers_robot import paper
from tests.tables import cases
from wmr_ctrl.control.setup import settle
from wmr_ctrl.export.page.module import PageLoops
from wmr_ctrl.export.page.scenes import story
from wmr_ctrl.world.scenario import override

SCRIPT = Path(__file__).with_name("run.mjs")


def from_page(page, folder, requests):
    """Columns of runs by the page's module in node, or its error."""
    asked, out = folder / "requests.json", folder / "out"
    asked.write_text(json.dumps(requests), "utf-8")
    finished([where(*NODE), str(SCRIPT), str(page), str(asked), str(out)], timeout=300)
    numbers, at, found = np.fromfile(f"{out}.bin"), 0, []
    for line in map(json.loads, out.read_text("utf-8").splitlines()):
        columns = {}
        for name in line.get("names", ()):
            columns[name] = numbers[at : at + line["samples"]]
            at += line["samples"]
        found.append(columns or line["error"])
    return found


def of_run(run):
    """Columns of a Run by element name."""
    return {
        name: run[signal.name] if signal.size == 1 else run[signal.name][:, i]
        for signal in run.signals
        for i, name in enumerate(signal.elements)
    }


def assert_same_bits(shown, run):
    wanted = of_run(run)
    assert list(shown) == list(wanted)
    for name, column in wanted.items():
        assert np.array_equal(shown[name].view("<u8"), column.copy().view("<u8")), name


@pytest.mark.slow
def test_laws_in_every_scene(page, laws, tmp_path):
    """Runs last 80 s, as in the scenario, with noise, changes, the guard, and a pose every 100 ms.

    The scenes run the other laws of the page in turn.
    """
    cases = [(law, step) for k, step in enumerate(story()) for law in laws[k % 2 :: 2]]
    shown = from_page(page, tmp_path, [(law, 80.0, {"scene": step.key}) for law, step in cases])

    for (law, step), columns in zip(cases, shown, strict=True):
        assert_same_bits(columns, wmr_ctrl.simulate(step.scenario, law))


@pytest.mark.slow
@pytest.mark.parametrize("law", ["mb", "prox"])
def test_variants_and_numbers_are_those_of_a_scenario(page, tmp_path, law):
    """Guard, period and delay select another loop; all other numbers are parameters of a loop."""
    variants = (
        {"guard.enabled": True, "actuator.delay": 0.05},
        {"clock.control": 0.05, "limits.v_u1[1]": 0.9},
    )
    numbers = {"robot.mu": 0.1, "disturbance.std": 0.5}
    # What follows from a number of a scenario does not follow on the page: so it is said here.
    steady = {"model.mu": 0.08, "guard.dbar": [60.0, 15.0], "changes[1].mu": 0.1}
    asked = [(law, 80.0, {**variant, **numbers, "seed": 7}) for variant in variants]

    for variant, columns in zip(variants, from_page(page, tmp_path, asked), strict=True):
        derived = {**variant, **numbers, **steady}
        run = wmr_ctrl.simulate("paper-simulation", law, seed=7, overrides=derived)
        assert_same_bits(columns, run)


REFUSED = """
{"robot.m": -3} | robot.m = -3 must be above 0
{"robot.r": 0} | robot.r = 0 must be above 0
{"limits.v_u1": [-1, 0]} | limits.v_u1[1] = -1 must be above 0
{"limits.v_u2[1]": 1.2} | limits.v_u2[1] = 1.2 must be below limits.v_u1[1] = 1
{"limits.clip": 0.5} | limits.clip = 0.5 must be below v_u1[1] - v_u2[1]
{"seed": -1} | seed = -1 must be a whole number
{"seed": 1.5} | seed = 1.5 must be a whole number
{"guard.enabled": "yes"} | guard.enabled = "yes" must be true or false
{"initial.pose[1]": 1e300} | initial.pose[1] = 1e+300 must be at most
{"robot.mu": null} | robot.mu = null must be a number
{"reference.radius": 0} | ref_radius = 0 must be at least 0.000001
{"clock.control": "fast"} | clock.control = fast must be a finite number
{"clock.control": 0.03} | 0.02 s
{"robot.z": 1} | robot.m
{"robot.m": "heavy"} | number
{"scene": "moon"} | barrier
"""


@pytest.mark.slow
def test_refuses_what_it_has_no_loop_or_no_field_for(page, laws, tmp_path):
    given, wanted = zip(*(item.values for item in cases(REFUSED)), strict=True)
    asked = [("mb", 1.0, json.loads(text)) for text in given]
    asked += [("nobody", 1.0, {}), ("mb", -1.0, {})]
    wanted += (", ".join(laws[:3]), "seconds")

    for text, words in zip(from_page(page, tmp_path, asked), wanted, strict=True):
        assert words in text
        assert "." in text.removeprefix(words)


@pytest.mark.slow
def test_one_file_below_its_size_that_asks_nobody(page):
    text = page.read_text("utf-8")

    assert page.stat().st_size < 2_000_000  # a third less where loops are optimised
    for asking in ("src=", "href=", "@import", "url(", "fetch(", "http://www.", "https://"):
        assert asking not in text.replace("http://www.w3.org/2000/svg", ""), asking
    for step in story():
        assert step.text in text.replace("&#39;", "'")


@pytest.mark.slow
def test_a_successor_goes_on_and_a_limit_that_is_moved_is_watched(tmp_path):
    """The page is past the change at 40 s, with noise; the queues in a law's memory are empty."""
    page = wmr_ctrl.write_page(tmp_path / "a.html", scenario="paper-simulation", laws=["mb"])
    done = finished([where(*NODE), str(SCRIPT.with_name("going_on.mjs")), str(page)], timeout=300)
    found = json.loads(done.stdout)

    assert found["same"]
    assert found["before"] == 0 < found["after"]


def test_setups_that_differ_in_numbers_share_a_loop():
    loops = PageLoops()
    first = loops.of(settle(paper(), "pid"))

    assert loops.of(settle(override(paper(), {"robot.m": 60.0}), "pid")) is first
    assert loops.of(settle(paper(), "mb")).name == "k1"
    assert [item.name for item in loops] == ["k0", "k1"]
    assert len(loops) == 2
