"""Reader of robot files of all kinds, which it recognises by their content."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Sequence
from pathlib import Path

from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.core.fields.files import read_text
from wmr_ctrl.core.fields.yaml_text import yaml_document

from . import controllers, gazebo, nav2, urdf
from .found import Found, Sheet, merged
from .parameter_files import nodes
from .xml_text import expanded, has_macros, tree

XML, YAML = (".urdf", ".xacro", ".sdf", ".xml", ".world"), (".yaml", ".yml")
WHEELS = re.compile("(left|right)_wheel(_names)?")
"""Parameters that name a controller's wheel joints."""
LARGEST = 5_000_000
"""Bytes of a file that is read at most."""
KINDS = (
    "URDF and xacro, controllers of ros2_control (diff_drive_controller), parameters of nav2, and "
    "the differential drive of Gazebo"
)


def read_robot_files(files: Sequence[str | os.PathLike[str]]) -> Sheet:
    """Merge robot files; if they disagree, the controller's value is used.

    Raises ScenarioError, naming the file, for a file of an unknown kind and for any error in it.
    """
    texts = {Path(file): read_text(Path(file), "--from", (*XML, *YAML), LARGEST) for file in files}
    items: list[Found] = []
    named: list[str] = []
    for file, text in texts.items():
        if file.suffix.lower() in YAML:
            items += _parameters(text, file.name, named)
    for file, text in texts.items():
        if file.suffix.lower() in XML:
            items += _description(text, file, named)
    return merged(items)


def _parameters(text: str, file: str, named: list[str]) -> Iterator[Found]:
    """Values of a YAML file; the controller's wheel joints are appended to ``named``."""
    known, drive = False, ""
    for node, params in nodes(yaml_document(text, file)):
        if controllers.is_controller(params):
            if drive:
                raise ScenarioError(
                    f"{file} has two differential drives, {drive} and {node}. Keep the robot's own."
                )
            known, drive = True, node
            named += [
                str(name)
                for key, given in params.items()
                if WHEELS.fullmatch(key)
                for name in (given if isinstance(given, list) else [given])
            ]
            yield from controllers.read(node, params, file)
        elif nav2.reads(node):
            known = True
            yield from nav2.read(node, params, file)
    if not known:
        raise ScenarioError(
            f"{file} is of no known kind: no node of it is a diff_drive_controller, a "
            f"velocity_smoother, a controller_server or a costmap. Known are {KINDS}."
        )


def _description(text: str, file: Path, named: Sequence[str]) -> Iterator[Found]:
    """Values of a URDF, a xacro or an SDF file."""
    root = tree(text, file.name)
    if root.tag == "robot" and has_macros(root):
        root = tree(expanded(file, file.name), file.name)
    drives = gazebo.drives(root)
    if len(drives) > 1:
        raise ScenarioError(
            f"{file.name} has {len(drives)} differential drives of Gazebo. Keep the robot's own."
        )
    for drive in drives:
        yield from gazebo.read(drive, file.name)
    if root.tag == "robot" and root.find("link") is not None:
        driven = [*named, *(name for drive in drives for name in gazebo.joints(drive))]
        there = {item.get("name") for item in root.iterchildren("joint")}
        known = [name for name in driven if name in there]
        if len(known) == 1:
            lost = ", ".join(name for name in driven if name not in there)
            raise ScenarioError(
                f"{file.name} has {known[0]}, but no joint {lost}, which the controller names. "
                "Correct one of the files."
            )
        yield from urdf.read(root, file.name, known)
    elif not drives:
        raise ScenarioError(
            f"{file.name} is of no known kind: it has neither a <robot> with links nor a "
            f"differential drive of Gazebo. Known are {KINDS}."
        )
