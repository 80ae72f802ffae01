"""Scenarios: frozen, validated dataclasses, read from TOML presets and users' files.

This layer does not depend on control laws or symbolic expressions; gains are kept as raw values.
"""

from wmr_ctrl.world.references import Circle as Circle
from wmr_ctrl.world.references import Lemniscate as Lemniscate
from wmr_ctrl.world.references import Line as Line
from wmr_ctrl.world.references import RoundedSquare as RoundedSquare
from wmr_ctrl.world.references import StopAndGo as StopAndGo
from wmr_ctrl.world.references import Waypoints as Waypoints

from .raw import from_dict as from_dict
from .raw import override as override
from .raw import parse_assignments as parse_assignments
from .raw import scenario_dict as scenario_dict
from .scenario import MissingKeysError as MissingKeysError
from .scenario import Scenario as Scenario
from .scenario import sections as sections
from .sections import Change as Change
from .sections import Guard as Guard
from .sections import Model as Model
from .sections import Robot as Robot
from .toml_io import inherited as inherited
from .toml_io import load_scenario as load_scenario
from .toml_io import loads_scenario as loads_scenario
from .toml_io import preset_names as preset_names
from .toml_io import preset_titles as preset_titles
from .toml_io import scenario_hash as scenario_hash
from .toml_io import title_of as title_of
from .toml_io import to_toml as to_toml
from .units import unit_questions as unit_questions
from .unstated import missing_text as missing_text
from .unstated import unknown_keys as unknown_keys
