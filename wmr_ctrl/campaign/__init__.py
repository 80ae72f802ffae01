"""Many runs: which ones, how they are run, and the table of plain numbers that they leave.

A campaign is handed what simulates (:class:`Simulate`) and what compiles (:data:`Prepare`), so this
layer knows nothing of laws, kernels or engines.  :mod:`wmr_ctrl.campaign.comparison` is the one
past the paper: every law with and without the guard.
"""

from wmr_ctrl.campaign.figures import FIGURES, Figure, figure_named
from wmr_ctrl.campaign.plan import PAPER_LAWS, QUICK_SEEDS, STUDIES, PlannedRun, Study, paper_plan
from wmr_ctrl.campaign.run import Campaign, PhaseProgress, Prepare, Silent, Simulate, run_campaign
from wmr_ctrl.campaign.table import STATISTICS, FigureRow, FigureTable, Spread, row_of, spread

__all__ = [
    "FIGURES",
    "PAPER_LAWS",
    "QUICK_SEEDS",
    "STATISTICS",
    "STUDIES",
    "Campaign",
    "Figure",
    "FigureRow",
    "FigureTable",
    "PhaseProgress",
    "PlannedRun",
    "Prepare",
    "Silent",
    "Simulate",
    "Spread",
    "Study",
    "figure_named",
    "paper_plan",
    "row_of",
    "run_campaign",
    "spread",
]
