"""Theorem 2 of the paper, for the adaptive network law that runs.

"For the system described by (1), with the control law (57) and adaptive laws (58), for initial
states satisfying the constraints |v_i| < v_u1i, i = 1, 2, the states of the system would not
violate the constraints.  When |v_c0i| < v_u2i, i = 1, 2, the closed-loop control system is
semiglobally uniformly ultimately bounded."

The following holds: the law is Eq. (57), its weights follow Eq. (58), and V3' <= -rho2 V3 + C on
each axis, with C from the residual eps2 of Eq. (59).  But eps2 has no bound where the barrier acts,
so the limits do not follow.
"""

import pytest

from tests.proofs.anew import altered, assert_proved, claim_of, verdict
from wmr_ctrl.control.laws import nn


def test_law_is_equation_57():
    assert_proved("eq57")


@pytest.mark.parametrize("axis", ["", ".angular"])
def test_weights_follow_equation_58(axis):
    assert_proved(f"eq58{axis}")


def test_v3_falls_at_the_rate_rho2_up_to_a_constant():
    """V3' <= -rho2 V3 + C, and rho2 of Eq. (86) is small enough for both axes."""
    assert_proved("eq84-85")
    assert_proved("eq86")


def test_residual_has_no_bound_where_the_barrier_acts():
    assert verdict(claim_of("eq59.printed")) == "REFUTED"


def test_law_that_unlearns_is_refuted():
    with altered(nn._adapted, "* weights - learning", "* weights + learning"):
        assert verdict(claim_of("eq58")) == "REFUTED"
