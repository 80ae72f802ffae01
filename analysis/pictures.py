"""Draw the pictures of the README and of the documentation's pages into docs/images.

``python analysis/pictures.py`` draws all; with names (``limits period``) only these. Each function
is a picture; its runs are those that the page's text names.
"""

from __future__ import annotations

import math
import re
import sys
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path

import casadi as ca
import matplotlib as mpl
import numpy as np
from click.testing import CliRunner
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from PIL import Image, ImageSequence

import wmr_ctrl
from analysis.chain import picture
from benchmarks.paper_figures import all_drawings
from wmr_ctrl.cli.root import root
from wmr_ctrl.control.barrier.stable import stable_minimiser
from wmr_ctrl.control.guard.bounds import derived_guard
from wmr_ctrl.control.guard.price import usable_speed
from wmr_ctrl.report.animate import animate_runs
from wmr_ctrl.report.identified import drawing_of
from wmr_ctrl.report.style import LIMIT, house_style, look
from wmr_ctrl.results import Run
from wmr_ctrl.simulation.campaign import PAPER_LAWS
from wmr_ctrl.simulation.campaign.engine import run_campaign
from wmr_ctrl.simulation.campaign.paper_runs import paper_plan
from wmr_ctrl.world.effect import Bound

ROOT = Path(__file__).resolve().parents[1]
IMAGES = ROOT / "docs" / "images"
SHADES = ("#9BC4EA", "#3F7FBF", "#12365C")
"""Shades of a law's colour, from the smallest value to the largest."""
COLOURS = 64
"""Colours in a picture's palette: enough for lines and text, and the files stay small."""


def pair(*titles: str) -> tuple[Figure, Axes, Axes]:
    """Create two panels side by side."""
    figure = Figure(figsize=(7.4, 2.8), layout="constrained", dpi=110)
    left, right = figure.subplots(1, 2)
    left.set_title(titles[0])
    right.set_title(titles[1])
    return figure, left, right


def limit(axes: Axes, value: float = 1.0) -> None:
    """Draw a limit as a line, with the area beyond it shaded."""
    axes.axhline(value, color=LIMIT, lw=1.0)
    top = axes.get_ylim()[1]
    axes.axhspan(value, max(top, 1.15 * value), color=LIMIT, alpha=0.10, lw=0)


def runs(law: str, cases: Mapping[str, Mapping[str, object]], **options: object) -> dict[str, Run]:
    """Runs of the paper's simulation without noise, one for each case."""
    preset = options.pop("scenario", "paper-simulation-nominal")
    return {
        label: wmr_ctrl.simulate(preset, law, overrides=case, **options)  # type: ignore[arg-type]
        for label, case in cases.items()
    }


def limits() -> Figure:
    """Plot the target velocity over the demanded one, and v1 of a run, for three thresholds."""
    figure, left, right = pair("v_u1 = 1 m/s", "prox from the paper's start")
    c, u2 = ca.SX.sym("c"), ca.SX.sym("u2")
    aimed = ca.Function("aimed", [c, u2], [stable_minimiser(c, ca.SX(1.0), u2)])
    asked = np.linspace(0, 5, 400)
    cases = {}
    for shade, threshold in zip(SHADES, (0.5, 0.8, 0.95), strict=True):
        label = f"v_u2 = {threshold:g}"
        left.plot(asked, aimed(asked[None, :], threshold).full().ravel(), color=shade, label=label)
        cases[label] = {"limits.v_u2": [threshold, 1.3], "clock.duration": 4.0}
    for shade, (label, run) in zip(SHADES, runs("prox", cases).items(), strict=True):
        right.plot(run.time, run["v1"], color=shade, label=label)
    left.set(xlabel="velocity asked for, v_c0 [m/s]", ylabel="aimed at, v_c1 [m/s]", ylim=(0, 1.1))
    right.set(xlabel="t [s]", ylabel="v1 [m/s]", ylim=(0, 1.1))
    limit(left)
    limit(right)
    left.legend(loc="lower right")
    return figure


PERIODS = (0.005, 0.01, 0.02, 0.03, 0.04, 0.05, 0.06, 0.08, 0.1, 0.125)
"""Control periods of the picture [s]."""


def period() -> Figure:
    """Plot the largest speed against the period, by law, and the velocity at 100 ms."""
    figure, left, right = pair("Largest speed over its limit", "v1 at 100 ms")
    for law, guard in (("mb", False), ("nn", False), ("prox", False), ("mb", True)):
        shown, label = look(law), look(law).label + (", guarded" if guard else "")
        style = {"color": shown.colour, "ls": ":" if guard else "-", "lw": 1.3}
        worst = [fastest(law, step, guard) for step in PERIODS]
        steps = [1000 * step for step in PERIODS]
        left.plot(steps, worst, marker=shown.marker, ms=4, label=label, **style)
        run = wmr_ctrl.simulate(
            "paper-simulation-nominal", law, guard=guard, overrides=at_period(0.1)
        )
        right.plot(run.time, run["v1"], **style)
    left.set(xlabel="clock.control [ms]", ylabel="max |v|/v_u1, worse axis", ylim=(0.5, 2.5))
    right.set(xlabel="t [s]", ylabel="v1 [m/s]", ylim=(-1.4, 2), xlim=(0, 5))
    right.axhspan(-1.4, -1, color=LIMIT, alpha=0.10, lw=0)
    right.axhline(-1, color=LIMIT, lw=1.0)
    limit(left)
    limit(right)
    left.legend(loc="upper left")
    return figure


def at_period(step: float) -> dict[str, object]:
    """Overrides for a control period, and a duration of some 20 s that it divides."""
    return {"clock.control": step, "clock.duration": step * 2 * round(10.0 / step)}


def fastest(law: str, step: float, guard: bool) -> float:
    """Largest |v_i| divided by its limit, for the worse axis."""
    run = wmr_ctrl.simulate("paper-simulation-nominal", law, guard=guard, overrides=at_period(step))
    return max(v / u for v, u in zip(run.monitor.max_abs_v, run.settings.v_u1, strict=True))


def path_gains() -> Figure:
    """Plot the error to the left for three k[2], and the error ahead for three k[1]."""
    figure, left, right = pair("Error to the left", "Error ahead")
    sideways = {f"k[2] = {k:g}": {"gains.kinematics.k": [10.0, k, 4.0]} for k in (5.0, 20.0, 60.0)}
    ahead = {f"k[1] = {k:g}": {"gains.kinematics.k": [k, 5.0, 4.0]} for k in (1.0, 3.0, 10.0)}
    drawn(left, sideways, "e[2]", 30.0)
    drawn(right, ahead, "e[1]", 6.0)
    left.set_ylabel("e[2] [m]")
    right.set_ylabel("e[1] [m]")
    return figure


def law_gains() -> Figure:
    """Plot velocity and torque for three decay rates, from rest on the reference."""
    figure, left, right = pair("Velocity", "Torque of the right wheel")
    at_rest = wmr_ctrl.simulate("paper-simulation-nominal", "prox")
    start = [float(at_rest[name][0]) for name in ("x_d", "y_d", "theta_d")]
    cases = {
        f"rho = {first:g}, {second:g}": {
            "gains.prox.rho": [first, second], "initial.pose": start,
        }
        for first, second in ((4.0, 15.0), (15.0, 57.6), (60.0, 200.0))
    }  # fmt: skip
    drawn(left, cases, "v1", 1.5)
    drawn(right, cases, "tau_right", 0.5)
    left.set_ylabel("v1 [m/s]")
    right.set_ylabel("tau_right [N m]")
    return figure


def drawn(axes: Axes, cases: Mapping[str, Mapping[str, object]], column: str, end: float) -> None:
    """Draw a column of runs of prox up to a given time, for three cases."""
    for shade, (name, run) in zip(SHADES, runs("prox", cases).items(), strict=True):
        rows = run.time <= end
        axes.plot(run.time[rows], run[column][rows], color=shade, label=name)
    axes.set_xlabel("t [s]")
    axes.legend(loc="best")


def guard_price() -> Figure:
    """Plot the usable speed against the period for three bounds of the push."""
    figure = Figure(figsize=(5.4, 2.8), layout="constrained", dpi=110)
    axes = figure.subplots()
    periods = np.linspace(0.005, 0.15, 30)
    for shade, push in zip(SHADES, (20.0, 60.0, 120.0), strict=True):
        for mean, style in ((False, "-"), (True, "--")):
            speeds = [priced(step, push, mean) for step in periods]
            label = None if mean else f"dbar = {push:g} N"
            axes.plot(1000 * periods, speeds, style, color=shade, label=label)
    axes.set(xlabel="clock.control [ms]", ylabel="usable speed [m/s]", ylim=(0, 1.05))
    limit(axes)
    axes.legend(loc="lower left")
    return figure


def priced(step: float, push: float, mean: bool) -> float:
    """Highest steady speed against 39 N of friction [m/s]."""
    numbers = {"guard.dbar": [push, 5.0], "guard.M_min": [45.0, 4.86], "guard.trust": True}
    step = round(step, 3)
    clock = {"clock.control": step, "clock.duration": 100 * step}
    scenario = wmr_ctrl.load_scenario("paper-simulation-nominal", {**numbers, **clock})
    bound = Bound(window=(step, step)) if mean else Bound()
    return usable_speed(scenario, derived_guard(scenario, bound, math.inf), (39.0, 0.0))[0]


def guard_dbar() -> Figure:
    """Plot the velocity of prox from far away with the guard, for three bounds of the push."""
    figure = Figure(figsize=(5.4, 2.8), layout="constrained", dpi=110)
    axes = figure.subplots()
    cases = {
        f"dbar = {push:g} N": {
            "guard.dbar": [push, 15.0], "disturbance.truncate": 3.0, "clock.duration": 15.0,
            "clock.control": 0.05, "guard.trust": True, "metrics.split": 7.5,
        }
        for push in (60.0, 120.0, 200.0)
    }  # fmt: skip
    found = runs("prox", cases, scenario="far-start-drop", guard=True)
    for shade, (label, run) in zip(SHADES, found.items(), strict=True):
        axes.step(run.time, run["v1"], where="post", color=shade, lw=1.1, label=label)
    axes.set(xlabel="t [s]", ylabel="v1 [m/s]", ylim=(0, 1.1))
    limit(axes)
    axes.legend(loc="lower left")
    return figure


def robot() -> Figure:
    """Plot the first tutorial's drive, from the files on its page."""
    page = (ROOT / "docs" / "tutorials" / "robot.md").read_text(encoding="utf-8")
    return drive(page).plot()


def drive(page: str) -> Run:
    """Run of the scenario on a page."""
    with tempfile.TemporaryDirectory() as folder:
        for name, text in re.findall(r"<!-- file: (\S+) -->\n```\w+\n(.*?)```", page, re.S):
            (Path(folder) / name).write_text(text, encoding="utf-8")
        return wmr_ctrl.simulate(Path(folder) / "robot.toml", "prox", guard=True)


def identified() -> Figure:
    """Draw the fit of the log on the identification page."""
    docs = ROOT / "docs"
    page = (docs / "identify.md").read_text(encoding="utf-8")
    (known,) = re.findall(r"<!-- file: known.toml -->\n```\w+\n(.*?)```", page, re.S)
    with tempfile.TemporaryDirectory() as folder:
        sheet = Path(folder) / "known.toml"
        sheet.write_text(known, encoding="utf-8")
        found = wmr_ctrl.identify(docs / "robot-log.csv", known=sheet)
    with house_style():
        return drawing_of(found, found.traces()).figure()


def velocity() -> Figure:
    """Draw the report's panel of linear velocities."""
    return reported("fig3c_v1")


def stress() -> Figure:
    """Draw the report's picture of where the guarantee ends."""
    return reported("stress_velocities")


def reported(name: str) -> Figure:
    """Draw a figure of the report; it needs the first seed only."""
    plan = paper_plan(PAPER_LAWS, 1)
    campaign = run_campaign(plan)
    return next(item for item in all_drawings(campaign) if item.name == name).figure()


PICTURES: Mapping[str, Callable[[], Figure]] = {
    "limits": limits,
    "period": period,
    "path-gains": path_gains,
    "law-gains": law_gains,
    "guard-price": guard_price,
    "guard-dbar": guard_dbar,
    "robot": robot,
    "identified": identified,
    "velocity": velocity,
    "stress": stress,
    "proved": picture,
}


def guard() -> list[Run]:
    """Animate the model-based law from far away, without and with the guard."""
    numbers = {"disturbance.truncate": 3.0, "clock.duration": 12.0, "metrics.split": 6.0}
    return [
        wmr_ctrl.simulate("far-start-drop", "mb", guard=on, overrides=numbers)
        for on in (False, True)
    ]


FILMS: Mapping[str, Callable[[], list[Run]]] = {"guard": guard}


def save(figure: Figure, path: Path) -> None:
    """Write a picture with few colours and no date, so that equal pictures are equal files."""
    figure.savefig(path, metadata={"Software": None}, dpi=110)
    few_colours(path, path)


def few_colours(source: Path, path: Path) -> None:
    """Write a picture with a palette."""
    image = Image.open(source).convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE)
    image.save(path, optimize=True)


def in_gallery() -> list[tuple[str, Path]]:
    """Commands on the gallery's page, and the picture that each makes."""
    page = (ROOT / "docs" / "gallery.md").read_text(encoding="utf-8")
    shown = re.findall(r"^\$ wmr-ctrl (.*)\n```\n\n!\[.*?\]\((\S+)\)", page, re.M)
    return [(command, ROOT / "docs" / image) for command, image in shown]


def by_command(command: str, target: Path) -> None:
    """Save the picture that a command plots, with few colours."""
    words = command.split()
    with tempfile.TemporaryDirectory() as folder:
        made = Path(folder, words[words.index("--plot") + 1])
        words[words.index("--plot") + 1] = str(made)
        done = CliRunner().invoke(root, words)
        if done.exit_code:
            raise RuntimeError(f"{command}: {done.output}")
        target.parent.mkdir(exist_ok=True)
        few_colours(next(made.glob("*-poles.png")) if made.is_dir() else made, target)


def lighten(path: Path) -> None:
    """Keep every second frame of an animation, shown twice as long, for readers on phones."""
    with Image.open(path) as film:
        frames = [frame.copy() for frame in ImageSequence.Iterator(film)][::2]
        pace = 2 * int(film.info["duration"])
    frames[0].save(path, save_all=True, append_images=frames[1:], duration=pace, loop=0)


def main(names: list[str]) -> None:
    """Draw the named pictures, or all."""
    IMAGES.mkdir(parents=True, exist_ok=True)
    if not names or "gallery" in names:
        for command, target in in_gallery():
            by_command(command, target)
    for name in (one for one in names or (*PICTURES, *FILMS) if one != "gallery"):
        path = IMAGES / f"{name}{'.gif' if name in FILMS else '.png'}"
        if name in FILMS:
            animate_runs(FILMS[name](), path)
            lighten(path)
        else:
            with house_style(), mpl.rc_context({"savefig.bbox": None}):
                save(PICTURES[name](), path)
        sys.stderr.write(f"{path.relative_to(ROOT)}\n")


if __name__ == "__main__":
    main(sys.argv[1:])
