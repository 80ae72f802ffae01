"""Linear analysis in python-control's language: exact, named, and compared with nonlinear runs.

Start with `report_linear` for figures, `closed_loop` for a `control.StateSpace`, `loop_nlsys` for
the nonlinear loop; docs/linear.md is the guide.
"""

from .answer import start_off as start_off
from .linear_report import LinearReport as LinearReport
from .linear_report import report_linear as report_linear
from .linearise import on_reference as on_reference
from .linearise import resting_point as resting_point
from .margins import margins_at as margins_at
from .margins import open_loop as open_loop
from .margins import with_robot as with_robot
from .margins import worst as worst
from .nonlinear import loop_nlsys as loop_nlsys
from .nonlinear import start_of as start_of
from .sampled import kink_periods as kink_periods
from .sampled import largest_learning_period as largest_learning_period
from .sampled import largest_stable_period as largest_stable_period
from .sampled import one_step_period as one_step_period
from .sampled import pull_curve as pull_curve
from .sampled import regressor_square as regressor_square
from .sampled import spectral_radius as spectral_radius
from .state_space import SADDLE as SADDLE
from .state_space import closed_loop as closed_loop
from .state_space import kinematic_poles as kinematic_poles
