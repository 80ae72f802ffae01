"""References: desired trajectories, a file a kind, and numbers from their graphs."""

from wmr_ctrl.world.references.curves import Circle as Circle
from wmr_ctrl.world.references.curves import Lemniscate as Lemniscate
from wmr_ctrl.world.references.curves import Line as Line
from wmr_ctrl.world.references.curves import StopAndGo as StopAndGo
from wmr_ctrl.world.references.kind import Reference as Reference
from wmr_ctrl.world.references.kind import reference_bounds as reference_bounds
from wmr_ctrl.world.references.kind import sample as sample
from wmr_ctrl.world.references.registry import REFERENCES as REFERENCES
from wmr_ctrl.world.references.rounded_square import RoundedSquare as RoundedSquare
from wmr_ctrl.world.references.waypoints import Waypoints as Waypoints
