"""Many runs: which ones, how they are run, and the table of plain numbers that they leave.

One engine (`engine`) runs the paper's plan, the comparison past the paper (`comparison`: every law
with and without the guard) and the studies of users (`study_plan`, `study_run`, `study_store`).
What compiles is imported within functions, so that a worker that only runs starts without CasADi.
"""

from wmr_ctrl.campaign.engine import Campaign as Campaign
from wmr_ctrl.campaign.engine import PhaseProgress as PhaseProgress
from wmr_ctrl.campaign.engine import Silent as Silent
from wmr_ctrl.campaign.engine import run_campaign as run_campaign
from wmr_ctrl.campaign.paper import AS_STATED as AS_STATED
from wmr_ctrl.campaign.paper import BARRIER_LAWS as BARRIER_LAWS
from wmr_ctrl.campaign.paper import PAPER_LAWS as PAPER_LAWS
from wmr_ctrl.campaign.paper import QUICK_SEEDS as QUICK_SEEDS
from wmr_ctrl.campaign.paper import STUDIES as STUDIES
from wmr_ctrl.campaign.paper import paper_plan as paper_plan
from wmr_ctrl.campaign.plan import PlannedCase as PlannedCase
from wmr_ctrl.campaign.plan import PlannedRun as PlannedRun
from wmr_ctrl.campaign.plan import Study as Study
