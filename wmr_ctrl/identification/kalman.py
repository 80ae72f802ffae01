"""The Kalman filter that reads a log: kernels to predict and correct, and a compiled pass.

An extended Kalman filter on path length and rotation of the wheels. Its drift is the plant's own
graph with the ground's resistance, Eqs. (1)-(6), stepped as the plant is stepped; the torque acts
after a delay and the drives' lag. Kernels with gradients propagate the derivatives of mean and
covariance by all parameters (forward), so that one pass gives the likelihood, its gradient and the
Fisher information.
"""

import ctypes as ct
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.codegen.build import lanes_library
from wmr_ctrl.codegen.emit import Kernel, kernel
from wmr_ctrl.core.signals import BODY_FORCE, PATH, PLANT_STATE, TORQUE, Signal, elements
from wmr_ctrl.world.lag import followed
from wmr_ctrl.world.model.dynamics import plant, rk4_step
from wmr_ctrl.world.model.system import Port, System, port, stack
from wmr_ctrl.world.resistance import build as resistance
from wmr_ctrl.world.resistance import load_of_wheel
from wmr_ctrl.world.scenario import Scenario

from .logs.log import Floats
from .logs.samples import Samples

BLOCKS = 15
DIRECTIONS = 2
"""Directions of derivatives that a kernel takes at once, which share what no direction changes."""
PIECE = ("right", "left", "h0", "h1")
"""Inputs of a piece in which a command acts: torques [N m], and its length h0 + h1 delay [s]."""
SEEN = ("first", "second", "variance1", "variance2", "of_speed")
"""Inputs of a measurement: both axes' way and turn, or speeds (of_speed = 1), known variances."""


NAMES = ("m", "I", "Fc", "Fv", "c", "Mv", "delay", "lag", "q1", "q2", "s1", "s2", "time",
         "n1", "n2")  # fmt: skip
"""Parameters, see docs/explanation/identify.md.  m, I and what follows lag are searched as
logarithms; q: rms white force a control period, s: rms of the coloured force and its time, n: rms
of measured speeds."""
LOGARITHMIC = frozenset((*NAMES[:2], *NAMES[8:]))
LOGS = np.array([name in LOGARITHMIC for name in NAMES])
INDEX = {name: k for k, name in enumerate(NAMES)}
KNOWN = ("r", "l", "g", "v_s", "T")
"""Numbers that are not searched."""
MEAN, NOISY = 8, 6
"""Length of the mean, and how many of it carry a covariance."""
PACKED = NOISY * (NOISY + 1) // 2
OUTPUTS = 2
"""Residuals of a measurement."""
SKIPPED, COUNTED, WATCHED = range(3)
"""Kinds of measurements: taken in but not counted, counted, and not taken in."""


def kernels(scenario: Scenario) -> tuple[Kernel, ...]:
    """Kernels for one piece and for one measurement, each without and with gradients."""
    theta, known = symbol("theta", len(NAMES)), symbol("known", len(KNOWN))
    moved, torque, force = symbol("moved", 4), symbol("torque", 2), symbol("force", 2)
    a = {name: theta.sym[i] for name, i in INDEX.items()}
    a |= {name: ca.exp(a[name]) for name in LOGARITHMIC}
    a |= {name: known.sym[i] for i, name in enumerate(KNOWN)}
    u, mean, cov = ca.SX.sym("u", len(PIECE)), ca.SX.sym("mean", MEAN), ca.SX.sym("cov", PACKED)
    h = u[2] + u[3] * a["delay"]
    acting, push = mean[6:8], mean[4:6]
    after = followed(u[:2], ca.exp(-h / a["lag"]), acting)
    rate = _rate(scenario, a, moved.sym, torque.sym, force.sym)
    title, inputs = "robot on ground that resists", (torque, force)
    ground = System("ground", title, inputs=inputs, state=(moved,), params=(theta, known),
                    update=rate)  # fmt: skip
    step = rk4_step(ground, h)
    by = ca.substitute(
        [step, ca.jacobian(step, moved.sym), ca.jacobian(step, force.sym)],
        [ground.x, ground.u],
        [mean[:4], ca.vertcat(u[:2] + a["lag"] * (acting - after) / h, push)],
    )
    keep = ca.exp(-h / a["time"])
    f = ca.blockcat([[by[1], by[2]], [ca.SX(2, 4), keep * ca.SX.eye(2)]])
    white = ca.diag(ca.vertcat(a["q1"], a["q2"]) ** 2) * a["T"] / h
    fresh = ca.vertcat(a["s1"], a["s2"]) ** 2 * (1 - keep**2)
    noise = ca.blockcat([[by[2] @ white @ by[2].T, ca.SX(4, 2)], [ca.SX(2, 4), ca.diag(fresh)]])
    # From the upper triangle, row after row.
    p = ca.tril2symm(ca.SX(ca.Sparsity.lower(NOISY), cov))
    following = ca.vertcat(by[0], keep * push, after, _packed(f @ p @ f.T + noise))
    x, parameters = ca.vertcat(mean, cov), ca.vertcat(theta.sym, known.sym)
    seen = ca.SX.sym("seen", len(SEEN))
    h_way = ca.horzcat(ca.SX.eye(2), ca.SX(2, 4))
    h_speed = ca.horzcat(ca.SX(2, 2), ca.SX.eye(2), ca.SX(2, 2))
    rows = (1 - seen[4]) * h_way + seen[4] * h_speed
    own = seen[4] * ca.vertcat(a["n1"], a["n2"]) ** 2
    after_it, reading = _corrected(rows, ca.diag(seen[2:4] + own), seen[:2], mean, p)
    dx, dp = (ca.SX.sym(name, column.numel(), DIRECTIONS)
              for name, column in (("dx", x), ("dp", parameters)))  # fmt: skip

    def along(value: ca.SX) -> ca.SX:
        """Derivatives (n, DIRECTIONS)."""
        return ca.densify(ca.jtimes(value, ca.vertcat(x, parameters), ca.vertcat(dx, dp)))

    def both(name: str, what: str, u: ca.SX, **results: tuple[ca.SX, ca.SX]) -> list[Kernel]:
        """Two kernels of a step: one for the results alone, one also for their derivatives."""
        inputs = {"u": u, "x": x, "p": parameters}
        values = {key: value for key, (value, _) in results.items()}
        alone = kernel(name, f"State after {what}.", inputs, values, prepared=True)
        inputs |= {"dx": ca.vec(dx), "dp": ca.vec(dp)}
        values |= {f"d{key}": ca.vec(slopes) for key, (_, slopes) in results.items()}
        meaning = f"State after {what}, and derivatives in {DIRECTIONS} directions."
        return [alone, kernel(f"{name}_slopes", meaning, inputs, values, prepared=True)]

    piece = both("predict", "a piece", u, next=(following, along(following)))
    what = "a measurement, and what the likelihood takes of it"
    return (
        *piece,
        *both("correct", what, seen, next=(after_it, along(after_it)), y=_told(*reading, along)),
    )


def symbol(name: str, size: int = 1) -> Port:
    """A port with no unit."""
    return port(Signal(name, "1", name, size))


def _rate(
    scenario: Scenario, a: dict[str, ca.SX], moved: ca.SX, torque: ca.SX, force: ca.SX
) -> ca.SX:
    """Rate of (path length, rotation, v1, omega) by the plant's graph, with ground resistance."""
    robot, drag = plant(scenario, rolling=(PATH,)), resistance(scenario)
    values = {f"robot.{key}": a[key] for key in ("m", "I", "r", "l", "g", "v_s")}
    values |= {
        "robot.mu": a["Fc"] / (a["m"] * a["g"]),
        "resistance.viscous": ca.vertcat(a["Fv"], a["Mv"]),
        "resistance.rolling": ca.repmat(a["c"] / load_of_wheel(a["m"], a["g"]), 2),
        PATH.name: moved[0],
    }

    def put(signals: Sequence[Signal], column: ca.SX) -> None:
        values.update(zip(elements(signals), ca.vertsplit(column), strict=True))

    def of(ports: Sequence[Port]) -> ca.SX:
        return stack(ca.SX(values.get(item.signal.name, 0)) for item in ports)

    put((*PLANT_STATE[2:], *TORQUE), ca.vertcat(moved[1:], torque))
    slowing = drag.function("drag", [drag.y])(of(drag.inputs), drag.x, of(drag.params))
    put(BODY_FORCE, force + slowing)
    moving = robot.function("rate", [robot.update])
    rates = moving(of(robot.inputs), of(robot.state), of(robot.params))
    return ca.vertcat(rates[-1], rates[2:5])


def _corrected(
    rows: ca.SX, noise: ca.SX, seen: ca.SX, mean: ca.SX, p: ca.SX
) -> tuple[ca.SX, tuple[ca.SX, ca.SX, ca.SX]]:
    """State after a measurement; its residual, the residual's covariance and inverse lower root."""
    count = p.shape[0]
    residual = seen - rows @ mean[:count]
    cross = p @ rows.T
    s = rows @ cross + noise
    inverse = ca.inv(ca.chol(s).T)
    # p - cross s^-1 cross' = p - w w' with w = cross root^-T, and the gain is w root^-1.
    w = cross @ inverse.T
    after = ca.vertcat(mean[:count] + w @ (inverse @ residual), mean[count:])
    return ca.vertcat(after, _packed(p - w @ w.T)), (residual, s, inverse)


def _told(
    residual: ca.SX, s: ca.SX, inverse: ca.SX, along: Callable[[ca.SX], ca.SX]
) -> tuple[ca.SX, ca.SX]:
    """(nll, residual, z) of a measurement, and per direction its gradient and a column; products of
    these columns give the Fisher information.

    nll: minus the log of the likelihood, less a constant; z: the residual in standard deviations.
    """
    white = inverse @ residual
    nll = ca.dot(white, white) / 2 - ca.sum1(ca.log(ca.diag(inverse)))
    moved, spread = inverse @ along(residual), along(ca.vec(s))
    columns = []
    for k in range(DIRECTIONS):
        a, b = moved[:, k], inverse @ ca.reshape(spread[:, k], *s.shape) @ inverse.T
        gradient = ca.dot(a, white) + (ca.trace(b) - ca.dot(white, b @ white)) / 2
        columns.append(ca.vertcat(gradient, a, ca.diag(b) / ca.sqrt(2), b[1, 0]))
    own = ca.vertcat(nll, residual, residual * ca.sqrt(1 / ca.diag(s)))
    return own, ca.horzcat(*columns)


def _packed(whole: ca.SX) -> ca.SX:
    return ca.vertcat(*(whole[i, j] for i in range(NOISY) for j in range(i, NOISY)))


def blocks_of(t: Floats) -> NDArray[np.int64]:
    """Block of time (N,) that each of the times (N,) [s] is in."""
    return np.minimum((t - t[0]) / max(t[-1] - t[0], 1e-9) * BLOCKS, BLOCKS - 1).astype(np.int64)


@dataclass(frozen=True)
class Pass:
    """Result of a pass through a log: per block the negative log-likelihood (B,), its gradient
    (B, n) and Fisher information (B, n, n).
    """

    nll: Floats
    gradient: Floats
    fisher: Floats


@dataclass(frozen=True)
class PassResult(Pass):
    """Result of a pass of the filter: also per measurement residuals, standardised residuals, and
    means.
    """

    residual: Floats
    sizes: Floats
    mean: Floats


class CompiledFilter:
    """The filter of a scenario as compiled C."""

    def __init__(self, scenario: Scenario) -> None:
        """Build the library, or load it from the cache.  Raises CompilerError."""
        sizes = {
            "NAMES": len(NAMES),
            "KNOWN": len(KNOWN),
            "STATE": MEAN,
            "PRIMAL": MEAN + PACKED,
            "OUTPUTS": OUTPUTS,
            "DIRECTIONS": DIRECTIONS,
            "INPUTS": len(SEEN),
            "DELAY": INDEX["delay"],
        }
        self._library = ct.CDLL(str(lanes_library("read_log.c", sizes, kernels(scenario))))

    def __call__(
        self,
        log: Samples,
        start: Floats,
        parameters: Floats,
        covariance: Floats,
        *,
        slopes: bool = True,
        kinds: NDArray[np.int_] | int = COUNTED,
        blocks: NDArray[np.int64] | int = 0,
    ) -> PassResult:
        """One pass with ``parameters`` (searched, then known).

        ``start`` (F, MEAN) and ``covariance`` (packed): at the beginning of each stretch.
        ``kinds`` (N,) and ``blocks`` (N,) of
        the measurements.
        """
        count, n = len(log.t), len(NAMES)
        nll, gradient = np.zeros(BLOCKS), np.zeros((BLOCKS, n))
        fisher, told = np.zeros((BLOCKS, n, n)), np.zeros((count, 2 * OUTPUTS + MEAN))
        read = (log.t, log.seen, log.variance, log.command_t, log.command, start)
        numbers = (*read, parameters, covariance)
        marks = [np.full(count, item, np.int32) for item in (kinds, blocks)]
        rest: tuple[NDArray[Any], ...] = (log.first, *marks, nll, gradient, fisher, told)
        self._library.wmr_read_log(
            *(ct.c_int64(len(item)) for item in (log.t, log.command_t, log.first)),
            *(ct.c_int32(item) for item in (log.of_speed, slopes)),
            *(np.ascontiguousarray(item, np.float64).ctypes for item in numbers),
            *(item.ctypes for item in rest),
        )
        parts = np.split(told, [OUTPUTS, 2 * OUTPUTS], axis=1)
        return PassResult(nll, gradient, fisher, *parts)
