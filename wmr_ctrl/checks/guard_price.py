"""What the guard does not cover on this scenario, and whether it leaves enough speed."""

from __future__ import annotations

from collections.abc import Iterator

from wmr_ctrl.checks.barrier import phases
from wmr_ctrl.checks.loop import Loop
from wmr_ctrl.checks.warning import Warning
from wmr_ctrl.laws.guard_bounds import torque_limit, usable_speed
from wmr_ctrl.model.references import reference_bounds

PLACE = "guard, docs/guarantee.md"


def guard_price(loop: Loop) -> Iterator[Warning]:
    """Yield drives that act late, and a reference that is faster than the guard can allow."""
    if not loop.guarded:
        return
    if not loop.scenario.actuator.ideal:
        yield _late_drives(loop)
    fastest = reference_bounds(loop.scenario)[1]
    usable = slowest(loop)
    if fastest > usable:
        yield _too_fast(fastest, usable)


def slowest(loop: Loop) -> float:
    """Speed [m/s] that the guard leaves against the largest friction of the run."""
    scenario = loop.scenario
    friction = max(phase.m * phase.mu * scenario.robot.g for phase in phases(scenario))
    return usable_speed(scenario, (friction, 0.0), torque_limit(scenario, loop.law))[0]


def _late_drives(loop: Loop) -> Warning:
    actuator = loop.scenario.actuator
    key, time = ("lag", actuator.lag) if actuator.lag > 0 else ("delay", actuator.delay)
    return Warning(
        f"actuator.{key}",
        f"actuator.{key} = {time:g} s: the guard's theorem lets the torque act at once, so it "
        "filters but promises nothing here. Make the drives faster than clock.control by far, or "
        "keep away from the limit with a smaller guard.alpha.",
        PLACE,
    )


def _too_fast(fastest: float, usable: float) -> Warning:
    can = f"at most {usable:.3g} m/s" if usable > 0 else "no motion at all"
    return Warning(
        "guard.dbar",
        f"The reference asks for {fastest:.3g} m/s, and against friction the guard leaves {can}, "
        "v_u1 - nbar - (friction + dbar - f_min)/(M_min alpha): the robot falls behind. Shorten "
        "clock.control, or state a larger guard.M_min or a smaller guard.dbar if they are true.",
        PLACE,
    )
