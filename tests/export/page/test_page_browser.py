"""The page in a real browser: controls change the outcome, and nothing goes wrong."""

import pytest

from benchmarks.browser import CHROMIUM, browser
from tests.compilers import where

READY = "window.wmr && window.wmr.page && window.wmr.page.frames > 1"
EVEN = "(() => { let now = 0; performance.now = () => (now += 10); return now; })()"
"""Script with which each call of the clock advances 10 ms, however busy the machine is."""
PHONE, SCREEN = (390, 844), (1300, 900)


@pytest.fixture(scope="module")
def opened(page, tmp_path_factory):
    with browser(where(*CHROMIUM), tmp_path_factory.mktemp("browser")) as one:
        yield one, page.as_uri()


@pytest.fixture
def shown(opened):
    """The page's first scene, paused at its start; no error may have been reported."""
    one, url = opened
    show(one, url)
    yield one
    assert one.said == []


def show(one, url, link="", size=SCREEN):
    one.show(*size, touch=size == PHONE)
    one.open("about:blank")
    one.open(f"{url}#{link}", READY)
    one.value("wmr.page.play(false), wmr.page.restart()")


def fastest(one, law, seconds):
    """Largest |v1| [m/s] of a law after some seconds from the start."""
    one.value("wmr.page.restart()")
    one.value(f"wmr.page.fleet.advance({seconds}, 1e9)")
    return float(one.value(f"wmr.page.fleet.members.get('{law}').found().most[0]"))


def slide(one, name, share):
    """Move the slider of a number, as a hand would."""
    one.value(
        f"(() => {{ const range = document.getElementById('set-{name}');"
        f" range.value = {share} * range.max; range.dispatchEvent(new Event('input')); }})()"
    )


pytestmark = pytest.mark.slow


def test_a_slider_changes_the_outcome(shown):
    before = fastest(shown, "mb", 5.0)
    slide(shown, "limits.v_u1[1]", 0.2)
    lower = float(shown.value("wmr.page.fleet.value('limits.v_u1[1]')"))
    after = fastest(shown, "mb", 5.0)

    assert lower < 0.5
    assert before > 0.75
    assert after < lower
    assert "limits.v_u1[1]" in str(shown.value("wmr.page.link"))


def test_the_guard_is_switched_on_while_it_drives(shown):
    shown.value("wmr.page.fleet.advance(20, 1e9)")
    before = shown.value("wmr.page.fleet.members.get('mb').robot.state.slice(0, 3).join()")
    shown.value("document.getElementById('guard').click()")
    after = shown.value("wmr.page.fleet.members.get('mb').robot.state.slice(0, 3).join()")

    assert shown.value("wmr.page.fleet.variant.guard")
    assert before == after
    assert shown.value("wmr.page.fleet.time") == pytest.approx(20.0)
    assert fastest(shown, "pid", 5.0) <= 1.0


def test_every_variant_of_every_scene_drives_on(shown):
    drove = shown.value(
        """(async () => {
          const { page } = wmr, laws = page.told.laws.map((law) => law.name);
          let driven = 0;
          for (const scene of page.told.scenes) {
            page.draw();
            page.fleet.overrides = {};
            page.fleet.begin(scene, scene.variants[0], laws);
            for (const variant of scene.variants) {
              if (variant.refusal) continue;
              page.fleet.take(variant);
              page.refresh();
              page.fleet.advance(0.2, 1e9);
              driven += 1;
            }
          }
          return driven;
        })()"""
    )
    assert drove > 50


def test_a_corridor_is_shown_as_long_as_only_the_scene_moves_the_robot(shown):
    tubes = "wmr.page.fleet.scene.tubes"
    kept = shown.value(f"JSON.stringify({tubes})")
    shown.value(f"{tubes} = {{mb: {{widths: [10, 20], every: 2, shown: '20 m', until: 5}}}}")
    text = "(wmr.page.board(), wmr.page.draw(), document.getElementById('certified'))"
    drawn = f"{text}.hidden ? '' : document.getElementById('certified').textContent"

    assert shown.value(drawn) == ""  # not a sample yet
    for what in (
        "wmr.page.push()", "wmr.page.nudge('ArrowUp')", "wmr.page.fleet.set({'robot.m': 51})",
        "wmr.page.variant({guard: true}), wmr.page.variant({guard: false})",
        "wmr.page.fleet.advance(5, 1e9)",
    ):  # fmt: skip
        shown.value(
            "wmr.page.fleet.replace({}), wmr.page.restart(), wmr.page.fleet.advance(1, 1e9)"
        )
        assert "MB within 20 m" in shown.value(drawn)
        shown.value(f"{what}, 1")
        assert shown.value(drawn) == "", what
    shown.value(f"{tubes} = {kept}")


def test_a_link_holds_the_settings(opened):
    one, url = opened
    link = "scene=slow&laws=mb.prox&guard=1&period=0.05&seed=3&speed=2&set=robot.m:70"
    show(one, url, link)

    assert one.value("wmr.page.link") == link
    assert one.value("wmr.page.fleet.members.get('mb').robot.period") == 0.05
    assert one.value("wmr.page.fleet.value('robot.m')") == 70
    assert one.said == []


def test_a_link_that_asks_for_too_much_is_followed_and_told_so(opened):
    one, url = opened
    notice = "document.getElementById('notices').textContent"

    show(one, url, "laws=mb.moon&period=0.03&set=robot.m:70,robot.mu:1e99")
    one.value("wmr.page.draw()")
    said = str(one.value(notice))
    assert one.value("wmr.page.fleet.value('robot.m')") == 70
    assert all(part in said for part in ("laws=moon", "period=0.03", "set=robot.mu:1e99"))
    assert not any(part in said for part in ("laws=mb", "robot.m:70"))

    show(one, url, "scene=slow&laws=mb&guard=1&period=5e-2&set=robot.m:70.0")
    one.value("wmr.page.draw()")
    assert "link" not in str(one.value(notice))


def test_a_number_that_cannot_be_is_refused_aloud(shown):
    shown.value(
        "(() => { const number = document.querySelector('#set-robot\\\\.m + input');"
        " number.value = '-5'; number.dispatchEvent(new Event('change')); })()"
    )

    assert "robot.m = -5 must be above 0" in shown.value(
        "document.getElementById('notices').textContent"
    )
    assert shown.value("wmr.page.fleet.value('robot.m')") == 50
    assert shown.value("document.querySelector('#set-robot\\\\.m + input').value") == "50"


def test_a_robot_is_dragged_and_thrown(shown):
    shown.value("wmr.page.draw()")
    x, y = shown.value(
        "(() => { const { plane, fleet } = wmr.page, seen = fleet.members.get('pid').seen;"
        " const box = plane.canvas.getBoundingClientRect();"
        " return [box.left + plane.X(seen.x), box.top + plane.Y(seen.y)]; })()"
    )
    shown.value(EVEN)
    shown.mouse("Pressed", x, y)
    for k in range(6):
        shown.mouse("Moved", x + 20 * k, y - 20 * k)
    held = shown.value("wmr.page.held.member.law")
    shown.mouse("Released", x + 100, y - 100)
    state = f"wmr.page.fleet.members.get('{held}').robot.state"

    assert shown.value(f"{state}[0]") > -0.4
    assert shown.value(f"{state}[1]") > -0.4
    assert shown.value(f"{state}[3]") != 0.0
    assert shown.value("wmr.page.held") is None


@pytest.mark.parametrize("dark", [False, True])
@pytest.mark.parametrize("size", [PHONE, SCREEN])
def test_nothing_is_wider_than_the_window(opened, size, dark):
    one, url = opened
    one.show(*size, dark=dark, touch=size == PHONE)
    one.open("about:blank")
    one.open(url, READY)

    assert one.value("document.documentElement.scrollWidth") <= size[0]
    assert one.said == []
