"""Effects once more in plain Python, one class a kind: they share no code with the graphs.

A twin is fed the same true motion, commands and random numbers as the System, in order.
"""

import math


class EncoderTwin:
    """Counts differenced over a window."""

    def __init__(self, n):
        self.n, self.counts = n, []

    def __call__(self, k, row):
        n = self.n
        arm = n["l"] * (1 + n["track"])
        right, left = (n["r"] * (1 + e) for e in n["radius"])
        s, theta = row["path"][0], row["theta"][0]
        turns = (s + arm * theta) / (2 * math.pi * right), (s - arm * theta) / (2 * math.pi * left)
        self.counts.append([math.floor(n["counts"] * turn) for turn in turns])
        old = self.counts[max(0, k - n["periods"])]
        speeds = [
            2 * math.pi * n["r"] * (now - before) / n["counts"] / (n["periods"] * n["T"])
            for now, before in zip(self.counts[-1], old, strict=True)
        ]
        return sum(speeds) / 2, (speeds[0] - speeds[1]) / (2 * n["l"])


class MeanTwin:
    """Mean velocity over a window that ended some samples ago, from the way."""

    def __init__(self, n):
        self.n, self.rows = n, []

    def __call__(self, k, row):
        n = self.n
        window, age = n["window"], n["age"]
        self.rows.append(row)
        end, begin = (self.rows[max(0, k - back)] for back in (age, age + window))
        if not window:
            return end["v1"][0], end["omega"][0]
        names = ("path", "theta")
        first, second = ((end[x][0] - begin[x][0]) / (window * n["T"]) for x in names)
        return first, second


class JitterTwin:
    """Commands that arrive at the beginning of a period and wait: a list of takeovers."""

    def __init__(self, n):
        self.n, self.takeovers = n, []

    def __call__(self, i, row):
        n = self.n
        phase = (i - n["delay"]) % n["steps"]
        if phase == 0:
            share = (row["jitter"][0] + 1) / 2
            wait = min(int(share * (n["most"] + 1)), n["steps"])
            self.takeovers.append((i + wait, tuple(row["torque"])))
        return max(
            (item for item in enumerate(self.takeovers) if item[1][0] <= i),
            default=(0, (0, (0.0, 0.0))),
            key=lambda item: item[0],
        )[1][1]


def motor_twin(n, row):
    """Steps, dead zone and line, wheel by wheel."""
    shown = []
    for torque, side in zip(row["torque"], (1, -1), strict=True):
        speed = (row["v1"][0] + side * n["l"] * row["omega"][0]) / n["r"]
        torque = n["step"] * math.floor(torque / n["step"] + 0.5)
        torque = math.copysign(max(abs(torque) - n["dead_zone"], 0.0), torque)
        if torque * speed > 0:
            most = max(n["stall"] * (1 - abs(speed) / n["free"]), 0.0)
        else:
            most = n["stall"]
        shown.append(math.copysign(min(abs(torque), most), torque))
    return shown[0], shown[1]


def wheels_twin(n, row):
    """Thrust [N] and moment [N m] at wheels of the true size."""
    forces = [t / (n["r"] * (1 + e)) for t, e in zip(row["torque"], n["radius"], strict=True)]
    return sum(forces), n["l"] * (1 + n["track"]) * (forces[0] - forces[1])


def slope_twin(n, row):
    """Gravity as a vector in the plane of the ground, resolved along the heading and its left."""
    theta = row["theta"][0]
    ahead = (-math.sin(theta), math.cos(theta))
    left = (-ahead[1], ahead[0])
    size = -n["m"] * n["g"] * math.sin(n["angle"])
    pull = (size * math.cos(n["direction"]), size * math.sin(n["direction"]))
    along, across = (sum(a * b for a, b in zip(pull, way, strict=True)) for way in (ahead, left))
    return along, n["offset"] * across


def resistance_twin(n, row):
    """Each wheel's resistance with its arm, and viscous friction."""
    v, w = row["v1"][0], row["omega"][0]
    forces = [
        -c * n["m"] * n["g"] / 2 * math.tanh((v + side * n["l"] * w) / n["v_s"])
        for c, side in zip(n["rolling"], (1, -1), strict=True)
    ]
    along, turn = n["viscous"]
    return sum(forces) - along * v, n["l"] * (forces[0] - forces[1]) - turn * w


class GustTwin:
    """Filtered numbers."""

    def __init__(self, n):
        self.n, self.share = n, [0.0, 0.0]

    def __call__(self, k, row):
        a = math.exp(-self.n["T"] / self.n["time"])
        self.share = [a * s + (1 - a) * u for s, u in zip(self.share, row["gust"], strict=True)]
        first, second = (g * s for g, s in zip(self.n["size"], self.share, strict=True))
        return first, second
