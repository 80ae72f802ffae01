"""Scenarios: frozen, validated dataclasses, read from TOML presets and users' files.

This layer knows nothing of control laws or symbolic expressions; gains are kept as raw values.
"""

from wmr_ctrl.core.fields.section import Section as Section
from wmr_ctrl.core.fields.section import quantities as quantities
from wmr_ctrl.world.references import Circle as Circle
from wmr_ctrl.world.references import Lemniscate as Lemniscate
from wmr_ctrl.world.references import Line as Line
from wmr_ctrl.world.references import Reference as Reference
from wmr_ctrl.world.references import RoundedSquare as RoundedSquare
from wmr_ctrl.world.references import StopAndGo as StopAndGo
from wmr_ctrl.world.references import Waypoints as Waypoints
from wmr_ctrl.world.registry import Actuator as Actuator
from wmr_ctrl.world.registry import Disturbance as Disturbance
from wmr_ctrl.world.registry import Sensor as Sensor
from wmr_ctrl.world.scenario.raw import from_dict as from_dict
from wmr_ctrl.world.scenario.raw import override as override
from wmr_ctrl.world.scenario.raw import parse_assignments as parse_assignments
from wmr_ctrl.world.scenario.raw import scenario_dict as scenario_dict
from wmr_ctrl.world.scenario.scenario import Scenario as Scenario
from wmr_ctrl.world.scenario.sections import Change as Change
from wmr_ctrl.world.scenario.sections import Guard as Guard
from wmr_ctrl.world.scenario.sections import Model as Model
from wmr_ctrl.world.scenario.sections import Robot as Robot
from wmr_ctrl.world.scenario.toml_io import inherited as inherited
from wmr_ctrl.world.scenario.toml_io import load_scenario as load_scenario
from wmr_ctrl.world.scenario.toml_io import loads_scenario as loads_scenario
from wmr_ctrl.world.scenario.toml_io import preset_names as preset_names
from wmr_ctrl.world.scenario.toml_io import preset_titles as preset_titles
from wmr_ctrl.world.scenario.toml_io import title_of as title_of
from wmr_ctrl.world.scenario.toml_io import to_toml as to_toml
