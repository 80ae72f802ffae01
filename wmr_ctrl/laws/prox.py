"""Sampled-data barrier law (prox): an exact step of V1's gradient flow.

Source: the backward Euler step of v' = -(rho/2) dV1/dv, which has a closed form since the barrier's
proximal map has one (`resolvent`).  With E = exp(-rho T/2), c = v_c0 and c+ = c + T c':

    v*   = v + X_1(c+) - X_1(c),      v+ = X_(1-E)(E v* + (1-E) c+)
    F    = M1 (v+ - v)/T + F1(v) + observer

Differences from the paper: not in it.  Law (9) divides V1 by its slope and loses its authority at
the limit; this one follows the slope.  With the model exact, V1 at c+ falls by at least exp(-rho T)
from v* to v+ for every control period: while the target is held, where v* = v, that is the decay of
V1; a target that moves can raise it first.  Over the real numbers |v+| < v_u1 for every measured v,
inside the limit or not (proved for the paper's barrier).  The observer (wo = 0 switches it off)
makes up for friction and mass that differ from the model.  The first samples ask for much torque,
so the law brings a limit of its own, tau_max, which counts where it is below actuator.tau_max.
Choose it for slow control periods, for unknown friction, and behind the guard.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import casadi as ca

from wmr_ctrl.barrier.resolvent import resolvent
from wmr_ctrl.fields.section import quantity
from wmr_ctrl.laws.law import BarrierChoice, Law, TorqueLimited, Traits
from wmr_ctrl.laws.observer import Observer
from wmr_ctrl.laws.sample import AXES, Sample
from wmr_ctrl.model.system import System


@dataclass(frozen=True, kw_only=True)
class ProxGains(BarrierChoice, TorqueLimited):
    """Gains of the prox law, per axis (linear, angular) where there are two."""

    KEY: ClassVar[str] = "gains.prox"

    rho: tuple[float, float] = quantity(
        (15.0, 57.6), unit="1/s", doc="decay rate of V1 per axis", above=0.0
    )
    wo: float = quantity(
        10.0, unit="1/s", doc="bandwidth of the disturbance observer, 0 = off", minimum=0.0
    )


def build(sample: Sample) -> System:
    """F = M1 (v+ - v)/T + F1 + observer, with the step v+ above."""
    observer = Observer(sample, sample.gain("wo"), sample.friction_at)
    step = ca.vertcat(*(next_velocity(sample, i) for i in AXES))
    asked = sample.mass * (step - sample.v) / sample.period + sample.friction
    return sample.system(
        "sampled-data barrier law (prox)",
        asked + observer.force,
        observer.state,
        observer.update,
        observer.diagnostics,
        (observer.input,),
    )


def next_velocity(sample: Sample, i: int) -> ca.SX:
    """v+ of axis ``i`` [m/s or rad/s]: where the law wants the velocity after one period."""
    half = -0.5 * sample.gain("rho")[i] * sample.period
    target = sample.v_c0[i]
    return prox_step(
        sample.v[i],
        target,
        target + sample.period * sample.v_c0_dot[i],
        (ca.exp(half), -ca.expm1(half)),
        (sample.u1[i], sample.u2[i]),
        sample.smooth,
    )


def prox_step(
    v: ca.SX,
    c: ca.SX,
    c_next: ca.SX,
    shares: tuple[ca.SX, ca.SX],
    limits: tuple[ca.SX, ca.SX],
    smooth: bool,
) -> ca.SX:
    """v+ = X_(1-E)(E (v + X_1(c+) - X_1(c)) + (1-E) c+) for shares (E, 1-E), limits (u1, u2)."""
    one = ca.SX(1)
    moved = v + resolvent(c_next, one, *limits, smooth) - resolvent(c, one, *limits, smooth)
    keep, rest = shares
    return resolvent(keep * moved + rest * c_next, rest, *limits, smooth)


LAW = Law(
    "prox",
    ProxGains,
    build,
    Traits(auxiliary=True, barrier=True, model=True, estimates=True),
    __doc__ or "",
)
