"""Many runs: which ones, how they are run, and the table of plain numbers that they leave.

One engine (`engine`) runs the paper's plan, the comparison past the paper (`comparison`: every law
with and without the guard) and the studies of users (`study_plan`, `study_run`, `study_store`).
What compiles is imported within functions, so that a worker that only runs starts without CasADi.
"""

from wmr_ctrl.campaign.engine import PhaseProgress, PlannedCase, PlannedRun, Silent
from wmr_ctrl.campaign.plan import (
    AS_STATED,
    BARRIER_LAWS,
    PAPER_LAWS,
    QUICK_SEEDS,
    STUDIES,
    Study,
    paper_plan,
)
from wmr_ctrl.campaign.run import Campaign, run_campaign
from wmr_ctrl.campaign.table import STATISTICS, FigureTable, RunRow, Spread, spread

__all__ = [
    "AS_STATED",
    "BARRIER_LAWS",
    "PAPER_LAWS",
    "QUICK_SEEDS",
    "STATISTICS",
    "STUDIES",
    "Campaign",
    "FigureTable",
    "PhaseProgress",
    "PlannedCase",
    "PlannedRun",
    "RunRow",
    "Silent",
    "Spread",
    "Study",
    "paper_plan",
    "run_campaign",
    "spread",
]
