"""Many runs: which ones, how they are run, and the resulting table of plain numbers.

One engine (`engine`) runs the paper's plan, the comparison past the paper (`comparison`: every law
with and without the guard) and the studies of users (`study_plan`, `study_run`, `study_store`).
What compiles is imported within functions, so that a worker that only runs starts without CasADi.
"""

from .engine import Campaign as Campaign
from .paper_runs import PAPER_LAWS as PAPER_LAWS
