"""PID on the velocity error (a PD: the paper gives no integral gain).

Source: Section V, K_p = diag(210, 1.1), K_d = diag(0.64, 0.08).  Differences from the paper: the
paper does not say what the three gains act on; read here as z = v - v_c0 with the derivative by a
backward difference, giving a generalised force before B1^-1 (of the meanings tried, the one with
believable wheel torques).  Choose it only to compare with: it knows no velocity limit.
"""

from collections.abc import Mapping

import casadi as ca

from wmr_ctrl.core.fields.section import quantity
from wmr_ctrl.core.signals import Signal
from wmr_ctrl.world.model.system import System, port

from .context import LawContext
from .law import Basis, Law, OwnKinematics, Traits

Z_OLD = Signal("z_previous", "m/s, rad/s", "velocity error of the previous sample", 2)
STARTED = Signal("started", "1", "0 before the first sample, then 1")


class PidGains(OwnKinematics, key="gains.pid"):
    """Gains of the PID law, per axis (linear, angular)."""

    Kp: tuple[float, float] = quantity(
        (210.0, 1.1), "N.s/m, N.m.s/rad", "proportional gain", minimum=0.0
    )
    Kd: tuple[float, float] = quantity((0.64, 0.08), "kg, kg.m2", "derivative gain", minimum=0.0)


def build(context: LawContext) -> System:
    """F = -Kp z - Kd z', z = v - v_c0; z' = 0 at the first sample."""
    old, started = port(Z_OLD), port(STARTED)
    z = context.v - context.v_c0
    rate = ca.if_else(started.sym > 0, (z - old.sym) / context.period, 0)
    force = -context.gain("Kp") * z - context.gain("Kd") * rate
    return context.system("PID", force, (old, started), ca.vertcat(z, 1))


def rule(basis: Basis) -> Mapping[str, object]:
    """Gains derived from the robot and its path."""
    return {"Kp": basis.damping, "Kd": (0.0, 0.0)}


LAW = Law("pid", PidGains, build, Traits(auxiliary=True), __doc__, tuned=("Kp", "Kd"), rule=rule)
