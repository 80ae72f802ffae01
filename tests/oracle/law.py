"""Inputs and outputs of every law of the oracle."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from tests.oracle.barrier import BarrierTerms
from tests.oracle.target import DesiredState

Pair = tuple[float, float]
Triple = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Sight:
    """The loop as a law sees it at one control sample; pairs hold the axes (linear, angular)."""

    v: Pair
    """Measured velocity [m/s, rad/s], not clipped."""
    v_c0: Pair
    """Auxiliary velocity, Eq. (7) [m/s, rad/s]."""
    v_c0_dot: Pair
    """Its rate [m/s2, rad/s2]."""
    barrier: tuple[BarrierTerms, BarrierTerms]
    """Barrier terms of both axes, on the clipped velocity."""
    target: DesiredState
    """The desired state."""
    e: Triple
    """Tracking error of the measured pose, Eq. (8) [m, m, rad]."""
    pose: Triple
    """Measured pose [m, m, rad]."""
    k: Triple
    """Gains of Eq. (7)."""
    applied: Pair = (0.0, 0.0)
    """Mean torque (right, left) of the previous sample, behind the drives [N m]; 0 at first."""
    v_c0_dot_reference: Pair = (0.0, 0.0)
    """Contribution of the reference's acceleration to v_c0_dot [m/s2, rad/s2]."""
    sent: Sequence[Pair] = ()
    """Torques (right, left) commanded so far, the latest first [N m]."""
