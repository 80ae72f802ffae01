"""References: desired trajectories, a file a kind, and numbers from their graphs."""

from .curves import Circle as Circle
from .curves import Lemniscate as Lemniscate
from .curves import Line as Line
from .curves import StopAndGo as StopAndGo
from .kind import Reference as Reference
from .kind import reference_bounds as reference_bounds
from .kind import sample as sample
from .registry import REFERENCES as REFERENCES
from .rounded_square import RoundedSquare as RoundedSquare
from .waypoints import Waypoints as Waypoints
