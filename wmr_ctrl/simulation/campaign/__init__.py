"""Many runs: which ones, how they are run, and the table of plain numbers that they leave.

One engine (`engine`) runs the paper's plan, the comparison past the paper (`comparison`: every law
with and without the guard) and the studies of users (`study_plan`, `study_run`, `study_store`).
What compiles is imported within functions, so that a worker that only runs starts without CasADi.
"""

from wmr_ctrl.simulation.campaign.engine import Campaign as Campaign
from wmr_ctrl.simulation.campaign.engine import PhaseProgress as PhaseProgress
from wmr_ctrl.simulation.campaign.engine import phase as phase
from wmr_ctrl.simulation.campaign.paper_runs import PAPER_LAWS as PAPER_LAWS
