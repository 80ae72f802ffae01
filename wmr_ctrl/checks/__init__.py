"""What theory says before a run: sample time, preconditions, start, network, barrier.

`warnings_for` answers for one law on one scenario; nothing here simulates more than one control
period, and nothing is ever refused.
"""

from wmr_ctrl.checks.before_run import warnings_for as warnings_for
from wmr_ctrl.checks.sampled_loop import largest_stable_period as largest_stable_period
from wmr_ctrl.checks.warning import Warning as Warning
