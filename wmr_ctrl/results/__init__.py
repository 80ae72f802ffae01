"""Results of a run: its log, its outcome, the figures taken from it, and its files.

Everything here works on a finished :class:`Run`, whichever engine made it; nothing here computes
a trajectory.
"""

from wmr_ctrl.results.files import atomic_path as atomic_path
from wmr_ctrl.results.files import atomic_text as atomic_text
from wmr_ctrl.results.files import check_writable as check_writable
from wmr_ctrl.results.files import make_folder as make_folder
from wmr_ctrl.results.files import new_folder as new_folder
from wmr_ctrl.results.files import write_all as write_all
from wmr_ctrl.results.formats import load_run as load_run
from wmr_ctrl.results.frames import json_safe as json_safe
from wmr_ctrl.results.frames import summary as summary
from wmr_ctrl.results.measures import Rises as Rises
from wmr_ctrl.results.measures import distance as distance
from wmr_ctrl.results.measures import e_rms as e_rms
from wmr_ctrl.results.measures import ise as ise
from wmr_ctrl.results.measures import position_rms as position_rms
from wmr_ctrl.results.measures import rises as rises
from wmr_ctrl.results.measures import tau_peak as tau_peak
from wmr_ctrl.results.measures import tau_rms as tau_rms
from wmr_ctrl.results.measures import tracked as tracked
from wmr_ctrl.results.outcomes import Monitor as Monitor
from wmr_ctrl.results.outcomes import Outcome as Outcome
from wmr_ctrl.results.outcomes import RigidMonitor as RigidMonitor
from wmr_ctrl.results.outcomes import outcome_of as outcome_of
from wmr_ctrl.results.remarks import NOT_CHECKED as NOT_CHECKED
from wmr_ctrl.results.remarks import OBJECTED as OBJECTED
from wmr_ctrl.results.remarks import percent as percent
from wmr_ctrl.results.remarks import speeds as speeds
from wmr_ctrl.results.run import Floats as Floats
from wmr_ctrl.results.run import Run as Run
from wmr_ctrl.results.run import split_columns as split_columns
from wmr_ctrl.results.settings import PLANTS as PLANTS
from wmr_ctrl.results.settings import Assumptions as Assumptions
from wmr_ctrl.results.settings import Settings as Settings
from wmr_ctrl.results.windows import driving as driving
from wmr_ctrl.results.windows import labouring as labouring
