"""Numbers and figures of the section on the rigid body, beside the plane model."""

from dataclasses import dataclass
from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon

from wmr_ctrl.results import PLANTS, Run, RunTable
from wmr_ctrl.simulation.campaign import Campaign
from wmr_ctrl.simulation.campaign.rigid import (
    AS_PRINTED,
    E1,
    RIGID_STUDIES,
    RigidClaim,
    rigid_claims,
)
from wmr_ctrl.world.scenario import Scenario, loads_scenario

from .drawing import Drawing, Padding, heading, law_handles, row_of_axes
from .style import INK, MUTED, look, shown

ISE = "ise_total"
FRAMES = 6
_BACK = 1.0
"""Time from the film's start to the fall [s]."""


@dataclass(frozen=True)
class RigidSection:
    """The rows on both plants, as the section's template shows them."""

    campaign: Campaign

    @property
    def findings(self) -> dict[str, list[dict[str, object]]]:
        """Findings by case, of the laws that ran on both plants."""
        plants = [self.campaign.table.where(plant=plant) for plant in PLANTS]
        by_case: dict[str, list[dict[str, object]]] = {}
        for study in RIGID_STUDIES["ode"]:
            for law in study.laws:
                plane, body = (rows.where(case=study.label, law=law) for rows in plants)
                if plane.rows and body.rows:
                    by_case.setdefault(study.label, []).append(_finding(law, plane, body))
        return by_case

    @property
    def claims(self) -> tuple[RigidClaim, ...]:
        """Expectations of a robot with tyres, and the verdicts."""
        return rigid_claims(self.campaign.table)

    @property
    def fallen(self) -> dict[str, Run]:
        """First runs that fell as printed, by law."""
        runs = {law: self.campaign.runs.get((AS_PRINTED, law)) for law in ("mb", "nn")}
        return {
            law: run
            for law, run in runs.items()
            if run and run.rows > 1 and run.monitor.rigid and run.monitor.rigid.tipped
        }


def _finding(law: str, plane: RunTable, body: RunTable) -> dict[str, object]:
    """Runs of a law on the rigid body: how many broke a limit, when they fell and slid [s].

    ``apart``: largest distance of a seed's ISE from the plane model's, a share; ``ise`` (on tyres
    of those that stayed up) and ``e1`` [m] on both plants.
    """
    apart = np.abs(body[ISE] / plane[ISE] - 1)
    ratios = apart[np.isfinite(apart)]
    upright = body.at(np.isnan(body["tipped"]))
    return {
        "law": law,
        "runs": body.rows,
        "broke": int((body["limit_ratio"] > 1).sum()),
        "falls": body.spread("tipped"),
        "slips": body.spread("slipped"),
        "apart": float(ratios.max()) if ratios.size else None,
        "ise": (plane.spread(ISE), upright.spread(ISE)),
        "e1": (plane.spread(E1), body.spread(E1)),
    }


# -- the figures --------------------------------------------------------------------------


def rigid_figures(campaign: Campaign) -> tuple[Drawing, ...]:
    """Spin and fall over time, and the last fall as a film; none where no law fell as printed."""
    runs = RigidSection(campaign).fallen
    if not runs:
        return ()
    return (
        Drawing("rigid_fall", (9.6, 2.6), partial(_draw_fall, runs=runs)),
        Drawing("rigid_film", (9.6, 2.0), partial(_draw_film, run=[*runs.values()][-1])),
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
    heading(figure, "Spin and fall of the laws as printed, on tyres", law_handles(runs), 0.26)


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
    axes.spines[:].set_visible(False)
