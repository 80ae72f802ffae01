"""Any error in a scenario gives one paragraph: the key first, then the rule and a remedy."""

import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.papers_robot import paper_toml
from tests.tables import cases
from wmr_ctrl.core.errors import ScenarioError, WmrError
from wmr_ctrl.world.scenario import Scenario, load_scenario

CASES = """
    robot.m = nan | robot.m = nan must be a finite number
    robot.m = 'heavy' | robot.m = "heavy" must be a number
    robot.m = 1e300 | robot.m = 1e+300 must be at most 1e+12
    limits.v_u1 = [1.0, nan] | limits.v_u1[2] = nan must be a finite number
    limits.v_u2 = [1.6, 1.3] | limits.v_u2[1] = 1.6 must be below limits.v_u1[1] = 1.0 m/s
    limits.clip = 0.25 | limits.clip = 0.25 must be below v_u1[1] - v_u2[1]
    clock.duration = 80.005 | clock.duration = 80.005 s must be a whole multiple
    clock.plant = 0.003 | clock.control = 0.01 s must be a whole multiple
    clock.duration = 1e9 | clock.duration = 1000000000.0 s is 1e+11 times
    sensor.pose_period = 0.025 | sensor.pose_period = 0.025 s must be a whole
    actuator.delay = 0.0005 | actuator.delay = 0.0005 s must be a whole multiple
    reference.kind = 'cirle' | reference.kind = "cirle" is not a kind of reference; near
    limits.v_u3 = 1 | limits.v_u3 is not a key in limits; near: v_u2, v_u1
    reference.speed = 1 | reference.speed is not a key in reference
    limit.v_u2 = 1 | limit is not a key at the top of a scenario; near: limits
    robot = 5 | robot = 5 must be a table, written as [robot]
    changes.t = 5 | changes = a table must be an array of tables, [[changes]]
    changes = [5] | changes[1] = 5 must be a table, written as [[changes]]
    changes = [{t = 80.0, m = 60.0}] | changes[1].t = 80.0 s must be before the run's end
    changes = [{t = 40.0, m = 60.0}, {t = 40.0, m = 3}] | changes[2].t = 40.0 s must be later than
    changes = [{t = 40.0, m = 60.0}, {t = 50.0}] | changes[2] changes nothing
    changes = [{m = 3}] | changes[1].t is missing
    changes = [{t = 40.0, m = 60.0}, {t = 50.0, mu = -1}] | changes[2].mu = -1 must be at least 0
    metrics.split = 80.0 | metrics.split = 80.0 s must be below clock.duration
    gains.mb.rho = [1.0, nan] | gains.mb.rho[2] = nan must be a finite number
    gains.rho = 1 | gains.rho = 1 must be a table of gains
    gains.mb.rho.a = 1 | gains.mb.rho = a table must be a number
    title = 3 | title = 3 must be text
    extends = 3 | extends = 3 must be a preset's name
    extends = 'paper-simulaton' | no scenario is named 'paper-simulaton'
    [robot | mine is not valid TOML
    robot = {m = 3, m = 4} | mine is not valid TOML
    reference = {kind='rounded-square', side=3, corner=2} | reference.corner = 2.0 must be at most
"""
POINTS = """
    points = [[0, 0]] | reference.points has 1 different point(s)
    points = [[0, 0], [1, 0]], closed = true | reference.points has 2 different
    points = [[0, 0], [1, 0], [1, 0]] | reference.points[2] and reference.points[3]
    points = [[0, 0], [1, 0], [0, 0]] | reference.points[2]: the path turns almost
    points = [[0, 0], [1, 0, 0]] | reference.points[2] = [1, 0, 0] must be a pair
    points = [[0, 0], [1, inf]] | reference.points[2][2] = inf must be a finite
    points = [[0, 0], [1, 0]], file = 'a' | reference.file and reference.points exclude
    file = 3 | reference.file = 3 must be the path
"""
OTHERS = {
    "a = " + "[" * 5000: "mine is not ",
    "a = 1" + "0" * 5000: "mine is not valid TOML",
    "reference.kind = 'waypoints'": "reference.points has 0 different point(s)",
}


def assert_refused(text, message):
    with pytest.raises(WmrError) as caught:
        paper_toml(text, "mine")
    assert str(caught.value).startswith(message)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 700


@pytest.mark.parametrize("text, message", [*cases(CASES), *OTHERS.items()])
def test_error_names_the_key(text, message):
    assert_refused(text, message)


@pytest.mark.parametrize("points, message", cases(POINTS))
def test_error_names_the_point(points, message):
    assert_refused(f"reference = {{kind = 'waypoints', {points}}}", message)


@pytest.mark.parametrize(
    "name, message",
    [
        ("missing.toml", "there is no file"),
        ("./missing", "there is no file"),
        ("folder.toml", "is a directory"),
        ("folder", "is a directory"),
        ("x" * 5000 + ".toml", "cannot be read"),
    ],
)
def test_files_that_cannot_be_read(tmp_path, monkeypatch, name, message):
    monkeypatch.chdir(tmp_path)
    for folder in ("folder", "folder.toml"):
        (tmp_path / folder).mkdir()

    with pytest.raises(ScenarioError, match=message) as caught:
        load_scenario(name)
    assert len(str(caught.value)) < 700


@pytest.mark.parametrize(
    "name, text",
    [
        ("environ", "TOKEN=secret"),
        ("notes.txt", "TOKEN=secret"),
        ("a.env", 'token = "secret"'),
        ("way.env", "secret,secret\n1,1\n"),
        ("way", "secret: [secret]"),
    ],
)
@pytest.mark.parametrize("key", ["extends", "reference.file", ""])
def test_nothing_is_quoted_of_a_file_of_another_kind(tmp_path, name, text, key):
    (tmp_path / name).write_text(text)
    kind = 'kind = "waypoints"\n' if key else ""
    table = f'[reference]\n{kind}file = "{name}"' if "." in key else f'extends = "./{name}"'
    (tmp_path / "mine.toml").write_text(table)

    with pytest.raises(ScenarioError, match=r"secret|must end in") as caught:
        load_scenario(tmp_path / ("mine.toml" if key else name))
    told = str(caught.value)
    assert "must end in" in told or (key == "reference.file" and name == "notes.txt")
    assert ("secret" in told) == ("must end in" not in told)


def one_paragraph_or_none(load):
    """Return whether loading gives a scenario or an error of one line."""
    try:
        return isinstance(load(), Scenario)
    except WmrError as problem:
        return re.fullmatch(r"[^\n\r]+", str(problem)) is not None


@settings(max_examples=3 * settings.default.max_examples)
@given(st.binary(max_size=200))
def test_random_bytes_never_give_a_traceback(data):
    assert one_paragraph_or_none(lambda: paper_toml(data))


@pytest.mark.parametrize("text", ["[robot]\nmm = 3\n", "[robot]\nr = -1\n"])
def test_an_error_names_the_file_that_it_is_in(tmp_path, text):
    file = tmp_path / "mine.toml"
    file.write_text(text)
    with pytest.raises(ScenarioError, match=r"^robot\..*mine\.toml\.\)$"):
        load_scenario(file)
    file.write_text("")
    with pytest.raises(ScenarioError, match=r"[^)]$"):
        load_scenario(file, {"robot.r": -1})
