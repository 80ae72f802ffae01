from .found import NAMES as NAMES
from .found import Found as Found
from .found import Sheet as Sheet
from .found import shown as shown
from .read import read_robot_files as read_robot_files
