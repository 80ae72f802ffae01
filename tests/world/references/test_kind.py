"""A reference that is not finite is refused by name, or named as the cause if a run meets it."""

from __future__ import annotations

from typing import ClassVar

import casadi as ca
import pytest

from wmr_ctrl.api import simulate
from wmr_ctrl.control.given import scenario_of
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.core.fields.section import quantity
from wmr_ctrl.world.references.kind import MOST_SAMPLES, Reference, ReferenceKind, timed
from wmr_ctrl.world.references.registry import REFERENCES


class Singular(Reference):
    """A line whose desired speed is not a number at one sample."""

    KIND: ClassVar[str] = "toy-singular"
    when: float = quantity(0.37, unit="s", doc="time at which there is no desired speed")


def trajectory(t, p):
    lost = ca.fabs(t - p["ref_when"]) < 1e-9
    return ca.vertcat(0.2 * t, ca.if_else(lost, ca.SX.nan(), 0), -ca.pi / 2, 0.2, 0, 0, 0)


@pytest.fixture(autouse=True)
def singular(monkeypatch):
    kind = ReferenceKind("toy-singular", Singular, timed(trajectory))
    monkeypatch.setitem(REFERENCES.__dict__, "plugins", (kind,))


def test_it_is_refused_before_a_run():
    with pytest.raises(ScenarioError, match=r'"toy-singular".*not finite at t = 0\.37 s'):
        scenario_of("paper-simulation", {"reference.kind": "toy-singular"})


def test_beyond_what_was_looked_at_the_run_blames_the_reference():
    period = 0.001
    when = (MOST_SAMPLES + 1234) * period
    changes = {
        "reference.kind": "toy-singular", "reference.when": when, "clock.control": period,
        "clock.duration": when + 1.0,
    }  # fmt: skip
    run = simulate("paper-simulation-nominal", "pid", overrides=changes)

    assert run.outcome == "non-finite"
    assert f"desired motion was no longer finite at t = {when:.6g} s" in run.explanation
