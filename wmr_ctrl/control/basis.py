"""Robot, base and path of a scenario, in the numbers from which laws derive their gains."""

from wmr_ctrl.world.effect import total
from wmr_ctrl.world.references.kind import fastest_of
from wmr_ctrl.world.registry import EFFECTS
from wmr_ctrl.world.scenario import Scenario
from wmr_ctrl.world.speed_loops import assumed_lags

from .laws.law import Basis
from .laws.prox import guide

SLOWEST = 0.05
"""Least speed of a path that gains are derived for, as a share of the limit."""
REACHED = 4.0
"""Rate of commands [1/s], times the limits, where the base states none."""

ANY_BASIS = Basis(
    k=(1.0, 1.0, 1.0), rho=(1.0, 1.0), wo=1.0, speed=1.0, mass=(1.0, 1.0), weight=1.0,
    limits=(1.0, 1.0), accel=(1.0, 1.0),
)  # fmt: skip
"""Any basis, for lists of a rule's gains, which are the same for all."""


def basis_of(scenario: Scenario) -> Basis:
    """The numbers from which unstated gains are derived.

    The total delay includes commands, drives, half of the time constant of the base's own loop, and
    sensors.
    """
    base, limits, believed = scenario.base, scenario.limits.v_u1, scenario.believed
    bounds = (item.bounded(scenario) for item in EFFECTS.present(scenario))
    bound = total([item for item in bounds if item is not None])
    late = bound.delay + bound.lag[1] + max(bound.age) + max(bound.window) / 2
    if scenario.takes_velocity:
        late += max(assumed_lags(scenario)) / 2
    speed = max(fastest_of(scenario), SLOWEST * limits[0])
    fit = guide(scenario.clock.control, late, speed)
    accel = tuple(min(a, REACHED * v) for a, v in zip(base.accel, limits, strict=True))
    return Basis(
        k=fit.k,
        rho=fit.rho,
        wo=fit.wo,
        speed=speed,
        mass=(float(believed.m), float(believed.I)),
        weight=believed.m * believed.g * believed.r,
        limits=limits,
        accel=(accel[0], accel[1]),
    )
