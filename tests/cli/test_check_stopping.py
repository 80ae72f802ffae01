"""A base before a wall, as the commands tell it."""

import json

import pytest

from tests.commands import flat
from tests.results.test_obstacles import WALLED
from tests.tables import cases

CART = WALLED.replace("[2.0, -2.0], [2.0, 2.0]", "[5.0, -2.0], [5.0, 2.0]").replace("12.0", "1.0")
BAND = " ".join(f"--set filter.{key}" for key in (
    "kind=band", "loop=second-order", "damping=[0.5,1]", "frequency=[3,4]", "odometry=none",
    "delay=[0.1,0.1]",
))  # fmt: skip


@pytest.fixture
def cart(tmp_path):
    path = tmp_path / "cart.toml"
    path.write_text(CART)
    return path


def test_check_tells_stops_and_what_they_cost(wmr, cart):
    told = json.loads(wmr(f"check {cart} --law kanayama --json").stdout)
    rows, costs = told["stopping"], told["stopping_costs"]
    parts = ("delay", "push", "brake", "error")
    assert [row["speed"] for row in rows] == [0.1, 0.25, 0.5, 0.75, 1.0]
    assert all(row["distance"] == pytest.approx(sum(row[key] for key in parts)) for row in rows)
    assert costs.keys() == {"millisecond", "per_cent", "rest_second"}
    assert "unknown-zero" in {item["key"] for item in told["warnings"]}
    assert "filter.nearing" in str(told["warnings"])
    lines = wmr(f"check {cart} --law kanayama --only filter").stdout
    assert "it stops within" in lines
    assert "from 1 to 0.9:" in flat(lines)


def test_check_tells_how_a_base_leaves(wmr, cart):
    pushed = (
        f"check {cart} --law kanayama --only filter --set filter.d=[0.05,0.05] --set filter.rest=1"
    )

    def lines(more):
        return " ".join(wmr(f"{pushed} {more}").stdout.split())

    assert "hold a command of at least 0.0556 m/s" in lines("")
    slower = "--set limits.v_min=[-0.05,-1] --set filter.nearing=0.2 --set filter.leave=0"
    assert "not sure to move it away from an obstacle ahead" in lines(slower)
    assert "only from an obstacle behind told" in lines(slower)
    assert "only from an obstacle told" not in lines(slower)
    assert "lowered from one [m/s] to another, backwards, is kept" in lines(slower)
    assert "may stop by itself between two" in lines("--set filter.losses=4 --set filter.hold=0.2")
    clip = "--set filter.kind=clip --set filter.decel=[1,2] --set filter.changing=false"
    assert "a clip does not count" in lines(clip)


@pytest.mark.parametrize(
    "command, words",
    [
        *cases("""
    codegen filter --scenario CART --float32 --out OUT | double precision
    check CART --law kanayama --set filter.channels=wheels | filter.channels
    check CART --law kanayama --set filter.rest=none | filter.rest
    check CART --law kanayama --set world.wall=[[1,2]] | world.wall
    check CART --law kanayama --set body.radius=none | body.radius
        """),
        (f"check CART --law kanayama {BAND}", "filter.changing"),
    ],
)
def test_what_cannot_be_is_refused(wmr, cart, command, words, tmp_path):
    done = wmr(command.replace("CART", str(cart)).replace("OUT", str(tmp_path / "c")))
    assert done.exit_code == 2
    assert words in flat(done.stderr)
