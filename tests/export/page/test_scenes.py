"""Pages of bases that take velocities: the ways to limit commands, and their numbers."""

import json

import numpy as np
import pytest

import wmr_ctrl
from benchmarks.browser import CHROMIUM, browser
from tests.compilers import where
from tests.export.page.test_module import assert_same_bits, from_page
from tests.export.page.test_page_browser import READY
from tests.export.page.walled import walled
from tests.tables import changes
from wmr_ctrl.control.filter.stop_numbers import stopping
from wmr_ctrl.export.page.content import content_of
from wmr_ctrl.export.page.scenes import members_of, scenes
from wmr_ctrl.results.obstacles import nearest
from wmr_ctrl.world.scenario import load_scenario, override

BURGER = load_scenario("turtlebot3-burger")
STRONG = override(BURGER, {"base.gain": [1.04, 1.04]})
SWINGING = """
base = {kind = "velocity", loop = "pi", kp = 140.0, ki = 320.0}
robot = {m = 60.0, I = 5.0, mu = 0.0}
disturbance.std = 0.0
limits = {v_u1 = [1.0, 2.0], v_u2 = [0.7, 1.4]}
clock.control = 0.05
filter = {loop = "pi", mass = [50, 65], inertia = [4, 6], kp = [135, 165], ki = [270, 330]}
"""


def swinging(stated):
    """A base that overshoots, with a filter."""
    return load_scenario("paper-simulation-nominal", changes(SWINGING) | changes(stated))


def test_a_page_has_no_title_of_a_preset_with_other_numbers(tmp_path):
    """For example, a base without noise does not have the title of a circle with noise."""
    file = tmp_path / "mine.toml"
    file.write_text('extends = "paper-simulation"\nbase.kind = "velocity"\ndisturbance.std = 0.0\n')
    titles = {
        "mine": load_scenario(file), "Mine": load_scenario(file, {"title": "Mine"}),
        BURGER.title: BURGER, "turtlebot3-burger, changed": override(BURGER, {"robot.m": 1.2}),
    }  # fmt: skip
    for title, scenario in titles.items():
        assert scenes(scenario, ("pursuit",))[0].title == title


@pytest.mark.parametrize(
    "scenario, ways",
    [
        (BURGER, ["clip", "governor"]),
        (load_scenario("clearpath-jackal"), ["clip"]),
        (swinging('filter.kind = "band"'), ["clip", "slew", "band"]),
        (swinging('filter.kind = "clip"; filter.jitter = 0.06'), ["clip"]),
    ],
    ids=["burger", "jackal", "band", "late"],
)
def test_a_base_has_the_filters_that_hold_for_it(scenario, ways):
    """A base that overshoots also gets slow commands."""
    members = members_of(scenario, ["pursuit"])

    assert [item.name for item in members] == [
        f"pursuit-{way}" for way in ("clipped", "smoothed", *ways)
    ]
    assert len({item.look.colour for item in members}) == len(members)


def test_members_have_the_slew_that_is_stated_and_laws_their_own_limits():
    """A base that takes torques has one robot for each law."""
    slow = members_of(swinging('filter.kind = "clip"; filter.slew = [0.1, 0.3]'), ["pursuit"])
    shown = {item.name: item.overrides["filter.slew"] for item in slow}
    own = members_of(BURGER, ["prox", "kanayama"])
    torques = members_of(load_scenario("paper-simulation"), ["mb", "nn"])

    assert (shown["pursuit-slew"], shown["pursuit-clip"]) == ((0.1, 0.3), None)
    assert [item.name for item in own][:3] == ["prox-clipped", "prox-clip", "prox-governor"]
    assert own[0].look.dash != own[-1].look.dash
    assert [(item.name, item.law) for item in torques] == [("mb", "mb"), ("nn", "nn")]


@pytest.fixture(scope="module")
def burger(tmp_path_factory):
    page = tmp_path_factory.mktemp("page") / "burger.html"
    return wmr_ctrl.write_page(page, STRONG, laws=["pursuit"])


@pytest.mark.slow
def test_its_page_has_the_numbers_of_runs_and_shows_what_the_filter_is_for(burger, tmp_path):
    members = members_of(STRONG, ["pursuit"])
    shown = from_page(burger, tmp_path, [(item.name, 80.0, {}) for item in members])

    for item, columns in zip(members, shown, strict=True):
        run = wmr_ctrl.simulate(item.settled(STRONG).scenario, item.law)
        assert_same_bits(columns, run)
        filtered = item.name.split("-")[1] in ("clip", "governor")
        assert (np.abs(run["v1"]).max() <= 0.22) == filtered
    keys = burger.read_text("utf-8").partition("<kbd>")[2].partition("</details>")[0]
    assert [word in keys for word in ("push", "guard", "scenes")] == [True, False, False]


@pytest.mark.slow
def test_its_page_says_what_a_filter_does_not_promise(burger, tmp_path):
    def said(**numbers):
        texts = [f'document.getElementById("set-{name}").parentElement' for name in numbers]
        for text, value in zip(texts, numbers.values(), strict=True):
            box = f"{text}.querySelector('[type=number]')"
            one.value(f"{box}.value = '{value}'; {box}.dispatchEvent(new Event('change'))")
        one.value("wmr.page.restart(), wmr.page.fleet.advance(0.1, 1e9), wmr.page.board()")
        notices = str(one.value("document.getElementById('notices').innerText"))
        one.value("document.getElementById('reset').click()")
        one.value("wmr.page.restart(), wmr.page.board()")
        assert one.value("document.getElementById('notices').innerText") == ""
        return notices

    with browser(where(*CHROMIUM), tmp_path) as one:
        one.open(burger.as_uri(), READY)
        one.value("wmr.page.play(false)")
        assert said() == ""
        assert "no filter promises anything" in said(**{"base.gain[1]": 1.06})
        assert "the governor does not promise anything" in said(**{"base.gain[2]": 0.94})
        assert "outside of filter.tau, 0.06 to 0.15" in said(**{"base.tau[1]": 0.16})
        assert said(**{"filter.d[1]": 0.3}).count("sends 0") == 2
        assert "Refused" in said(**{"base.tau[1]": -1.0})
        assert one.said == []


def test_before_a_wall_there_are_clipped_commands_the_approach_rule_and_the_filter():
    def told(scenario, law):
        found = content_of(scenes(scenario, (law,)), (law,), 0, lambda _: None)
        return found, found.data["scenes"][0]

    content, scene = told(walled(), "kanayama")
    _, other = told(BURGER, "pursuit")
    named, others = ({item["name"] for item in each["controls"]} for each in (scene, other))

    assert scene["shown"] == ("kanayama-clipped", "kanayama-approach", "kanayama-governor")
    assert len({item.name for item in content.loops}) == 3
    assert "nav2’s node was not run" in scene["text"]
    assert scene["obstacles"] == (((3.0, -1.0), (3.0, 1.0)),)
    assert scene["stops"]["ways"][10] == pytest.approx(stopping(walled(), 0.5).distance)
    assert content.room.delay_steps * walled().clock.plant == pytest.approx(0.5)
    assert "base.delay" in named - others
    assert (other["obstacles"], "stops" in other) == ((), False)


@pytest.fixture(scope="module")
def wall(tmp_path_factory):
    return wmr_ctrl.write_page(tmp_path_factory.mktemp("page") / "wall.html", walled())


@pytest.mark.slow
def test_before_a_wall_only_the_filter_stops_in_time(wall, tmp_path):
    """The page's brake acts, unlike in a run; the base is late and pushed within its bounds."""

    def driven(**numbers):
        one.value(f"wmr.page.fleet.replace({json.dumps(numbers)}), wmr.page.restart()")
        one.value("wmr.page.fleet.advance(9, 1e9), wmr.page.board()")
        said = one.value("document.getElementById('notices').innerText")
        found = "[...wmr.page.fleet.members.values()].map(m => [m.carried.gap, m.braked])"
        return said, one.value(found)

    law = "kanayama"
    with browser(where(*CHROMIUM), tmp_path) as one:
        one.open(wall.as_uri(), READY)
        one.value("wmr.page.play(false)")
        _, alone = driven()
        said, (clipped, approach, ours) = driven(**{"base.delay": 0.15, "disturbance.push[1]": 5.3})
        hopeless, _ = driven(**{"base.delay": 0.3, "disturbance.push[1]": 20.0})
        assert one.said == []

    assert alone[2][0] == pytest.approx(nearest(wmr_ctrl.simulate(walled(), law))[0], abs=2e-3)
    assert said == ""
    assert max(clipped[0], approach[0]) <= 0
    assert ours[0] > 0.05
    assert ours[1]
    assert hopeless.count("the filter promises nothing") == 2


@pytest.mark.slow
def test_the_filter_before_a_wall_has_the_numbers_of_a_run(wall, tmp_path):
    (shown,) = from_page(wall, tmp_path, [("kanayama-governor", 6.0, {})])
    member = members_of(walled(), ["kanayama"])[2]
    assert_same_bits(shown, wmr_ctrl.simulate(member.settled(walled()).scenario, "kanayama"))
