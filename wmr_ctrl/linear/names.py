"""Names of the catalogue of signals as python-control wants them: one text per element."""

from __future__ import annotations

from collections.abc import Iterable

from wmr_ctrl.signals import FORCE, TRACKING_ERROR, VELOCITY, Signal

DISTURBANCE = Signal(
    "disturbance", "N, N.m", "disturbing generalised force (thrust, turning moment)", 2
)
APPLIED = Signal("force_applied", "N, N.m", "generalised force behind the drives' lag", 2)
V_D = Signal("v_d", "m/s, rad/s", "desired velocity", 2)
V_D_DOT = Signal("v_d_dot", "m/s2, rad/s2", "rate of the desired velocity", 2)

ERROR_STATE = (TRACKING_ERROR, *VELOCITY)
"""e (3), v1, omega: the robot seen from its reference."""


def element_names(signals: Iterable[Signal]) -> list[str]:
    """Names of all elements in order: ``e[1]``, ``e[2]``, ``e[3]``, ``v1``, ``omega``, ..."""
    return [name for signal in signals for name in signal.elements]


FORCES = element_names((FORCE,))
DISTURBANCES = element_names((DISTURBANCE,))
STATES = element_names(ERROR_STATE)
