"""Many runs: which ones, how they are run, and the table of plain numbers that they leave.

A campaign is handed what simulates (:class:`Simulate`) and what compiles (:data:`Prepare`), so this
layer knows nothing of laws, kernels or engines.
"""

from wmr_ctrl.campaign.figures import FIGURES, Figure, figure_named
from wmr_ctrl.campaign.plan import PAPER_LAWS, STUDIES, Study, Task, paper_plan
from wmr_ctrl.campaign.progress import Progress, Silent
from wmr_ctrl.campaign.rows import Row, row_of
from wmr_ctrl.campaign.run import Campaign, Loop, Prepare, Simulate, run_campaign
from wmr_ctrl.campaign.statistics import STATISTICS, Spread, spread
from wmr_ctrl.campaign.table import Table

__all__ = [
    "FIGURES",
    "PAPER_LAWS",
    "STATISTICS",
    "STUDIES",
    "Campaign",
    "Figure",
    "Loop",
    "Prepare",
    "Progress",
    "Row",
    "Silent",
    "Simulate",
    "Spread",
    "Study",
    "Table",
    "Task",
    "figure_named",
    "paper_plan",
    "row_of",
    "run_campaign",
    "spread",
]
