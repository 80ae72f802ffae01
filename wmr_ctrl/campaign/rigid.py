"""The plane model beside the robot as a rigid body on tyres: the same cases, laws, seeds on both.

A slope has a key of its own on either plant, since one inclines the ground and the other pulls.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType

from wmr_ctrl.campaign.engine import Overrides, PhaseProgress
from wmr_ctrl.campaign.plan import Study
from wmr_ctrl.campaign.run import Campaign, run_campaign
from wmr_ctrl.campaign.table import FigureTable
from wmr_ctrl.results import PLANTS
from wmr_ctrl.results.windows import BEFORE, LATE, named

RIGID_SEEDS = (2100, 2101, 2102, 2103, 2104)
"""Seeds with which nothing about the body was chosen."""

_LIMIT: Overrides = MappingProxyType({"actuator.tau_max": 10.0})
_STEEP = math.radians(5.0)
_SLOPE: Mapping[str, Overrides] = {
    "ode": {"slope.angle": _STEEP, "slope.direction": math.pi / 2},
    "mujoco": {"body.slope": _STEEP},
}


AS_PRINTED, LIMITED = "no torque limit, as printed", "torque limit 10 N m"
ENCODERS = "encoders of 4096 counts, no torque limit"
GUARDED, SLOPED = (
    "guard with alpha = 5/s, no torque limit",
    "slope of 5 degrees, torque limit 10 N m",
)
STEPS = {h: f"plant step of {1e3 * h:g} ms, torque limit 10 N m" for h in (5e-4, 2e-3)}
OURS_TOO = ("mb", "nn", "prox")


def _studies(plant: str) -> tuple[Study, ...]:
    """From what spins and falls to what does not."""
    paper, steady = "paper-simulation", "paper-simulation-no-switch"
    guarded = {"guard.alpha": 5.0, "disturbance.truncate": 3.0}
    ours = [
        (ENCODERS, paper, {"encoder.counts": 4096}),
        (LIMITED, paper, _LIMIT),
        *((name, paper, {**_LIMIT, "clock.plant": h}) for h, name in STEPS.items()),
        (GUARDED, steady, guarded),
        (SLOPED, steady, {**_LIMIT, **_SLOPE[plant]}),
    ]
    return (
        Study(paper, name=AS_PRINTED, laws=("pid", "smc", "mb", "nn")),
        *(
            Study(preset, None, name, "", OURS_TOO, changes, (True if name == GUARDED else None,))
            for name, preset, changes in ours
        ),
    )


RIGID_STUDIES: Mapping[str, tuple[Study, ...]] = {plant: _studies(plant) for plant in PLANTS}
"""The cases on each plant."""
E1_BEFORE, E1 = f"e1_rms_{named(BEFORE)}", f"e1_rms_{named(LATE)}"
COMPARED = ("ise_total", E1_BEFORE, E1, "limit_ratio", "slipped", "tipped")
"""Figures of the comparison."""


def run_rigid_comparison(
    seeds: Sequence[int] = RIGID_SEEDS,
    jobs: int | None = None,
    progress: PhaseProgress | None = None,
) -> Campaign:
    """Every case, law and seed on both plants, each two phases of ``progress``.

    Whole runs are those on tyres.  Raises MissingExtraError without the extra physics.
    """
    done = []
    for plant in PLANTS:
        laws = ("pid", "smc", "mb", "nn", "prox")
        plan = [run for study in RIGID_STUDIES[plant] for run in study.runs(laws, seeds, plant)]
        name = "on tyres" if plant == "mujoco" else "on the plane model"
        texts = f"Compiling the laws {name}", f"Running the laws {name}"
        done.append(run_campaign(plan, jobs, progress, COMPARED, plant == "mujoco", texts))
    return Campaign(FigureTable(row for one in done for row in one.table), done[-1].runs)
