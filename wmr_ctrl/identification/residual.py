"""Test of a fit: do the log's commands predict its residual?  Not if the model is right."""

import math

import numpy as np

from .logs.log import Floats
from .speed_loop import LoopFit

KNOTS = (0.0, 0.1, 0.25, 0.4, 0.5, 0.6, 0.75, 0.9, 1.0)
LAGS = (0.0, 0.1, 0.25, 0.5)
"""By how much later commands may act than by the model [s]."""
PARTS = 10
RIDGE = 3e-3
CUTS = (0.2, 0.35, 0.5, 0.65, 0.8)


def explainable(fit: LoopFit) -> float:
    """Upper estimate of the share of a residual's squares that command, speed and time explain."""
    log, y = fit.log, fit.forecast
    later = np.where(log.t[:, None] >= np.quantile(log.t[log.in_fit], CUTS), y[:, None], 0.0)
    x = np.column_stack((_columns(fit, None), later, np.ones(len(y))))[log.in_fit]
    left = fit.left[log.in_fit]
    squares = x.T @ x
    ridge = 1e-9 * np.diag(np.diag(squares) + 1e-12)
    rest = left - x @ np.linalg.solve(squares + ridge, x.T @ left)
    by_chance = 2 * x.shape[1] / len(left)
    return 1 - float(rest @ rest) / max(float(left @ left), 1e-300) - by_chance


def told(fit: LoopFit, other: Floats | None = None) -> float:
    """Cross-validated rms of the residual that commands predict, relative to the speed's rms.

    ``other`` (N,): the other axis' speed.
    """
    inside = fit.log.in_fit
    x = _columns(fit, other)
    x = x - x[inside].mean(axis=0)
    x = (x / np.maximum(x[inside].std(axis=0), 1e-12))[inside]
    left, count = fit.left[inside], int(inside.sum())
    part = np.arange(count) * PARTS // count
    whole, pull, guess = x.T @ x, x.T @ left, np.empty(count)
    for k in range(PARTS):
        own = part == k
        kept = whole - x[own].T @ x[own] + RIDGE * count * np.eye(x.shape[1])
        guess[own] = x[own] @ np.linalg.solve(kept, pull - x[own].T @ left[own])
    gained = float(left @ left - np.sum((left - guess) ** 2))
    return math.sqrt(max(gained, 0.0) / count) / max(float(np.std(fit.forecast[inside])), 1e-9)


def _columns(fit: LoopFit, other: Floats | None) -> Floats:
    """Functions (N, K) of command, speed, acceleration, and the other axis' speed."""
    log, y = fit.log, fit.forecast
    end = log.t[:, None] - fit.values["delay"] - np.array(LAGS)
    w = log.mean_command(end - log.period, end)
    rate = np.gradient(y, fit.log.t)
    knots = np.unique(np.quantile(w[fit.log.in_fit, 0], KNOTS))
    hats = [np.interp(w[:, 0], knots, row) for row in np.eye(len(knots))]
    columns = [*hats, *w.T[1:], y, np.abs(y), y * np.abs(y)]
    columns += [rate, np.abs(rate), rate * np.sign(y), np.abs(rate) * np.sign(y)]
    if other is not None:
        size = np.abs(other)
        columns += [other, size, y * size, np.sign(y) * size]
    return np.column_stack(columns)
