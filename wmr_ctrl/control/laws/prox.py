"""Sampled-data barrier law (prox): an exact step of V1's gradient flow, for a moving target.

Source: the backward Euler step of v' = -(rho/2) dV1/dv, which has a closed form since the barrier's
proximal map has one (`resolvent`).  With E = exp(-rho T/2), c = v_c0 and c+ = c + T c':

    v*   = v, carried from c to c_m so that V1 does not rise (`transported`)
    v+   = X_(1-E)(E v* + (1-E) c+)
    F    = M1 (v+ - v)/T + F1(v+) + observer

Differences from the paper: not in it.  Law (9) divides V1 by its slope and loses its authority at
the limit; this one follows the slope.  With the model exact, for every period T and every motion of
the target, and with S = sqrt(2 V1), w = v - v_c1:

    S(v+; c+) <= E (S(v; c) + |c+ - c_m|),    |w+| <= E (|w| + |c+ - c_m|),    |v+| < v_u1

transport = "two-part": c_m is c moved by the reference's own acceleration.  The part of the
target's motion that the robot causes is not fed forward, since it would count twice and need much
torque. transport = "level": c_m = c+, so that V1 falls by exp(-rho T) in a sample.  The observer
(wo = 0 switches it off) compensates friction and mass that differ from the model.  With delay > 0
all of this is about the instant at which the command acts (see `prediction`).  The first samples
need much torque, so the law has its own limit, tau_max, which applies if it is below
actuator.tau_max.  Choose it for slow control periods, for unknown friction, and behind the guard.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import log1p

import casadi as ca

from wmr_ctrl.control.barrier.proximal import resolvent, transported
from wmr_ctrl.core.fields.section import quantity
from wmr_ctrl.world.model.system import System

from .context import AXES, LawContext
from .law import (
    BarrierChoice,
    Basis,
    Inside,
    Law,
    OwnKinematics,
    Predicting,
    TorqueLimited,
    Traits,
)
from .observer import Observer
from .prediction import ahead

GRIP = 0.4
"""Torque of a wheel that tyres just pass on, over the weight times the wheels' radius."""
TRANSPORTS = ("two-part", "level")
"""Part of the target's way that the velocity is carried along: the reference's share, or all."""


class ProxGains(BarrierChoice, TorqueLimited, Predicting, OwnKinematics, key="gains.prox"):
    """Gains of the prox law, per axis (linear, angular) where there are two."""

    rho: tuple[float, float] = quantity((15.0, 57.6), "1/s", "decay rate of V1 per axis", above=0.0)
    wo: float = quantity(10.0, "1/s", "bandwidth of the disturbance observer, 0 = off", minimum=0.0)
    transport: str = quantity(
        "two-part",
        "1",
        "what carries the velocity along: the reference's acceleration (two-part), or the "
        "whole way of the target (level)",
        options=TRANSPORTS,
    )


@dataclass(frozen=True)
class Guide:
    """Gains to start from: k of Eq. (7), and rho and wo of this law."""

    k: tuple[float, float, float]
    rho: tuple[float, float]
    wo: float


def guide(period: float, delay: float, speed: float, predicted: bool = False) -> Guide:
    """Gains for the two-part law at a control period and a drive delay [s], for a reference speed.

    ``speed`` is v1_d [m/s]; ``predicted``: the law's own delay equals that of the drives.  Poles
    are real: p1 along the path, p2 twice across it, and the same in the velocity loop below each.
    The loop is stable for a mass of 0.6 to 1.6 times the believed one, which the tests try.  Above
    16.8 and 5.6 1/s a far start spins.  ValueError unless period, speed > 0 and delay >= 0.
    """
    if not (period > 0 and speed > 0 and delay >= 0):
        raise ValueError(
            f"guide needs period, speed > 0 and delay >= 0, and was given {period!r}, {speed!r} "
            f"and {delay!r}."
        )
    h = max(period, 0.7 * period + 0.5 * delay if predicted else 2 * delay)
    p1, p2 = min(16.8, 0.50 / h), min(5.6, 0.36 / h)
    rho1, rho2 = (-2 / period * log1p(-p * period) for p in (p1, p2))
    k = (p1, (p2 / (2 * speed)) ** 2, p2)
    return Guide(k, (rho1, rho2), min(10.0, 0.45 / (period + delay)))


def build(context: LawContext) -> System:
    """F = M1 (v+ - v)/T + F1(v+) + observer, with the step v+ above."""
    return _around(context, next_velocity)


def inside(context: LawContext) -> Inside:
    """The law below v_u2: v* = v + c_m - c (ledger: transport.plain), v+ = E v* + (1-E) c+."""
    within: dict[str, tuple[ca.SX, ca.SX]] = {}

    def step(then: LawContext) -> ca.SX:
        followed, target = targets(then)
        carried = carried_plainly(then.v, then.v_c0, followed)
        after = mixture(carried, target, _shares(then))
        sizes = {"v": then.v, "v_c0": then.v_c0, "c_m": followed, "v*": carried, "v+": after}
        within.update((name, (size, then.u2)) for name, size in sizes.items())
        return after

    return Inside(_around(context, step), within)


def _around(context: LawContext, step_of: Callable[[LawContext], ca.SX]) -> System:
    """The law whose step to v+ is ``step_of``."""
    observer = Observer(context, context.gain("wo"), context.friction_at)
    then, sent = ahead(context, observer.force)
    step = step_of(then)
    asked = context.mass * (step - then.v) / context.period + context.friction_at(step)
    force, inputs = asked + observer.force, (observer.input, *sent)
    title = "sampled-data barrier law (prox)"
    return context.system(
        title, force, observer.state, observer.update, observer.diagnostics, inputs
    )


def next_velocity(context: LawContext) -> ca.SX:
    """v+ (2,) [m/s, rad/s]: velocity that the law aims at after one period."""
    old, new = _shares(context)
    followed, target = targets(context)
    steps = []
    for i in AXES:
        way, limits = (context.v_c0[i], followed[i], target[i]), (context.u1[i], context.u2[i])
        steps.append(prox_step(context.v[i], way, (old[i], new[i]), limits, context.smooth))
    return ca.vertcat(*steps)


def _shares(context: LawContext) -> tuple[ca.SX, ca.SX]:
    """E and 1 - E, (2,) each."""
    halves = -0.5 * context.gain("rho") * context.period
    return ca.exp(halves), -ca.expm1(halves)


def targets(context: LawContext) -> tuple[ca.SX, ca.SX]:
    """c_m and c+, (2,) each [m/s, rad/s]: target of v's transport, and next v_c0."""
    target = context.v_c0 + context.period * context.v_c0_dot
    if context.own(ProxGains).transport == "level":
        return target, target
    return context.v_c0 + context.period * context.v_c0_dot_reference, target


def prox_step(
    v: ca.SX,
    way: tuple[ca.SX, ca.SX, ca.SX],
    shares: tuple[ca.SX, ca.SX],
    limits: tuple[ca.SX, ca.SX],
    smooth: bool,
) -> ca.SX:
    """v+ = X_(1-E)(E v* + (1-E) c+) for targets ``way`` (c, c_m, c+), shares (E, 1-E) and limits
    (u1, u2).
    """
    c, followed, target = way
    carried = transported(v, c, followed, limits, smooth)
    return resolvent(mixture(carried, target, shares), shares[1], *limits, smooth)


def carried_plainly(v: ca.SX, c: ca.SX, followed: ca.SX) -> ca.SX:
    """v* below v_u2: v, moved by the same amount as the target from c to c_m."""
    return v + (followed - c)


def mixture(v: ca.SX, target: ca.SX, shares: tuple[ca.SX, ca.SX]) -> ca.SX:
    """E v* + (1-E) c+."""
    return shares[0] * v + shares[1] * target


def rule(basis: Basis) -> Mapping[str, object]:
    """Gains derived from the robot and its path."""
    return {"rho": basis.rho, "wo": basis.wo, "tau_max": GRIP * basis.weight}


TRAITS = Traits(auxiliary=True, barrier=True, model=True, observer=True)
LAW = Law("prox", ProxGains, build, TRAITS, __doc__, tuned=("rho", "wo"), inside=inside, rule=rule)
