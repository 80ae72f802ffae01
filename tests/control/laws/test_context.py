"""The context that a law receives at a control sample."""

import casadi as ca
import pytest

from tests.papers_robot import paper
from wmr_ctrl.control.controller import law_graph
from wmr_ctrl.control.laws.context import LawContext, own_diagnostics
from wmr_ctrl.control.laws.pid import PidGains
from wmr_ctrl.control.setup import settle


def test_at_another_instant_it_is_the_same_law():
    context = LawContext(settle(paper(), "mb"))
    _ = context.e
    desired = ca.SX([1.0, 2.0, 0.3]), ca.SX([0.4, 0.2]), ca.SX([0.0, 0.0])
    other = context.at(desired, ca.SX([1.0, 2.0, 0.3]), ca.SX([0.4, 0.2]))

    assert other.e.is_zero()
    assert other.parameters is context.parameters
    assert not context.e.is_zero()


def test_gains_are_of_the_law_and_its_own_diagnostics_come_last():
    context = LawContext(settle(paper(), "mb"))

    assert str(context.gain("rho")[0]) != str(context.gain("rho")[1])
    with pytest.raises(AssertionError, match="mb: gains are not"):
        context.own(PidGains)
    assert own_diagnostics(law_graph(settle(paper(), "mb"))) == ()
    shown = [item.name for item in own_diagnostics(law_graph(settle(paper(), "smc")))]
    assert shown == ["m_hat", "F_hat"]
