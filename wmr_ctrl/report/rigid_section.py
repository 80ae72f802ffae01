"""The section on the rigid body: what came out, plant against rigid body, with its pictures."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon

from wmr_ctrl.campaign import Campaign, FigureTable, RunRow, Study, spread
from wmr_ctrl.campaign.rigid import AS_PRINTED, E1, RIGID_STUDIES
from wmr_ctrl.campaign.rigid_claims import rigid_claims
from wmr_ctrl.report.drawing import Drawing, Padding, heading, law_handles, legend_row, row_of_axes
from wmr_ctrl.report.style import INK, MUTED, look, shown
from wmr_ctrl.report.tables import TextTable, headed
from wmr_ctrl.results import PLANTS, Run
from wmr_ctrl.results.windows import LATE
from wmr_ctrl.scenario import Scenario, loads_scenario

ISE = "ise_total"
RIGID_FIGURES = ("rigid_fall", "rigid_film")
"""Names of the figures, in the section's order."""


@dataclass(frozen=True, slots=True)
class RigidSection:
    """All that the section's template shows; ``findings`` by case."""

    seeds: Sequence[int]
    findings: Sequence[tuple[str, Sequence[RigidFinding]]]
    claims: TextTable
    table: TextTable
    drawings: Sequence[Drawing]


@dataclass(frozen=True, slots=True)
class RigidFinding:
    """What a law did on the rigid body: how many of its runs fell, slid and broke a limit.

    ``first_fall`` [s]; ``apart``: largest distance of a seed's ISE from the plane model's, a share.
    """

    law: str
    runs: int
    fell: int
    first_fall: float | None
    slid: int
    broke: int
    apart: float | None


def rigid_section(rows: FigureTable, drawings: Sequence[Drawing]) -> RigidSection:
    """Numbers of the sentences, the table and the figures."""
    seeds = sorted({row.seed for row in rows})
    cases = ((case.scenario, _findings(rows, case)) for case in RIGID_STUDIES["ode"])
    findings = tuple((name, laws) for name, laws in cases if laws)
    return RigidSection(seeds, findings, _claims(rows), _table(rows), tuple(drawings))


def _findings(rows: FigureTable, case: Study) -> list[RigidFinding]:
    name = case.scenario
    pairs = {law: [rows.of(name, law, plant=p) for p in PLANTS] for law in case.laws or ()}
    return [_finding(law, *pair) for law, pair in pairs.items() if all(pair)]


def _finding(law: str, plane: Sequence[RunRow], body: Sequence[RunRow]) -> RigidFinding:
    falls = [fall for row in body if (fall := row["tipped"]) is not None]
    both = ((p[ISE], b[ISE]) for p, b in zip(plane, body, strict=True))
    ratios = [abs(tyres / flat - 1) for flat, tyres in both if flat and tyres]
    return RigidFinding(
        headed(law),
        len(body),
        len(falls),
        min(falls, default=None),
        sum(row["slipped"] is not None for row in body),
        sum((row["limit_ratio"] or 0.0) > 1 for row in body),
        max(ratios, default=None),
    )


def _claims(rows: FigureTable) -> TextTable:
    body = tuple(
        (claim.text, headed(claim.law), "HOLDS" if claim.holds else "DOES NOT HOLD", claim.numbers)
        for claim in rigid_claims(rows)
    )
    caption = (
        "What a robot with tyres ought to do, and what came out: least … greatest of all seeds"
    )
    return TextTable(caption, ("asked", "law", "verdict", "found"), body)


def _table(rows: FigureTable) -> TextTable:
    body = tuple(
        (f"{case.scenario}: {headed(law)}", *_cells(rows, case.scenario, law))
        for case in RIGID_STUDIES["ode"]
        for law in case.laws or ()
        if rows.of(case.scenario, law, plant=PLANTS[1])
    )
    head = ("case", "ISE, plane", "ISE, tyres", "e₁, plane [mm]", "e₁, tyres [mm]", "slips [s]",
            "falls [s]")  # fmt: skip
    start, end = LATE
    caption = (
        f"Plane model and rigid body: ISE [m² s + rad² s] over the run, RMS of e₁ over "
        f"{start:g}–{end:g} s, and when a tread first slides and the robot falls: median (least … "
        "greatest) of the seeds in which it does"
    )
    return TextTable(caption, head, body)


def _cells(rows: FigureTable, case: str, law: str) -> tuple[str, ...]:
    plane, body = (rows.of(case, law, plant=plant) for plant in PLANTS)
    return (
        _range(row[ISE] for row in plane),
        _range(row[ISE] if not row["tipped"] else None for row in body),
        _range((row[E1] for row in plane), 1e3), _range((row[E1] for row in body), 1e3),
        _range(row["slipped"] for row in body), _range(row["tipped"] for row in body),
    )  # fmt: skip


def _range(values: Iterable[float | None], factor: float = 1.0) -> str:
    given = spread(None if value is None else factor * value for value in values)
    low, middle, high = (shown(x) for x in (given.min, given.median, given.max))
    return middle if low == high else f"{middle} ({low} … {high})"


# -- the figures --------------------------------------------------------------------------


def rigid_figures(rows: Campaign) -> tuple[Drawing, ...]:
    """Spin and fall over time, and the fall as a film, of the laws that fell as printed."""
    laws = tuple(law for law in ("mb", "nn") if _fell(rows, law))
    if not laws:
        return ()
    runs = {law: rows.runs[AS_PRINTED, law] for law in laws}
    law = laws[-1]
    return (
        Drawing(
            "rigid_fall",
            "How the paper’s laws fall",
            "The rigid body under the laws as printed, first seed, until it has tipped: how fast "
            "the treads slide over the ground (right solid, left dashed), and how far it leans.",
            (9.6, 2.6),
            partial(_draw_fall, runs=runs),
        ),
        Drawing(
            "rigid_film",
            f"The last moments of {look(law).label}",
            "From the side, drawn from the log at equal times up to the fall: the lean is that of "
            "the axis from the ground’s normal, whichever way; the spoke is where the wheel "
            "turned to; the figures are the speeds over ground and of the tread.",
            (9.6, 2.0),
            partial(_draw_film, run=runs[law]),
        ),
    )


def _fell(rows: Campaign, law: str) -> bool:
    run = rows.runs.get((AS_PRINTED, law))
    return (
        run is not None
        and run.rows > 1
        and (run.monitor.rigid is not None)
        and bool(run.monitor.rigid.tipped)
    )


def _draw_fall(figure: Figure, runs: dict[str, Run]) -> None:
    padding = Padding(left=0.60, right=0.15, bottom=0.42, top=0.56)
    slip, tilt = row_of_axes(figure, padding, (1.0, 1.0), 0.6)
    for law, run in runs.items():
        colour = look(law).colour
        for wheel, dash in ((0, "-"), (1, "--")):
            slip.plot(run.time, run["slip"][:, wheel], color=colour, ls=dash, lw=0.9)
        tilt.plot(run.time, np.degrees(run["tilt"]), color=colour)
    slip.set(xlabel="t [s]", ylabel="tread over ground [m/s]")
    tilt.set(xlabel="t [s]", ylabel="lean [degrees]")
    heading(figure, "Spin and fall of the laws as printed, on tyres")
    legend_row(figure, law_handles(runs), 0.26)


FRAMES = 6
_BACK = 1.0
"""How long before the fall the film begins [s]."""


def _draw_film(figure: Figure, run: Run) -> None:
    scenario = loads_scenario(str(run.provenance["scenario_toml"]))
    padding = Padding(left=0.08, right=0.08, bottom=0.42, top=0.34)
    last = run.rows - 1
    first = max(0, last - run.settings.index(_BACK))
    panels = row_of_axes(figure, padding, (1.0,) * FRAMES, 0.08)
    turned = np.cumsum(run["wheel_speed"][:, 0]) * run.settings.control
    for axes, row in zip(panels, np.linspace(first, last, FRAMES).round().astype(int), strict=True):
        _frame(axes, scenario, float(run["tilt"][row]), float(turned[row]))
        tread = scenario.robot.r * float(run["wheel_speed"][row, 0])
        lean = np.degrees(run["tilt"][row])
        speeds = f"{shown(float(run['v1'][row]), 2)}, {shown(tread, 2)} m/s"
        axes.set_xlabel(f"t = {run.time[row]:.2f} s, {lean:.0f}°\n{speeds}", size=7)
    heading(figure, f"{look(run.law).label} on tyres, as printed: the last {_BACK:g} s")


def _frame(axes: Axes, scenario: Scenario, tilt: float, turned: float) -> None:
    """The robot from the side, leaning about the wheel's foot."""
    r, caster = scenario.robot.r, scenario.body.caster
    low, high = 0.6 * r, 2.4 * r
    corners = np.array([[-caster, low], [caster, low], [caster, high], [-caster, high]])
    turn = np.array([[np.cos(tilt), np.sin(tilt)], [-np.sin(tilt), np.cos(tilt)]])
    axes.add_patch(Polygon(corners @ turn, closed=True, fc="none", ec=INK, lw=1.1))
    centre = np.array([0.0, r]) @ turn
    axes.add_patch(Circle((float(centre[0]), float(centre[1])), r, fc="white", ec=INK, lw=1.1))
    spoke = centre + 0.9 * r * np.array([np.sin(turned), np.cos(turned)])
    axes.plot([centre[0], spoke[0]], [centre[1], spoke[1]], color=INK, lw=1.0)
    axes.axhline(0, color=MUTED, lw=0.9)
    axes.set(xlim=(-0.45, 0.45), ylim=(-0.15, 0.5), aspect="equal", xticks=[], yticks=[])
    for side in axes.spines.values():
        side.set_visible(False)
