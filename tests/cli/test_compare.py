"""`wmr-ctrl compare`: laws side by side; two runs, 0 if they are equal or agree, 1 for others."""

import json

import pytest

from tests.commands import flat
from tests.tables import cases


@pytest.fixture
def saved(short_run, tmp_path):
    def save(name, *args):
        path = tmp_path / name
        assert short_run("paper-simulation", *args, "--out", path).exit_code == 0
        return path

    return save


def test_differing_runs(wmr, saved):
    runs = saved("a.npz"), saved("b.npz", "--seed", 1)
    told, found = wmr("compare", *runs), wmr("compare", *runs, "--json")
    document = json.loads(found.stdout)

    assert (told.exit_code, found.exit_code, told.stderr) == (1, 1, "")
    assert "DIFFER" in told.stdout
    assert (document["verdict"], document["rows"]) == ("differ", 20)
    assert {"name": "seed", "in_a": "0", "in_b": "1"} in document["facts"]


def test_more_than_two_runs_are_a_table(wmr, saved):
    names = [saved(f"{seed}.npz", "--seed", seed) for seed in range(3)]
    found = wmr("compare", *names)

    assert found.exit_code == 0
    assert "DIFFER" not in found.stdout
    assert all(name.name in found.stdout for name in names)


@pytest.mark.parametrize(
    "arguments, said",
    cases("""
    --law pid,pif | near: pid
    --law "" | law
    far-start paper-simulation --law pid | runs one scenario
    far-start | Missing option '--law'
    --json | Missing option '--law'
    """),
)
def test_what_cannot_be_compared_is_told(wmr, arguments, said):
    found = wmr(f"compare {arguments}")

    assert found.exit_code == 2
    assert said in flat(found.stderr)
