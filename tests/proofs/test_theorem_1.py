"""Theorem 1 of the paper, for the model-based law that runs.

"For the system described by (1), with the control law (9), for initial states satisfying the
constraints |v_i| < v_u1i, i = 1, 2, the states of the system would not violate the constraints.
When |v_c0i| < v_u2i, i = 1, 2, velocity error signals z and position error signals e would converge
to zero."

The following holds on an axis: V1 falls as exp(-rho t), if the model is exact and nothing pushes
the robot.  V1 has no bound at the limit, so the limit is kept; and z^2 <= 2 V1 if |v_c0| < v_u2.
The convergence of e from everywhere does not hold, since the error has a second equilibrium.
"""

import pytest

from tests.proofs.anew import altered, assert_proved, claim_of, verdict
from wmr_ctrl.control.laws import mb

AXES = pytest.mark.parametrize("axis", ["", "-angular"])


@AXES
def test_v1_falls_at_the_rate_rho_under_the_model_based_law(axis):
    """V1' = -rho V1 on the graph of the compiled law, including A = 0."""
    assert_proved(f"eq30.law{axis}")


def test_target_is_the_only_minimiser_of_the_cost():
    """v_c1 of Eq. (18) minimises (v - v_c0)^2/2 + f(v), and the cost rises with the distance."""
    assert_proved("eq17-18")
    assert_proved("eq18.inside")


def test_v1_bounds_the_velocity_error():
    """V1 >= (v - v_c1)^2/2, so z^2 <= 2 V1 where |v_c0| < v_u2."""
    assert_proved("eq81")
    assert_proved("thm1.velocity")


def test_position_error_has_a_second_rest():
    assert verdict(claim_of("thm1.global")) == "REFUTED"


@AXES
def test_law_with_twice_the_barrier_gain_is_refuted(axis):
    with altered(mb.build, 'context.per_axis("V1_over_A")', '2 * context.per_axis("V1_over_A")'):
        assert verdict(claim_of(f"eq30.law{axis}")) == "REFUTED"
