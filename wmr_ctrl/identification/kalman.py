"""The filter through which a log is read: kernels to predict and correct, and a compiled pass.

An extended Kalman filter on way and turn of the wheels. Its drift is the plant's own graph with the
ground's resistance, Eqs. (1)-(6), stepped as the plant is stepped; the torque reaches it behind a
delay and the drives' own lag. Kernels with slopes carry the derivatives of mean and covariance by
all parameters along (forward), so that one pass gives the likelihood, its gradient and the Fisher
information.
"""

import ctypes as ct
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.codegen.build import lanes_library
from wmr_ctrl.codegen.emit import Kernel, kernel
from wmr_ctrl.core.signals import BODY_FORCE, PATH, TORQUE, VELOCITY
from wmr_ctrl.world.lag import followed
from wmr_ctrl.world.model.dynamics import plant, rk4_step
from wmr_ctrl.world.model.system import Port, System, stack
from wmr_ctrl.world.resistance import build as resistance
from wmr_ctrl.world.resistance import load_of_wheel
from wmr_ctrl.world.scenario import Scenario

from .logs.log import Floats

BLOCKS = 15
DIRECTIONS = 2
"""Directions of derivatives that a kernel takes at once, which share what no direction changes."""
PIECE = ("right", "left", "h0", "h1", "boost")
"""Inputs of a piece in which a command acts: torques [N m], length h0 + h1 delay [s], and the
factor by which the force noise is larger there."""
SEEN = ("first", "second", "variance1", "variance2", "of_speed")
"""Inputs of a measurement: both axes' way and turn, or speeds (of_speed = 1), known variances."""


NAMES = ("m", "I", "Fc", "Fv", "c", "Mv", "delay", "lag", "q1", "q2", "s1", "s2", "time",
         "n1", "n2")  # fmt: skip
"""Parameters, see docs/explanation/identify.md.  m, I and what follows lag are searched as
logarithms; q: rms white force a control period, s: rms of the coloured force and its time, n: rms
of measured speeds."""
LOGARITHMIC = frozenset({"m", "I", "q1", "q2", "s1", "s2", "time", "n1", "n2"})
INDEX = {name: k for k, name in enumerate(NAMES)}
KNOWN = ("r", "l", "g", "v_s", "T")
"""Numbers that are not searched."""
MEAN, NOISY = 8, 6
"""Length of the mean, and how many of it carry a covariance."""
PACKED = NOISY * (NOISY + 1) // 2
OUTPUTS = 2
"""Residuals of a measurement."""
WIDE = max(MEAN, len(PIECE))
"""Numbers in a row of events."""


def ground(scenario: Scenario) -> System:
    """The plant with the ground's resistance inside its rate, one continuous System."""
    robot, drag = plant(scenario, rolling=(PATH,)), resistance(scenario)
    p = {item.signal.name: item for item in (*drag.params, *robot.params)}
    speed = ca.vertcat(*(_of(robot.state, item.name) for item in VELOCITY))
    inner = stack(p[item.signal.name].sym for item in drag.params)
    force = drag.function("drag", [drag.y])(speed, drag.x, inner)
    pushed = ca.vertcat(*(_of(robot.inputs, item.name) for item in BODY_FORCE))
    update = ca.substitute(robot.update, pushed, pushed + force)
    ports = tuple(p.values())
    return System(
        "ground",
        "wheeled robot on ground that resists",
        inputs=robot.inputs,
        state=robot.state,
        params=ports,
        update=update,
    )


def _of(ports: Sequence[Port], name: str) -> ca.SX:
    return next(item.sym for item in ports if item.signal.name == name)


def kernels(scenario: Scenario) -> tuple[Kernel, ...]:
    """Steps over a piece and over a measurement, each without slopes and with them."""
    theta, known = ca.SX.sym("theta", len(NAMES)), ca.SX.sym("known", len(KNOWN))
    a = {name: ca.exp(theta[i]) if name in LOGARITHMIC else theta[i] for name, i in INDEX.items()}
    a |= {name: known[i] for i, name in enumerate(KNOWN)}
    u, mean, cov = ca.SX.sym("u", len(PIECE)), ca.SX.sym("mean", MEAN), ca.SX.sym("cov", PACKED)
    h = u[2] + u[3] * a["delay"]
    acting = mean[6:8]
    after = followed(u[:2], ca.exp(-h / a["lag"]), acting)
    torque = u[:2] + a["lag"] * (acting - after) / h
    moved, force = ca.SX.sym("moved", 4), ca.SX.sym("force", 2)
    step = stepped(scenario, a, torque, h, moved, force)
    keep = ca.exp(-h / a["time"])
    push = mean[4:6]
    at = ca.vertcat(moved, force), ca.vertcat(mean[:4], push)
    by = ca.substitute([step, ca.jacobian(step, moved), ca.jacobian(step, force)], [at[0]], [at[1]])
    f = ca.blockcat([[by[1], by[2]], [ca.SX(2, 4), keep * ca.SX.eye(2)]])
    white = ca.diag(ca.vertcat(a["q1"], a["q2"]) ** 2) * u[4] ** 2 * a["T"] / h
    fresh = ca.vertcat(a["s1"], a["s2"]) ** 2 * (1 - keep**2)
    noise = ca.blockcat([[by[2] @ white @ by[2].T, ca.SX(4, 2)], [ca.SX(2, 4), ca.diag(fresh)]])
    # From the upper triangle, row after row.
    p = ca.tril2symm(ca.SX(ca.Sparsity.lower(NOISY), cov))
    following = ca.vertcat(by[0], keep * push, after, _packed(f @ p @ f.T + noise))
    piece = _both("predict", "a piece", following, u, mean, cov, theta, known)
    seen = ca.SX.sym("seen", len(SEEN))
    h_way = ca.horzcat(ca.SX.eye(2), ca.SX(2, 4))
    h_speed = ca.horzcat(ca.SX(2, 2), ca.SX.eye(2), ca.SX(2, 2))
    rows = (1 - seen[4]) * h_way + seen[4] * h_speed
    own = seen[4] * ca.vertcat(a["n1"], a["n2"]) ** 2
    after_it, reading = _corrected(rows, ca.diag(seen[2:4] + own), seen[:2], mean, p)
    what = "correct", "a measurement, and what the likelihood takes of it"
    measured = _both(*what, after_it, seen, mean, cov, theta, known, reading)
    return (*piece, *measured)


def stepped(
    scenario: Scenario, a: dict[str, ca.SX], torque: ca.SX, h: ca.SX, moved: ca.SX, force: ca.SX
) -> ca.SX:
    """(way, turn, v1, omega) after one Runge-Kutta step of the plant's graph."""
    system = ground(scenario)
    weight = a["m"] * a["g"]
    numbers = {f"robot.{key}": a[key] for key in ("m", "I", "r", "l", "g", "v_s")}
    numbers |= {
        "robot.mu": a["Fc"] / weight,
        "resistance.viscous": ca.vertcat(a["Fv"], a["Mv"]),
        "resistance.rolling": ca.repmat(a["c"] / load_of_wheel(a["m"], a["g"]), 2),
    }
    state = {"theta": moved[1], "v1": moved[2], "omega": moved[3], PATH.name: moved[0]}
    inputs = dict(zip((item.name for item in TORQUE), (torque[0], torque[1]), strict=True))
    inputs |= dict(zip((item.name for item in BODY_FORCE), (force[0], force[1]), strict=True))
    names = [item.signal.name for item in system.state]
    u = stack(ca.SX(inputs.get(item.signal.name, 0)) for item in system.inputs)
    x = stack(ca.SX(state.get(name, 0)) for name in names)
    p = stack(numbers[item.signal.name] for item in system.params)
    whole = ca.substitute(
        rk4_step(system, h), ca.vertcat(system.u, system.x, system.p), ca.vertcat(u, x, p)
    )
    return ca.vertcat(*(whole[names.index(name)] for name in (PATH.name, "theta", "v1", "omega")))


def _corrected(
    rows: ca.SX, noise: ca.SX, seen: ca.SX, mean: ca.SX, p: ca.SX
) -> tuple[ca.SX, tuple[ca.SX, ca.SX, ca.SX]]:
    """State after a measurement; its residual, that one's covariance, and inverse lower root."""
    count = p.shape[0]
    residual = seen - rows @ mean[:count]
    cross = p @ rows.T
    s = rows @ cross + noise
    inverse = _inverse_root(s)
    # p - cross s^-1 cross' = p - w w' with w = cross root^-T, and the gain is w root^-1.
    w = cross @ inverse.T
    after = ca.vertcat(mean[:count] + w @ (inverse @ residual), mean[count:])
    return ca.vertcat(after, _packed(p - w @ w.T)), (residual, s, inverse)


def _inverse_root(s: ca.SX) -> ca.SX:
    """R^-1 of s = R R', R lower triangular (2, 2).

    Roots of reciprocals: products with reciprocals of roots would be divisions, one by one.
    """
    first = ca.sqrt(1 / s[0, 0])
    below = s[1, 0] * first
    last = ca.sqrt(1 / (s[1, 1] - below**2))
    return ca.blockcat([[first, ca.SX(1, 1)], [-below * first * last, last]])


def _both(
    name: str,
    after_what: str,
    after: ca.SX,
    u: ca.SX,
    mean: ca.SX,
    cov: ca.SX,
    theta: ca.SX,
    known: ca.SX,
    reading: tuple[ca.SX, ca.SX, ca.SX] | None = None,
) -> tuple[Kernel, Kernel]:
    """Kernels of a step, without and with its derivatives in DIRECTIONS a lane.

    For a measurement they give, too: minus the log of the likelihood (less a constant), residuals,
    by how many standard deviations they are off; and by direction the gradient and a column whose
    products with the other directions' are the Fisher information.
    """
    x, p = ca.vertcat(mean, cov), ca.vertcat(theta, known)
    dx, dp = ca.SX.sym("dx", x.numel(), DIRECTIONS), ca.SX.sym("dp", p.numel(), DIRECTIONS)

    def along(value: ca.SX) -> ca.SX:
        """Derivatives (n, DIRECTIONS)."""
        return ca.densify(ca.jtimes(value, ca.vertcat(x, p), ca.vertcat(dx, dp)))

    inputs, results = {"u": u, "x": x, "p": p}, {"next": after}
    if reading is not None:
        results["y"] = _likelihood(*reading)
    meaning = f"State after {after_what}."
    alone = kernel(name, meaning, inputs, results, prepared=True)
    inputs |= {"dx": ca.vec(dx), "dp": ca.vec(dp)}
    results |= {"dnext": ca.vec(along(after))}
    if reading is not None:
        results["dy"] = ca.vec(_slopes(*reading, along))
    meaning = f"State after {after_what}, and derivatives in {DIRECTIONS} directions."
    return alone, kernel(f"{name}_slopes", meaning, inputs, results, prepared=True)


def _likelihood(residual: ca.SX, s: ca.SX, inverse: ca.SX) -> ca.SX:
    """(nll, residual, z) of a measurement, z the residual in standard deviations."""
    white = inverse @ residual
    nll = ca.dot(white, white) / 2 - ca.sum1(ca.log(ca.diag(inverse)))
    return ca.vertcat(nll, residual, residual * ca.sqrt(1 / ca.diag(s)))


def _slopes(residual: ca.SX, s: ca.SX, inverse: ca.SX, along: Callable[[ca.SX], ca.SX]) -> ca.SX:
    """By direction the gradient of a measurement, and a column of the Fisher information."""
    white = inverse @ residual
    moved, spread = inverse @ along(residual), along(ca.vec(s))
    columns = []
    for k in range(DIRECTIONS):
        a, b = moved[:, k], inverse @ ca.reshape(spread[:, k], *s.shape) @ inverse.T
        gradient = ca.dot(a, white) + (ca.trace(b) - ca.dot(white, b @ white)) / 2
        columns.append(ca.vertcat(gradient, a, ca.diag(b) / ca.sqrt(2), b[1, 0]))
    return ca.horzcat(*columns)


def _packed(whole: ca.SX) -> ca.SX:
    return ca.vertcat(*(whole[i, j] for i in range(NOISY) for j in range(i, NOISY)))


@dataclass(frozen=True)
class Events:
    """Rows for the filter, their kinds, and the block that each counts in."""

    rows: Floats
    kinds: NDArray[np.int32]
    blocks: NDArray[np.int32]
    measured: int


@dataclass(frozen=True)
class PassResult:
    """Result of a pass: by block minus the log of the likelihood (B,), its gradient (B, n), Fisher
    information (B, n, n); by measurement residuals, those in standard deviations, and means.
    """

    nll: Floats
    gradient: Floats
    fisher: Floats
    residual: Floats
    sizes: Floats
    mean: Floats


class CompiledFilter:
    """The filter of a scenario as compiled C."""

    def __init__(self, scenario: Scenario) -> None:
        """Build the library, or take it from the cache.  Raises CompilerError."""
        sizes = {
            "NAMES": len(NAMES),
            "KNOWN": len(KNOWN),
            "STATE": MEAN,
            "PRIMAL": MEAN + PACKED,
            "OUTPUTS": OUTPUTS,
            "DIRECTIONS": DIRECTIONS,
            "WIDE": WIDE,
        }
        self._library = ct.CDLL(str(lanes_library("read_log.c", sizes, kernels(scenario))))

    def __call__(
        self, events: Events, parameters: Floats, covariance: Floats, slopes: bool = True
    ) -> PassResult:
        """One pass with ``parameters`` (searched, then known); ``covariance`` packed."""
        n = len(NAMES)
        nll, gradient = np.zeros(BLOCKS), np.zeros((BLOCKS, n))
        fisher = np.zeros((BLOCKS, n, n))
        residuals = np.zeros((events.measured, 2 * OUTPUTS + MEAN))
        arrays = (events.rows, events.kinds, events.blocks, np.ascontiguousarray(parameters))
        pointers = [ct.c_void_p(item.ctypes.data) for item in (*arrays, covariance)]
        results = [ct.c_void_p(item.ctypes.data) for item in (nll, gradient, fisher, residuals)]
        count, sloped = ct.c_int64(len(events.kinds)), ct.c_int32(bool(slopes))
        self._library.wmr_read_log(count, *pointers, sloped, *results)
        parts = np.split(residuals, [OUTPUTS, 2 * OUTPUTS], axis=1)
        return PassResult(nll, gradient, fisher, *parts)
