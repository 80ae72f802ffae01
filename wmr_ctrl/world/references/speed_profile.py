"""Time-optimal speed along a path under limits, by two passes over a grid.

In each cell of the grid the path's parameter has a constant second derivative u, and the square x
of its rate is then linear in the parameter. All limits are linear in u and x at every place of a
cell. A pass from the end finds the largest x from which the rest can still be driven; a pass from
the start takes the largest u. That is the fastest motion on this grid (the method of reachable
sets: Pham and Pham, "A new approach to time-optimal path parameterization based on reachability
analysis", IEEE Transactions on Robotics, 2018). Between these places the limits are checked
afterwards, and the whole motion is slowed down as much as they require.
"""

from dataclasses import dataclass

import numpy as np

from .spline import Array, SplinePath

MOST_ROWS = 256
"""Cells of a path of few segments; one of many has at least two on each."""
COARSE = np.linspace(0.0, 1.0, 5)
"""Places in each cell at which the two passes keep the limits."""
FINE = np.linspace(0.0, 1.0, 65)
"""Places in each cell at which the limits are looked at afterwards."""
MARGIN = 1.0001
"""Slowness that covers what lies between the places."""
LAPS = 60
"""Rounds in which a lap's speed at its start and at its end come together."""


@dataclass(frozen=True, kw_only=True)
class PathLimits:
    """Largest v1_d [m/s], |v2_d| [rad/s], and size of their rates [m/s2, rad/s2]."""

    speed: float
    turning: float
    acceleration: float
    angular_acceleration: float


@dataclass(frozen=True, eq=False)
class SpeedProfile:
    """A path's parameter over time: row j is valid from ``starts[j]`` [s] on, (rows,) each.

    ``places``, ``rates`` [1/s] and ``accelerations`` [1/s2] are the parameter and its derivatives
    at a row's start, the last constant within the row.  The last row is the motion after the end.
    """

    starts: Array
    places: Array
    rates: Array
    accelerations: Array

    @property
    def duration(self) -> float:
        """Time from the path's start to its end [s]."""
        return float(self.starts[-1])


@dataclass(frozen=True, eq=False)
class _Cells:
    """Cells of the grid: widths (n,), and per cell and place (n, k) the geometry.

    ``speed`` and ``turning`` are v1_d and v2_d at a parameter's rate of 1, ``speed_slope`` and
    ``turning_slope`` their derivatives by the parameter.
    """

    places: Array
    widths: Array
    within: Array
    speed: Array
    turning: Array
    speed_slope: Array
    turning_slope: Array


def fastest(path: SplinePath, limits: PathLimits, rest: bool, stop: bool) -> SpeedProfile:
    """The fastest profile of a path; ``rest``: begins at rest, ``stop``: ends at rest.

    Neither is possible on a closed path, whose lap ends as fast as it begins.  Raises ValueError if
    a path cannot be driven under the limits.
    """
    cells = _cells(path, COARSE)
    each = _squares(cells, limits)
    inner = np.minimum(each[:-1, -1], each[1:, 0])
    most = np.concatenate([each[:1, 0], inner, each[-1:, -1]])  # at the n + 1 points
    begin = 0.0 if rest else None
    end = 0.0 if stop else float(most[-1])
    squares, accelerations = _driven(cells, limits, most, begin, end)
    for _ in range(LAPS if path.closed and not rest and not stop else 0):
        gap = squares[0] - squares[-1]
        if abs(gap) <= 1e-12 * squares[0]:
            break
        end = begin = float(min(squares[0], squares[-1]))
        squares, accelerations = _driven(cells, limits, most, begin, end)
    return _stretched(path, limits, _in_time(cells, squares, accelerations, stop))


def _cells(path: SplinePath, within: Array) -> _Cells:
    """Cells of a path, with the geometry at the relative places ``within`` [0, 1] of each.

    On each segment they are smaller towards both ends.
    """
    count = int(np.clip(MOST_ROWS // len(path.headings), 2, 16))
    edges = (1 - np.cos(np.pi * np.arange(count + 1) / count)) / 2
    inner = edges[:-1, None] + np.diff(edges)[:, None] * within
    shape = (len(path.headings) * len(inner), len(within))
    first, second, third = (
        path.derivatives(order, inner.ravel()).reshape(*shape, 2) for order in (1, 2, 3)
    )
    lengths = np.diff(path.knots)[:, None]
    square, along = _dot(first, first), _dot(first, second)
    turning = _cross(first, second) / square
    return _Cells(
        places=(path.knots[:-1, None] + lengths * edges[:-1]).ravel(),
        widths=(lengths * np.diff(edges)).ravel(),
        within=within,
        speed=np.sqrt(square),
        turning=turning,
        speed_slope=along / np.sqrt(square),
        turning_slope=(_cross(first, third) - 2 * turning * along) / square,
    )


def _dot(a: Array, b: Array) -> Array:
    return np.asarray(np.einsum("...i,...i->...", a, b))


def _cross(a: Array, b: Array) -> Array:
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])


def _squares(cells: _Cells, limits: PathLimits) -> Array:
    """Largest square of the rate that speed and turning admit, per cell and place."""
    turning = np.maximum(np.abs(cells.turning), 1e-12)
    return np.asarray(np.minimum(limits.speed / cells.speed, limits.turning / turning) ** 2)


def _driven(
    cells: _Cells, limits: PathLimits, most: Array, begin: float | None, end: float
) -> tuple[Array, Array]:
    """Squared rates at grid points and accelerations of cells: a backward, then a forward pass."""
    admitted = _squares(cells, limits)
    lines = [_lines(cells, limits, admitted[k], k) for k in range(len(cells.widths))]
    reach = np.append(most[:-1], min(end, most[-1]))
    for k in reversed(range(len(lines))):
        reach[k] = min(reach[k], _widest(lines[k], cells.widths[k], reach[k + 1]))
    squares = np.empty(len(most))
    squares[0] = reach[0] if begin is None else min(begin, reach[0])
    chosen = np.empty(len(lines))
    for k, line in enumerate(lines):
        upper = _bounds(line, cells.widths[k], reach[k + 1])[1]
        top = float((upper[:, 0] + upper[:, 1] * squares[k]).min())
        squares[k + 1] = np.clip(squares[k] + 2 * cells.widths[k] * top, 0.0, reach[k + 1])
        chosen[k] = (squares[k + 1] - squares[k]) / (2 * cells.widths[k])
    return squares, chosen


def _lines(cells: _Cells, limits: PathLimits, squares: Array, k: int) -> Array:
    """Rows (a, b, c), a >= 0: |a u + b x| <= c at all places of cell k; x at the cell's start."""
    grown = 2 * cells.widths[k] * cells.within  # x grows by this times u
    most, turning_most = limits.acceleration, limits.angular_acceleration
    kinds = (
        (cells.speed[k], cells.speed_slope[k], np.full_like(grown, most)),
        (cells.turning[k], cells.turning_slope[k], np.full_like(grown, turning_most)),
        (np.zeros_like(grown), np.ones_like(grown), squares),
    )
    table = np.vstack([np.column_stack([v + grown * slope, slope, c]) for v, slope, c in kinds])
    table[table[:, 0] < 0, :2] *= -1
    return table


def _bounds(lines: Array, width: float, next_most: float) -> tuple[Array, Array, float]:
    """Bounds of u as lines in x (value at 0, slope), lower and upper, and the largest x allowed
    without u.
    """
    a, b, c = lines.T
    flat = a <= 1e-12 * np.maximum(np.abs(b), 1e-300)
    with np.errstate(divide="ignore", invalid="ignore"):
        alone = np.where(flat & (b != 0), c / np.abs(b), np.inf).min()
    a, b, c = a[~flat], b[~flat], c[~flat]
    slopes = np.append(-b / a, -1 / (2 * width))
    upper = np.column_stack([np.append(c / a, next_most / (2 * width)), slopes])
    lower = np.column_stack([np.append(-c / a, 0.0), slopes])
    return lower, upper, float(alone)


def _widest(lines: Array, width: float, next_most: float) -> float:
    """Largest x for which some u satisfies all limits and reaches at most ``next_most``."""
    lower, upper, alone = _bounds(lines, width, next_most)
    slopes = lower[:, None, 1] - upper[None, :, 1]
    gaps = upper[None, :, 0] - lower[:, None, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        crossings = np.where(slopes > 0, gaps / slopes, np.inf)
    return max(0.0, min(alone, float(crossings.min())))


def _in_time(cells: _Cells, squares: Array, accelerations: Array, stop: bool) -> SpeedProfile:
    rates = np.sqrt(squares)
    sums = rates[:-1] + rates[1:]
    if not (sums > 0).all():
        raise ValueError("the limits leave no speed at all on a part of it")
    starts = np.concatenate([[0.0], np.cumsum(2 * cells.widths / sums)])
    if stop:
        rates[-1] = 0.0
    end = cells.places[-1] + cells.widths[-1]
    return SpeedProfile(starts, np.append(cells.places, end), rates, np.append(accelerations, 0.0))


def _stretched(path: SplinePath, limits: PathLimits, profile: SpeedProfile) -> SpeedProfile:
    """The profile, slowed down so that the limits also hold between the grid's points."""
    cells = _cells(path, FINE)
    u = profile.accelerations[:-1, None]
    x = profile.rates[:-1, None] ** 2 + 2 * u * cells.widths[:, None] * FINE
    rate = np.sqrt(np.maximum(x, 0.0))
    shares = (
        np.abs(cells.speed) * rate / limits.speed,
        np.abs(cells.turning) * rate / limits.turning,
        np.abs(cells.speed * u + cells.speed_slope * x) / limits.acceleration,
        np.abs(cells.turning * u + cells.turning_slope * x) / limits.angular_acceleration,
    )
    first, second, third, fourth = (float(share.max()) for share in shares)
    worst = MARGIN * max(1.0, first, second, third**0.5, fourth**0.5)
    starts, accelerations = profile.starts * worst, profile.accelerations / worst**2
    return SpeedProfile(starts, profile.places, profile.rates / worst, accelerations)
