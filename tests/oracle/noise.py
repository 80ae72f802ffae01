"""Random numbers by counter: Philox4x64-10 blocks at (control step, stream, attempt, 0).

A number depends on the seed and its counter only, so every law and every engine sees the same
noise, whatever else was drawn before.
"""

import zlib

import numpy as np

TORQUE, POSE, VELOCITY = 0, 1, 2
"""Streams."""
LOST, LAG = (16 + zlib.crc32(name) for name in (b"pose_lost", b"lag"))
"""Streams that are numbered by their names."""
_ATTEMPTS = 64


def key_of(seed):
    """Philox key (2,) uint64 of a seed."""
    return np.asarray(np.random.SeedSequence(seed).generate_state(2, np.uint64), np.uint64)


def raw_blocks(key, first, count, stream, attempt=0):
    """Integers (count, 4) uint64 of the control steps ``first`` to ``first + count - 1``."""
    counter = first + (stream << 64) + (attempt << 128)
    before = (counter - 1) % 2**256  # the generator counts up before it draws
    generator = np.random.Philox(key=key, counter=before)
    return generator.random_raw(4 * count).reshape(count, 4)


def uniforms(raw):
    """Numbers in [0, 1) of 53 bits, shaped like ``raw``."""
    return (raw >> np.uint64(11)).astype(np.float64) * 2.0**-53


def symmetric(key, count, stream):
    """Pairs (count, 2), uniform in [-1, 1)."""
    return 2.0 * uniforms(raw_blocks(key, 0, count, stream))[:, :2] - 1.0


def torque_noise(key, count, disturbance):
    """Disturbance torques (count, 2) [N m], right and left wheel, one row per control step."""
    if disturbance.std == 0.0:
        return np.zeros((count, 2))
    normal = _box_muller(uniforms(raw_blocks(key, 0, count, TORQUE)))
    bound = disturbance.truncate
    for k in np.flatnonzero(np.abs(normal).max(axis=1) > bound):
        normal[k] = _redrawn(key, int(k), bound)
    return disturbance.std * normal


def _redrawn(key, k, bound):
    """The first later attempt at step ``k`` that keeps the bound, or the last one clipped."""
    attempt, pair = 0, np.array([np.inf, np.inf])
    while np.abs(pair).max() > bound and attempt + 1 < _ATTEMPTS:
        attempt += 1
        pair = _box_muller(uniforms(raw_blocks(key, k, 1, TORQUE, attempt)))[0]
    return np.asarray(np.clip(pair, -bound, bound))


def _box_muller(u):
    """Standard normal pairs (count, 2) of uniforms (count, 4)."""
    radius = np.sqrt(-2.0 * np.log(1.0 - u[:, 0]))
    angle = 2.0 * np.pi * u[:, 1]
    return np.column_stack((radius * np.cos(angle), radius * np.sin(angle)))
