"""The contenders of the match: laws, filters before them and predictive controllers.

The nominal CBF-QP keeps v' <= alpha (v_u1 - v) for the believed robot; per axis the QP is a clip.
The sampled-data CBF adds the global margin for a held input, (Lipschitz constant of the condition)
times (largest speed of the state) times T, after J. Breeden, K. Garg, D. Panagou, Control Barrier
Functions in Sampled-Data Systems (arXiv:2103.03677), with worst-case mass and disturbance.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.control.controller import controller, law_graph
from wmr_ctrl.control.given import scenario_of
from wmr_ctrl.control.guard.guard import linear_first
from wmr_ctrl.control.laws import LAWS
from wmr_ctrl.control.setup import settle
from wmr_ctrl.simulation.tuning import tunable
from wmr_ctrl.world.model.dynamics import force_to_wheel, wheel_to_force
from wmr_ctrl.world.model.friction import friction
from wmr_ctrl.world.model.system import System
from wmr_ctrl.world.scenario import Scenario, override

Floats = NDArray[np.float64]
Step = Callable[[Floats, Floats, Floats], Floats]
"""Reference rows from now on (N, 7), pose and velocity (5), torque applied before (2) -> torque."""

TAU, ARM, TRACK = 20.0, 0.1, 0.25
PHI = 2 * TAU / ARM
BELIEVED = {"m": 50.0, "I": 5.4, "mu": 0.08}
LOW, HIGH = np.array((45.0, 4.86)), np.array((71.5, 7.7))
DBAR = np.array((60.0, 15.0))
LIMIT = np.array((1.0, 1.5))
HORIZON, LONGEST = 8, 0.05
"""Steps in a predictive controller's horizon, and least length of a step [s]."""


@dataclass(frozen=True)
class Case:
    """Control period, delay, and duration of runs [s]."""

    period: float
    delay: float
    track: float = 8.0
    attack: float = 5.0

    @property
    def scenario(self) -> Scenario:
        """Scenario that contenders receive."""
        return scenario_of(
            "safe-simulation",
            {
                "clock.control": self.period, "actuator.delay": self.delay,
                "actuator.tau_max": TAU, "clock.duration": 60.0, "changes[1].t": 30.0,
                "guard.M_min": LOW.tolist(), "guard.M_max": HIGH.tolist(),
                "guard.dbar": DBAR.tolist(),
                "gains.prox.delay": self.delay, "gains.kanayama.delay": self.delay,
            },
        )  # fmt: skip


@dataclass(frozen=True)
class Contender:
    """Name, initial gains, and function from gains to a controller."""

    name: str
    start: Callable[[Case], dict[str, tuple[float, ...]]]
    build: Callable[[Case, Mapping[str, tuple[float, ...]]], Step]


def law(name: str, *, guard: bool) -> Contender:
    """A law of the product, behind the guard or as it is."""

    def build(case: Case, gains: Mapping[str, tuple[float, ...]]) -> Step:
        setup = settle(_with(override(case.scenario, {"guard.enabled": guard}), gains), name)
        act, x = _act(controller(setup)), None

        def step(rows: Floats, state: Floats, _before: Floats) -> Floats:
            nonlocal x
            x, torque = act(np.concatenate((rows[0], state)), x)
            return torque

        return step

    return Contender(
        f"{name} + {'guard' if guard else 'clip'}", lambda case: _start(name, case), build
    )


def filtered(title: str, ceiling: Callable[[Case, Floats], Floats]) -> Contender:
    """Contender: prox with its force limited to ``ceiling(v)`` and -``ceiling(-v)`` (2)."""

    def build(case: Case, gains: Mapping[str, tuple[float, ...]]) -> Step:
        setup = settle(_with(override(case.scenario, {"guard.enabled": False}), gains), "prox")
        act, x, sent = _act(law_graph(setup)), None, np.zeros(2)

        def step(rows: Floats, state: Floats, before: Floats) -> Floats:
            nonlocal x, sent
            x, force = act(np.concatenate((rows[0], state, before, sent)), x)
            low, high = -ceiling(case, -state[3:]), ceiling(case, state[3:])
            sent = _wheels(np.minimum(np.maximum(force, low), np.maximum(high, low)))
            return sent

        return step

    return Contender(title, lambda case: _start("prox", case), build)


def nominal_ceiling(case: Case, v: Floats) -> Floats:
    """Largest force (2) with v' <= alpha (v_u1 - v), alpha = 1/T, for the believed robot."""
    mass = np.array((BELIEVED["m"], BELIEVED["I"]))
    drag = np.array((BELIEVED["mu"] * BELIEVED["m"] * 9.81 * np.tanh(v[0] / 0.01), 0.0))
    return mass / case.period * (LIMIT - v) + drag


def sampled_ceiling(case: Case, v: Floats) -> Floats:
    """Largest force for the worst robot and push, less a margin for a force held T + delay."""
    speed = (np.array((PHI, TRACK * PHI)) + DBAR) / LOW
    room = LIMIT - v - (case.period + case.delay) * speed
    return np.where(room >= 0, LOW, HIGH) / case.period * room - DBAR


def predictive(title: str, *, tight: bool) -> Contender:
    """Nonlinear MPC with limits of velocity and torque, by ipopt, and the observer of prox."""

    def build(case: Case, gains: Mapping[str, tuple[float, ...]]) -> Step:
        return _Predictive(case, gains, tight).step

    start = {"position": (400.0,), "angle": (20.0,), "change": (1e-4,), "wo": (5.0,)}
    return Contender(title, lambda case: start, build)


class _Predictive:
    def __init__(self, case: Case, gains: Mapping[str, tuple[float, ...]], tight: bool) -> None:
        self.case, self.h = case, max(case.period, LONGEST)
        self.wo = gains["wo"][0]
        late = case.period + case.delay
        margin = (DBAR + np.array((0.15 * HIGH[0] * 9.81, 0.0))) * late / LOW if tight else 0.0
        self.limit = np.maximum(LIMIT - margin, 0.1 * LIMIT)
        self.mass = np.array((BELIEVED["m"], BELIEVED["I"]))
        self.f_hat, self.old, self.sent = np.zeros(2), None, np.zeros(2)
        self.guess: Floats | None = None
        self.solver, self.low, self.high = self._problem(gains)

    def _rate(self, s: ca.SX, force: ca.SX, f_hat: ca.SX) -> ca.SX:
        drag = friction(*map(ca.SX, (BELIEVED["mu"], BELIEVED["m"], 9.81, 0.01)), s[3:])
        v_dot = (force - f_hat - drag) / ca.DM(self.mass)
        return ca.vertcat(-s[3] * ca.sin(s[2]), s[3] * ca.cos(s[2]), s[4], v_dot)

    def _problem(
        self, gains: Mapping[str, tuple[float, ...]]
    ) -> tuple[ca.Function, Floats, Floats]:
        forces, slack = ca.SX.sym("F", 2, HORIZON), ca.SX.sym("slack", 2)
        s = start = ca.SX.sym("s", 5)
        wanted, before, f_hat = ca.SX.sym("r", 3, HORIZON), ca.SX.sym("F0", 2), ca.SX.sym("f", 2)
        cost, last, rows = 1e5 * ca.sum1(slack), before, []
        for k in range(HORIZON):
            force = forces[:, k]
            middle = s + self.h / 2 * self._rate(s, force, f_hat)
            s = s + self.h * self._rate(middle, force, f_hat)
            error = s[:2] - wanted[:2, k]
            cost += gains["position"][0] * ca.sumsqr(error)
            cost += gains["angle"][0] * (1 - ca.cos(s[2] - wanted[2, k]))
            cost += gains["change"][0] * ca.sumsqr((force - last) / ca.DM((1.0, TRACK)))
            rows += [s[3:] - slack, -s[3:] - slack, force[0] + force[1] / TRACK,
                     force[0] - force[1] / TRACK]  # fmt: skip
            last = force
        problem = {
            "x": ca.vertcat(ca.vec(forces), slack), "f": cost, "g": ca.vertcat(*rows),
            "p": ca.vertcat(start, ca.vec(wanted), before, f_hat),
        }  # fmt: skip
        quiet = {"print_time": False, "ipopt.print_level": 0, "ipopt.sb": "yes",
                 "ipopt.max_iter": 40, "ipopt.tol": 1e-5, "error_on_fail": False}  # fmt: skip
        one_low = np.concatenate((np.full(4, -np.inf), (-PHI, -PHI)))
        one_high = np.concatenate((self.limit, self.limit, (PHI, PHI)))
        solver = ca.nlpsol("mpc", "ipopt", problem, quiet)
        return solver, np.tile(one_low, HORIZON), np.tile(one_high, HORIZON)

    def step(self, rows: Floats, state: Floats, before: Floats) -> Floats:
        """Observe, predict the state at which the command acts, solve, return the first torque."""
        applied = _force(before)
        if self.old is not None:
            gained = self.mass * (state[3:] - self.old) / self.case.period
            drag = BELIEVED["mu"] * BELIEVED["m"] * 9.81 * np.tanh(
                np.array((0.5 * (state[3] + self.old[0]), 0.0)) / 0.01)  # fmt: skip
            share = -np.expm1(-self.wo * self.case.period)
            self.f_hat = self.f_hat + share * (applied - gained - drag - self.f_hat)
        self.old = state[3:]
        s = state.copy()
        if self.case.delay:
            rate = np.asarray(ca.evalf(self._rate(ca.SX(s), ca.SX(self.sent), ca.SX(self.f_hat))))
            s = s + self.case.delay * rate.ravel()
        every = self.h / self.case.period
        at = [round((k + 1) * every + self.case.delay / self.case.period) for k in range(HORIZON)]
        wanted = rows[np.minimum(at, len(rows) - 1)][:, :3].copy()
        if self.guess is None:
            self.guess = np.zeros(2 * HORIZON + 2)
        solved = self.solver(
            x0=self.guess, p=np.concatenate((s, wanted.ravel(), self.sent, self.f_hat)),
            lbg=self.low, ubg=self.high,
            lbx=np.concatenate((np.full(2 * HORIZON, -np.inf), np.zeros(2))), ubx=np.inf,
        )  # fmt: skip
        self.guess = np.asarray(solved["x"]).ravel()
        force = self.guess[:2] if np.isfinite(self.guess).all() else np.zeros(2)
        torque = _wheels(force)
        self.sent = _force(torque)
        return torque


def contenders() -> tuple[Contender, ...]:
    """All contenders, in the order of the tables."""
    return (
        law("prox", guard=True), law("kanayama", guard=False), law("kanayama", guard=True),
        law("mb", guard=True), law("nn", guard=True),
        predictive("NMPC, nominal", tight=False), predictive("NMPC, tightened", tight=True),
        filtered("prox + nominal CBF-QP", nominal_ceiling),
        filtered("prox + sampled-data CBF", sampled_ceiling),
    )  # fmt: skip


def _start(name: str, case: Case) -> dict[str, tuple[float, ...]]:
    """Initial gains: poles placed for the period, or the preset's gains where no pole is placed.

    The poles of prox are 1.4 times as fast, which its step towards the next target tolerates.
    """
    T, late = case.period, max(case.period, 2 * case.delay)
    faster = 1.4 if name == "prox" else 1.0
    p1, p2 = min(12.0, 0.36 / late) * faster, min(4.0, 0.26 / late) * faster
    rates = (-2 / T * float(np.log1p(-p1 * T)), -2 / T * float(np.log1p(-p2 * T)))
    placed = {
        "gains.kinematics.k": (p1, (p2 / 0.4) ** 2, p2),
        "gains.prox.rho": rates, "gains.prox.wo": (min(10.0, 0.45 / (T + case.delay)),),
        "gains.mb.rho": (2 * p1, 2 * p2),
        "gains.nn.rho1": (100 * p1, 10.8 * p2),
    }  # fmt: skip
    setup = settle(scenario_of("paper-simulation"), name)
    values = {key: placed.get(key) or setup.value(key) for key in tunable(LAWS[name])}
    if "gains.kinematics.k" in values:
        values[settle(case.scenario, name).kinematic_key] = values.pop("gains.kinematics.k")
    return values


def _with(scenario: Scenario, gains: Mapping[str, tuple[float, ...]]) -> Scenario:
    return override(scenario, {key: list(value) if len(value) > 1 else value[0]
                               for key, value in gains.items()})  # fmt: skip


def _act(system: System) -> Callable[[Floats, Floats | None], tuple[Floats, Floats]]:
    graph = system.function("act", [system.update, system.y])

    def act(u: Floats, x: Floats | None) -> tuple[Floats, Floats]:
        given = np.zeros(system.u.numel())
        given[: len(u)] = u[: len(given)]
        after, y = graph(given, system.x0 if x is None else x, system.p0)
        return np.asarray(after).ravel(), np.asarray(y).ravel()

    return act


_FORCE = ca.SX.sym("force", 2)
_CUT = ca.Function("cut", [_FORCE], [force_to_wheel(ca.SX(ARM), ca.SX(TRACK), linear_first(
    _FORCE, ca.SX(PHI), ca.SX(TRACK)))])  # fmt: skip
_BACK = ca.Function("back", [_FORCE], [wheel_to_force(ca.SX(ARM), ca.SX(TRACK), _FORCE)])


def _wheels(force: Floats) -> Floats:
    return np.asarray(_CUT(force)).ravel()


def _force(torque: Floats) -> Floats:
    return np.asarray(_BACK(torque)).ravel()
