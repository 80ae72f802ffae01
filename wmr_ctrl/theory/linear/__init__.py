"""Linear analysis in python-control's language: exact, named, and held against nonlinear runs.

Start with `report_linear` for figures, `closed_loop` for a `control.StateSpace`, `loop_nlsys` for
the nonlinear loop; the page docs/linear.md tells what is where.
"""

from wmr_ctrl.theory.linear.linear_report import LinearReport as LinearReport
from wmr_ctrl.theory.linear.linear_report import report_linear as report_linear
from wmr_ctrl.theory.linear.linearise import Point as Point
from wmr_ctrl.theory.linear.linearise import linearise as linearise
from wmr_ctrl.theory.linear.linearise import on_reference as on_reference
from wmr_ctrl.theory.linear.linearise import resting_point as resting_point
from wmr_ctrl.theory.linear.margins import Margins as Margins
from wmr_ctrl.theory.linear.margins import margins_at as margins_at
from wmr_ctrl.theory.linear.margins import open_loop as open_loop
from wmr_ctrl.theory.linear.margins import with_robot as with_robot
from wmr_ctrl.theory.linear.nonlinear import law_nlsys as law_nlsys
from wmr_ctrl.theory.linear.nonlinear import loop_nlsys as loop_nlsys
from wmr_ctrl.theory.linear.nonlinear import plant_nlsys as plant_nlsys
from wmr_ctrl.theory.linear.nonlinear import reference_nlsys as reference_nlsys
from wmr_ctrl.theory.linear.nonlinear import start_of as start_of
from wmr_ctrl.theory.linear.nonlinear import to_nlsys as to_nlsys
from wmr_ctrl.theory.linear.sampled import kink_periods as kink_periods
from wmr_ctrl.theory.linear.sampled import largest_learning_period as largest_learning_period
from wmr_ctrl.theory.linear.sampled import largest_stable_period as largest_stable_period
from wmr_ctrl.theory.linear.sampled import one_step_period as one_step_period
from wmr_ctrl.theory.linear.sampled import pull_curve as pull_curve
from wmr_ctrl.theory.linear.sampled import spectral_radius as spectral_radius
from wmr_ctrl.theory.linear.state_space import SADDLE as SADDLE
from wmr_ctrl.theory.linear.state_space import closed_loop as closed_loop
from wmr_ctrl.theory.linear.state_space import kinematic_loop as kinematic_loop
from wmr_ctrl.theory.linear.state_space import kinematic_poles as kinematic_poles
from wmr_ctrl.theory.linear.state_space import law_at as law_at
from wmr_ctrl.theory.linear.state_space import plant_at as plant_at
