"""Data of a page's script: variants, numbers that change, sliders and colours; nothing compiled."""

import pytest

from wmr_ctrl.control.laws.registry import NAMES
from wmr_ctrl.export.page.content import content_of
from wmr_ctrl.export.page.scenes import WAYS, scenes
from wmr_ctrl.report.style import after_dark, look
from wmr_ctrl.world.scenario import load_scenario

T, H = 0.01, 0.001


@pytest.fixture(scope="module")
def content():
    """One law on the paper's scenario, of another length and with a wider track."""
    changed = {"clock.duration": 60.0, "robot.l": 0.5, "disturbance.truncate": 3.0}
    scenario = load_scenario("paper-simulation", changed)
    return content_of(scenes(scenario, ("mb",)), ("mb",), 3, lambda share: None)


def variants_of(content):
    return content.data["scenes"][0]["variants"]


def test_a_period_or_a_delay_is_offered_with_and_without_guard(content):
    offered = [(v["guard"], v["period"], v["delay"]) for v in variants_of(content)]
    periods = (0.001, 0.002, 0.005, T, 0.02, 0.05, 0.1)
    places = [*((period, 0.0) for period in periods), (T, 2 * T), (T, 5 * T)]

    assert offered[0] == (False, T, 0.0)
    assert sorted(offered) == sorted((on, *place) for on in (False, True) for place in places)


def test_a_variants_numbers_are_its_own_and_change_when_the_robot_does(content):
    base, loops = content.data["scenes"][0]["base"]["mb"], {}
    for variant in variants_of(content):
        assert bool(variant["refusal"]) == (not variant["laws"])
        for law in variant["laws"].values():
            first, second = law["rows"]
            own = base | first
            assert (own["clock.control"], own["robot.m"]) == (variant["period"], 50.0)
            assert not set(base.items()) & set(first.items())
            assert second == {"robot.m": 65.0, "robot.I": 7.0, "robot.mu": 0.15}
            assert law["phases"] == [0, round(40.0 / H)]
            loops.setdefault((variant["period"], variant["delay"]), []).append(law["loop"])
    assert max(map(len, loops.values())) == 2
    assert all(len(set(of_place)) == len(of_place) for of_place in loops.values())
    assert (content.room.phases, content.room.delay_steps) == (2, round(5 * T / H))


def test_the_robot_is_drawn_as_wide_as_it_is(content):
    body = content.data["body"]

    assert (body["track"], content.mass, content.data["seed"]) == (0.5, 50.0, 3)
    assert body["size"] == pytest.approx([1.6, 1.0])
    assert content.data["names"]["robot.I"][0] == "kg m²"


def test_robots_stand_out_in_the_dark_by_the_contrast_of_wcag():
    for colour in (*(look(law).colour for law in NAMES), *(row["colour"] for row in WAYS.values())):
        assert after_dark(colour) != colour
        assert contrast(after_dark(colour), "#12161c") >= 4.5


def contrast(one, other):
    """(L1 + 0.05)/(L2 + 0.05) of relative luminances, WCAG 2.2."""

    def luminance(colour):
        r, g, b = ((c / 255) for c in bytes.fromhex(colour[1:]))
        r, g, b = (c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in (r, g, b))
        return 0.2126 * r + 0.7152 * g + 0.0722 * b

    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)
