"""Limit of the wheels' speeds in the firmware: it couples v and omega.

Source: differential-drive drivers, which turn (v, omega) into wheel speeds v +- l omega over r and
clip each at ``w_max``.  A fast turn loses both speed and curvature. |v| and |omega| never grow and
never change their sign, since clipping is odd and monotone.
"""

import math

from wmr_ctrl.core.fields.section import Section, quantity
from wmr_ctrl.core.signals import COMMAND
from wmr_ctrl.core.symbolic import ca

from .effect import Bound, Effect, EffectRole, Rate, Scenario
from .model.system import Parameters, System, outputs, ports


class WheelSpeedLimit(Section, key="base"):
    """Largest speed of each wheel."""

    w_max: float = quantity(
        math.inf, "rad/s", "speed at which the firmware clips each wheel; inf: none",
        above=0, infinite=True, usual=(0, 100),
    )  # fmt: skip


def build(scenario: Scenario) -> System:
    """Plant-rate System: from arriving to acting command [m/s, rad/s]."""
    (v, omega), p = ports(COMMAND), Parameters(scenario)
    half_track, rim = p.take("robot.l"), p.take("robot.r") * p.take("base.w_max")
    right, left = (
        ca.fmax(-rim, ca.fmin(rim, v.sym + side * half_track * omega.sym)) for side in (1, -1)
    )
    title = "limit of the wheels' speeds"
    shown = outputs(COMMAND, ca.vertcat((right + left) / 2, (right - left) / (2 * half_track)))
    return System("wheel_speed_limit", title, inputs=(v, omega), params=p.ports, outputs=shown)


def bound(scenario: Scenario) -> Bound:
    """Hidden effect: the governor assumes that the command it sent acts, and another one does."""
    return Bound(hidden="base.w_max: the firmware clips the wheels' speeds.")


WHEEL_SPEED_LIMIT = Effect(
    "wheel speed limit", EffectRole.COMMAND, WheelSpeedLimit, build, bound, rate=Rate.STEP
)
