"""Commands to a base that takes velocities, and the memory of the commands sent."""

import casadi as ca
import numpy as np
import pytest

from tests.control.bases import VELOCITY, based
from wmr_ctrl.control.controller import law_graph, velocity_sender
from wmr_ctrl.control.setup import settle
from wmr_ctrl.control.velocity import NEAR


def sender(law):
    setup = settle(based(VELOCITY), law)
    return velocity_sender(setup, law_graph(setup))


def test_a_velocity_that_a_law_asks_for_is_asked_for_as_it_is():
    sent = sender("kanayama")

    assert ca.is_equal(sent.asked, sent.wish, 9)
    assert [item.signal.name for item in sent.asking().outputs] == ["v_asked"]


def test_a_force_is_the_velocity_to_which_it_leads_and_friction_leads_nowhere():
    sent = sender("mb")
    still = ca.substitute(sent.asked, ca.vertcat(*ca.symvar(sent.wish)), 0)
    assert not ca.is_equal(sent.asked, sent.wish, 9)
    assert still.shape == (2, 1)
    gone = sent.v + sent.reach * (sent.wish - sent.F1) / sent.mass
    assert ca.is_equal(sent.asked, gone, 9)


@pytest.mark.parametrize("off, learns", [(0.0, True), (0.5 * NEAR, True), (0.1, False)])
def test_estimates_stay_while_another_velocity_is_sent(off, learns):
    sent = sender("smc")
    near, symbols = (
        sent._learnt(sent.asked + off),
        ca.symvar(ca.vertcat(sent.asked, sent.core.update)),
    )
    numbers = np.random.default_rng(1).uniform(0.1, 1.0, len(symbols))
    both = ca.Function("both", symbols, [near, sent.core.update, sent.core.x])(*numbers)
    after, learnt, kept = (item.full() for item in both)

    assert (after == (learnt if learns else kept)).all()
