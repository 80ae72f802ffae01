"""What a run leaves behind: its log, its outcome, the figures taken from it, and its files.

Everything here works on a finished :class:`Run`, whichever engine made it; nothing here computes
a trajectory.
"""

from wmr_ctrl.results.assumptions import Assumptions, admitted, first_beyond, largest_push
from wmr_ctrl.results.compare import ColumnDifference, Comparison, compare
from wmr_ctrl.results.diagnostics import (
    Rises,
    WeightNorm,
    distance,
    rises,
    settling_time,
    weight_norm,
)
from wmr_ctrl.results.facts import Fact
from wmr_ctrl.results.files import atomic_path, atomic_write, check_writable, make_folder, write_all
from wmr_ctrl.results.io import check_suffix, load_run, runs_equal, save_run
from wmr_ctrl.results.metrics import e_rms, ise, ise_over, tau_peak, tau_rms
from wmr_ctrl.results.monitor import DIVERGENCE, Event, Monitor, RigidMonitor
from wmr_ctrl.results.oscillation import Oscillation, oscillation
from wmr_ctrl.results.outcomes import Outcome, outcome_of
from wmr_ctrl.results.plain import json_safe
from wmr_ctrl.results.remarks import OBJECTED, Remark, remarks_on
from wmr_ctrl.results.run import FloatArray, Run
from wmr_ctrl.results.settings import PLANTS, Settings
from wmr_ctrl.results.summary import summary
from wmr_ctrl.results.tracking import (
    arrival,
    driving,
    guard_share,
    position_max,
    position_rms,
    saturated_share,
    torque_change_rms,
    torque_needed_rms,
    tracked,
    tracking,
)
from wmr_ctrl.results.windows import covered, span, window
from wmr_ctrl.results.wording import percent, speeds

__all__ = [
    "DIVERGENCE",
    "OBJECTED",
    "PLANTS",
    "Assumptions",
    "ColumnDifference",
    "Comparison",
    "Event",
    "Fact",
    "FloatArray",
    "Monitor",
    "Oscillation",
    "Outcome",
    "Remark",
    "RigidMonitor",
    "Rises",
    "Run",
    "Settings",
    "WeightNorm",
    "admitted",
    "arrival",
    "atomic_path",
    "atomic_write",
    "check_suffix",
    "check_writable",
    "compare",
    "covered",
    "distance",
    "driving",
    "e_rms",
    "first_beyond",
    "guard_share",
    "ise",
    "ise_over",
    "json_safe",
    "largest_push",
    "load_run",
    "make_folder",
    "oscillation",
    "outcome_of",
    "percent",
    "position_max",
    "position_rms",
    "remarks_on",
    "rises",
    "runs_equal",
    "saturated_share",
    "save_run",
    "settling_time",
    "span",
    "speeds",
    "summary",
    "tau_peak",
    "tau_rms",
    "torque_change_rms",
    "torque_needed_rms",
    "tracked",
    "tracking",
    "weight_norm",
    "window",
    "write_all",
]
