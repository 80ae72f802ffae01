"""The match: laws and filters that keep |v| <= v_u1, side by side on one plant.

``python -m benchmarks.match [--quick] [--times] [--out docs/match.md]``. Every contender knows the
same: the reference, exact pose and velocity, the believed mass 50 kg and friction 0.08, the guard's
bounds (mass, disturbance), the delay, the torque limit. Each gets BUDGET sets of gains, drawn in
the same way around its own start, on a training seed. The plant is the product's, Runge-Kutta at 1
ms; the adversary pushes outwards with all that the bounds allow. The time of a step is processor
time, which depends least on other work; ``--times`` measures it alone and renews the last column.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import casadi as ca
import numpy as np

from benchmarks.contenders import (
    ARM,
    DBAR,
    HIGH,
    LIMIT,
    LOW,
    TRACK,
    Case,
    Contender,
    Floats,
    Step,
    contenders,
)  # fmt: skip
from benchmarks.parts import page_parser
from wmr_ctrl.results import atomic_text, percent
from wmr_ctrl.world.model.dynamics import plant, rk4_step
from wmr_ctrl.world.references import sample
from wmr_ctrl.world.scenario import Scenario, override

STEP = 1e-3
HEAVY = {"robot.m": 65.0, "robot.I": 7.0, "robot.mu": 0.15}
"""Robot of the tracking columns; no contender knows its numbers."""
NOISE = 1.0
BUDGET, SPREAD = 12, 0.5
TRAIN, TEST = (1,), (7101, 7102)
PACED = 60
"""Number of samples for the median time of a step."""


class Plant:
    """The robot over one control period: an old command, then a new one."""

    def __init__(self, case: Case, numbers: Mapping[str, float]) -> None:
        scenario = override(case.scenario, {"guard.enabled": False, **numbers})
        robot = plant(scenario)
        torque, force = ca.SX.sym("torque", 2), ca.SX.sym("force", 2)
        inputs = {"tau_right": torque[0], "tau_left": torque[1], "thrust": force[0],
                  "moment": force[1]}  # fmt: skip
        u = ca.vertcat(*(inputs.get(item.signal.name, ca.SX.zeros(item.signal.size))
                         for item in robot.inputs))  # fmt: skip
        advance = robot.function("advance", [rk4_step(robot, ca.SX(STEP))])
        self.numbers, self._one = robot.p0, ca.Function("one", [torque, force, robot.x, robot.p],
                                                       [advance(u, robot.x, robot.p)])  # fmt: skip
        self._parts = [self._repeated(round(part / STEP))
                       for part in (case.delay, case.period - case.delay)]  # fmt: skip

    def _repeated(self, count: int) -> ca.Function | None:
        if count == 0:
            return None
        torque, force = ca.SX.sym("torque", 2), ca.SX.sym("force", 2)
        state = start = ca.SX.sym("state", 5)
        p, fastest = ca.SX.sym("p", len(self.numbers)), ca.SX.zeros(2)
        for _ in range(count):
            state = self._one(torque, force, state, p)
            fastest = ca.fmax(fastest, ca.fabs(state[3:]))
        return ca.Function("part", [torque, force, start, p], [state, fastest])

    def period(
        self, old: Floats, new: Floats, push: Floats, state: Floats
    ) -> tuple[Floats, Floats]:
        """State after a period, and the largest |v| during it."""
        fastest = np.abs(state[3:])
        for torque, part in zip((old, new), self._parts, strict=True):
            if part is not None:
                after, most = part(torque, push, state, self.numbers)
                state = np.asarray(after).ravel()
                fastest = np.maximum(fastest, np.asarray(most).ravel())
        return state, fastest


@dataclass(frozen=True)
class Trace:
    """One run: distance to the desired place (N,), v (N, 2), torque (N, 2), largest |v| / limit."""

    away: Floats
    v: Floats
    torque: Floats
    fastest: float
    microseconds: float


def run(
    case: Case, step: Step, robot: Plant, seconds: float, rows: Floats, state: Floats,
    seed: int | None = None,
) -> Trace:  # fmt: skip
    """A run along ``rows`` of a reference; without a seed the adversary pushes."""
    draw = np.random.default_rng(seed)
    old, before = np.zeros(2), np.zeros(2)
    away, v, torques, fastest, spent = [], [], [], 0.0, []
    for k in range(round(seconds / case.period)):
        begin = time.process_time()
        torque = step(rows[k:], state, before)
        spent.append(time.process_time() - begin)
        push = DBAR * np.where(state[3:] >= 0, 1.0, -1.0)
        if seed is not None:
            noise = np.clip(draw.normal(0.0, NOISE, 2), -3 * NOISE, 3 * NOISE)
            push = np.array((noise.sum(), TRACK * (noise[0] - noise[1]))) / ARM
        away.append(np.hypot(*(state[:2] - rows[k, :2])))
        v.append(state[3:])
        torques.append(torque)
        state, most = robot.period(old if case.delay else torque, torque, push, state)
        before = (case.delay * old + (case.period - case.delay) * torque) / case.period
        old, fastest = torque, max(fastest, float((most / LIMIT).max()))
        if not np.isfinite(state).all() or fastest > 100:
            return Trace(np.array([np.inf]), np.array(v), np.array(torques), np.inf, np.inf)
    return Trace(np.array(away), np.array(v), np.array(torques), fastest,
                 1e6 * float(np.median(spent)))  # fmt: skip


CASES = (Case(0.01, 0.0), Case(0.01, 0.005), Case(0.1, 0.0), Case(0.1, 0.05))


@dataclass(frozen=True)
class Result:
    """Worst |v| over its limit less 1, usable speed [m/s], RMS [m], change [N m], us a step."""

    contender: str
    excess: float
    speed: float
    position: float
    change: float
    microseconds: float


def pace(case: Case, contender: Contender) -> float:
    """Processor time [us] of a step with the starting gains: the median of PACED samples."""
    circle, start = _rows(case, case.scenario), np.zeros(5)
    start[:3] = circle[0, :3] + (0.05, 0.05, 0.0)
    step = contender.build(case, contender.start(case))
    seconds = PACED * case.period
    return run(case, step, Plant(case, HEAVY), seconds, circle, start, TEST[0]).microseconds


def play(case: Case, contender: Contender, budget: int = BUDGET) -> Result:
    """Tune on the training seed, then fill every column with cases that were not trained on."""
    circle = _rows(case, case.scenario)
    line = _rows(case, override(case.scenario, {"reference.kind": "line", "reference.speed": 2.0}))
    heavy, start = Plant(case, HEAVY), np.zeros(5)
    start[:3] = circle[0, :3] + (0.05, 0.05, 0.0)

    def tracked(gains: Mapping[str, tuple[float, ...]], seed: int) -> tuple[float, float]:
        trace = run(case, contender.build(case, gains), heavy, case.track, circle, start, seed)
        late = len(trace.away) // 2
        change = np.diff(trace.torque[late:], axis=0)
        return (float(np.sqrt(np.mean(trace.away[late:] ** 2))),
                float(np.sqrt(np.mean(change**2))) if len(change) else np.inf)  # fmt: skip

    def cost(gains: Mapping[str, tuple[float, ...]]) -> float:
        figures = [tracked(gains, seed) for seed in TRAIN]
        return float(np.sqrt(np.mean([p**2 + (1e-3 * c) ** 2 for p, c in figures])))

    best = min(_drawn(contender.start(case), budget), key=cost)
    figures = np.array([tracked(best, seed) for seed in TEST])
    far = np.array((-5.0, -5.0, -0.7, 0.0, 0.0))
    robots = [{"robot.m": m, "robot.I": inertia, "robot.mu": mu}
              for m, inertia in zip((LOW[0], HIGH[0]), (LOW[1], HIGH[1]), strict=True)
              for mu in (0.0, 0.15)]  # fmt: skip
    worst = max(
        run(case, contender.build(case, best), Plant(case, robot), case.attack, circle, far).fastest
        for robot in robots
    )
    fast = run(case, contender.build(case, best), heavy, case.attack, line,
               np.array((0.0, 0.0, line[0, 2], 0.0, 0.0)), 7101)  # fmt: skip
    speed = float(np.mean(fast.v[len(fast.v) // 2 :, 0])) if np.isfinite(fast.fastest) else np.nan
    position, change = np.median(figures, axis=0)
    return Result(contender.name, worst - 1, speed, position, change, pace(case, contender))


def table(case: Case, results: Sequence[Result]) -> str:
    """Markdown table of one case; the best figure of a column is bold."""
    late = f"a delay of {1e3 * case.delay:g} ms" if case.delay else "no delay"
    lines = [
        f"### {1e3 * case.period:g} ms, {late}", "",
        "| contender | worst \\|v\\| beyond its limit | usable speed [m/s] | position RMS [mm] "
        "| torque change [N m] | a step here [us] |",
        "|---|---|---|---|---|---|",
    ]  # fmt: skip
    columns = [(1, [r.speed for r in results]), (-1, [1e3 * r.position for r in results]),
               (-1, [r.change for r in results]),
               (-1, [r.microseconds for r in results])]  # fmt: skip
    bests = [np.nanargmax([sign * x for x in values]) for sign, values in columns]
    for k, result in enumerate(results):
        kept = "none" if result.excess <= 1e-9 else percent(result.excess)
        cells = [f"**{values[k]:.3g}**" if bests[i] == k else f"{values[k]:.3g}"
                 for i, (_, values) in enumerate(columns)]  # fmt: skip
        lines.append(f"| {result.contender} | {kept} | {' | '.join(cells)} |")
    return "\n".join(lines)


def retimed(tables: str, times: Sequence[Sequence[float]]) -> str:
    """Tables with new times [us] for each case and contender; the least is bold."""
    lines, at = [], -1
    for line in tables.splitlines():
        cells = line.split("|")
        if line.startswith("| contender"):
            at, rest = at + 1, list(times[at + 1])
        elif line.startswith("| "):
            now = rest.pop(0)
            cells[-2] = f" **{now:.3g}** " if now == min(times[at]) else f" {now:.3g} "
        lines.append("|".join(cells))
    return "\n".join(lines) + "\n"


def _rows(case: Case, scenario: Scenario) -> Floats:
    count = round((max(case.track, case.attack) + 2.0) / case.period)
    return sample(scenario, case.period * np.arange(count))


def _drawn(
    start: Mapping[str, tuple[float, ...]], count: int
) -> list[dict[str, tuple[float, ...]]]:
    draw = np.random.default_rng(0)
    return [dict(start)] + [
        {key: tuple(float(x * np.exp(draw.normal(0.0, SPREAD))) for x in value)
         for key, value in start.items()}
        for _ in range(count - 1)
    ]  # fmt: skip


def main(arguments: Sequence[str] | None = None) -> None:
    """Play all matches, print the tables, and with ``--out`` renew the page behind its mark."""
    parser = page_parser(__doc__, "short runs, two contenders, one case")
    parser.add_argument("--times", action="store_true", help="measure what steps take, no more")
    given = parser.parse_args(arguments)
    if given.out and MARK not in _text(given.out):
        parser.error(f"{given.out} is no page with the line {MARK!r}, behind which tables belong")
    quick = given.quick and not given.times
    cases = (Case(0.1, 0.05, track=4.0, attack=2.0),) if quick else CASES
    players = contenders()[0:6:5] if quick else contenders()
    if given.times:
        times = [[pace(case, one) for one in players] for case in cases]
        print("\n".join(" ".join(f"{x:.3g}" for x in each) for each in times))
        if given.out:
            head, mark, tables = _text(given.out).partition(MARK)
            with atomic_text(given.out) as file:
                file.write(head + mark + retimed(tables, times))
        return
    parts = []
    for case in cases:
        results = []
        for contender in players:
            begin = time.monotonic()
            results.append(play(case, contender, 1 if given.quick else BUDGET))
            print(f"{case.period:g} s, {case.delay:g} s, {contender.name}: {results[-1]}, "
                  f"{time.monotonic() - begin:.0f} s", flush=True)  # fmt: skip
        parts.append(table(case, results))
    print("\n\n".join(parts))
    if given.out:
        head, mark, _ = _text(given.out).partition(MARK)
        with atomic_text(given.out) as file:
            file.write(head + mark + "\n\n" + "\n\n".join(parts) + "\n")


def _text(page: Path) -> str:
    return page.read_text(encoding="utf-8") if page.is_file() else ""


MARK = "<!-- written by python -m benchmarks.match -->"

if __name__ == "__main__":
    main()
