"""Results of a run: its log, its outcome, the figures taken from it, and its files.

Everything here works on a finished :class:`Run`, whichever engine made it; nothing here computes
a trajectory.
"""

from wmr_ctrl.results.compare import ColumnDifference as ColumnDifference
from wmr_ctrl.results.compare import Comparison as Comparison
from wmr_ctrl.results.compare import Fact as Fact
from wmr_ctrl.results.compare import compare as compare
from wmr_ctrl.results.files import atomic_path as atomic_path
from wmr_ctrl.results.files import atomic_text as atomic_text
from wmr_ctrl.results.files import atomic_write as atomic_write
from wmr_ctrl.results.files import check_writable as check_writable
from wmr_ctrl.results.files import make_folder as make_folder
from wmr_ctrl.results.files import write_all as write_all
from wmr_ctrl.results.formats import check_suffix as check_suffix
from wmr_ctrl.results.formats import load_run as load_run
from wmr_ctrl.results.formats import runs_equal as runs_equal
from wmr_ctrl.results.formats import save_run as save_run
from wmr_ctrl.results.frames import json_safe as json_safe
from wmr_ctrl.results.frames import summary as summary
from wmr_ctrl.results.measures import Rises as Rises
from wmr_ctrl.results.measures import WeightNorm as WeightNorm
from wmr_ctrl.results.measures import arrival as arrival
from wmr_ctrl.results.measures import distance as distance
from wmr_ctrl.results.measures import e_rms as e_rms
from wmr_ctrl.results.measures import guard_share as guard_share
from wmr_ctrl.results.measures import ise as ise
from wmr_ctrl.results.measures import ise_over as ise_over
from wmr_ctrl.results.measures import position_max as position_max
from wmr_ctrl.results.measures import position_rms as position_rms
from wmr_ctrl.results.measures import rises as rises
from wmr_ctrl.results.measures import saturated_share as saturated_share
from wmr_ctrl.results.measures import settling_time as settling_time
from wmr_ctrl.results.measures import tau_peak as tau_peak
from wmr_ctrl.results.measures import tau_rms as tau_rms
from wmr_ctrl.results.measures import torque_change_rms as torque_change_rms
from wmr_ctrl.results.measures import torque_needed_rms as torque_needed_rms
from wmr_ctrl.results.measures import tracked as tracked
from wmr_ctrl.results.measures import tracking as tracking
from wmr_ctrl.results.measures import weight_norm as weight_norm
from wmr_ctrl.results.oscillation import Oscillation as Oscillation
from wmr_ctrl.results.oscillation import oscillation as oscillation
from wmr_ctrl.results.outcomes import DIVERGENCE as DIVERGENCE
from wmr_ctrl.results.outcomes import Event as Event
from wmr_ctrl.results.outcomes import Monitor as Monitor
from wmr_ctrl.results.outcomes import Outcome as Outcome
from wmr_ctrl.results.outcomes import RigidMonitor as RigidMonitor
from wmr_ctrl.results.outcomes import outcome_of as outcome_of
from wmr_ctrl.results.remarks import OBJECTED as OBJECTED
from wmr_ctrl.results.remarks import Remark as Remark
from wmr_ctrl.results.remarks import percent as percent
from wmr_ctrl.results.remarks import remarks_on as remarks_on
from wmr_ctrl.results.remarks import speeds as speeds
from wmr_ctrl.results.run import FloatArray as FloatArray
from wmr_ctrl.results.run import Run as Run
from wmr_ctrl.results.run import split_columns as split_columns
from wmr_ctrl.results.settings import PLANTS as PLANTS
from wmr_ctrl.results.settings import Assumptions as Assumptions
from wmr_ctrl.results.settings import Settings as Settings
from wmr_ctrl.results.settings import admitted as admitted
from wmr_ctrl.results.settings import first_beyond as first_beyond
from wmr_ctrl.results.settings import largest_push as largest_push
from wmr_ctrl.results.windows import covered as covered
from wmr_ctrl.results.windows import driving as driving
from wmr_ctrl.results.windows import window as window
