"""Linear analysis in python-control's language: exact, named, and held against nonlinear runs.

Start with `report_linear` for figures, `closed_loop` for a `control.StateSpace`, `loop_nlsys` for
the nonlinear loop; the page docs/linear.md tells what is where.
"""

from wmr_ctrl.linear.kinematic import SADDLE as SADDLE
from wmr_ctrl.linear.kinematic import kinematic_loop as kinematic_loop
from wmr_ctrl.linear.kinematic import kinematic_poles as kinematic_poles
from wmr_ctrl.linear.kinematic import kinematics_at as kinematics_at
from wmr_ctrl.linear.linearise import linearise as linearise
from wmr_ctrl.linear.margins import Margins as Margins
from wmr_ctrl.linear.margins import margins_at as margins_at
from wmr_ctrl.linear.margins import open_loop as open_loop
from wmr_ctrl.linear.margins import with_robot as with_robot
from wmr_ctrl.linear.nonlinear import law_nlsys as law_nlsys
from wmr_ctrl.linear.nonlinear import loop_nlsys as loop_nlsys
from wmr_ctrl.linear.nonlinear import plant_nlsys as plant_nlsys
from wmr_ctrl.linear.nonlinear import reference_nlsys as reference_nlsys
from wmr_ctrl.linear.nonlinear import start_of as start_of
from wmr_ctrl.linear.nonlinear import to_nlsys as to_nlsys
from wmr_ctrl.linear.point import Point as Point
from wmr_ctrl.linear.point import on_reference as on_reference
from wmr_ctrl.linear.point import resting_point as resting_point
from wmr_ctrl.linear.pose_gain import best_gain as best_gain
from wmr_ctrl.linear.pose_gain import noise_ise as noise_ise
from wmr_ctrl.linear.pull import BarrierTerm as BarrierTerm
from wmr_ctrl.linear.pull import VelocityFeedback as VelocityFeedback
from wmr_ctrl.linear.pull import authority as authority
from wmr_ctrl.linear.pull import dead_zone as dead_zone
from wmr_ctrl.linear.pull import linear_offset as linear_offset
from wmr_ctrl.linear.pull import pull_curve as pull_curve
from wmr_ctrl.linear.pull import settled_speed as settled_speed
from wmr_ctrl.linear.report import LinearReport as LinearReport
from wmr_ctrl.linear.report import report_linear as report_linear
from wmr_ctrl.linear.sampled import frozen_regressor as frozen_regressor
from wmr_ctrl.linear.sampled import kink_periods as kink_periods
from wmr_ctrl.linear.sampled import largest_learning_period as largest_learning_period
from wmr_ctrl.linear.sampled import largest_stable_period as largest_stable_period
from wmr_ctrl.linear.sampled import largest_stable_square as largest_stable_square
from wmr_ctrl.linear.sampled import learning_periods as learning_periods
from wmr_ctrl.linear.sampled import one_step_period as one_step_period
from wmr_ctrl.linear.sampled import regressor_square as regressor_square
from wmr_ctrl.linear.sampled import spectral_radius as spectral_radius
from wmr_ctrl.linear.state_space import TimeInvariant as TimeInvariant
from wmr_ctrl.linear.state_space import TimeVarying as TimeVarying
from wmr_ctrl.linear.state_space import along_reference as along_reference
from wmr_ctrl.linear.state_space import closed_loop as closed_loop
from wmr_ctrl.linear.state_space import law_at as law_at
from wmr_ctrl.linear.state_space import plant_at as plant_at
from wmr_ctrl.linear.stepper import linear_gain as linear_gain
from wmr_ctrl.linear.stepper import loop_pair as loop_pair
from wmr_ctrl.linear.stepper import reach as reach
from wmr_ctrl.linear.stepper import stepper as stepper
from wmr_ctrl.linear.stepper import sweep as sweep
