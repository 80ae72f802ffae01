"""A package in the folders that Arduino, PlatformIO, ESP-IDF or Zephyr expect."""

import re
from collections.abc import Mapping
from typing import Any

import jinja2

from wmr_ctrl.version import __version__

from .dialect import HEADER

_MANIFESTS = {
    "arduino": {
        "library.properties": "arduino_library.properties",
        "examples/wmr_{law}_sketch/wmr_{law}_sketch.ino": "arduino_sketch.ino",
    },
    "platformio": {"library.json": "platformio_library.json"},
    "esp-idf": {
        "CMakeLists.txt": "esp_idf_CMakeLists.txt",
        "idf_component.yml": "esp_idf_component.yml",
    },
    "zephyr": {
        "zephyr/module.yml": "zephyr_module.yml",
        "zephyr/Kconfig": "zephyr_Kconfig",
        "zephyr/CMakeLists.txt": "zephyr_CMakeLists.txt",
    },
}
"""Files that a tool reads, by their places, with their templates."""
VERSION = ".".join([*re.findall(r"\d+", __version__), "0", "0"][:3])
"""Version of the manifests, in three numbers."""


def arranged(
    files: Mapping[str, str], layout: str, engine: jinja2.Environment, context: Mapping[str, Any]
) -> dict[str, str]:
    """A package's files arranged for a build tool, together with that tool's own files.

    ``context`` is that of the package's templates.  Every name begins with the package's, so that
    several packages may be in one folder of sources; only names that a tool looks for do not.
    """
    law = context["law"]
    places = {name: _place(name, law) for name in files if name != "CMakeLists.txt"}
    named = re.compile("|".join(rf"(?<![\w/]){re.escape(name)}" for name in places))
    made = {}
    for name, place in places.items():
        shown = "{0}" if name.endswith(".md") else "{1}"

        def written(found: re.Match[str], shown: str = shown) -> str:
            to = places[found[0]]
            return shown.format(to, to.rpartition("/")[2])

        made[place] = named.sub(written, files[name])
    told = {**context, "version": VERSION}
    for place, template in _MANIFESTS[layout].items():
        made[place.format(law=law)] = engine.get_template(f"{template}.j2").render(told)
    return made


def _place(name: str, law: str) -> str:
    """Path of a file of a package, with a name that begins with the package's."""
    own = f"wmr_{law}"
    if name.startswith("README"):
        return f"{own}_README.md"
    if name in (f"{own}.h", f"{own}.c"):
        return f"src/{name}"
    if name == HEADER:
        return f"src/{own}_{name}"
    return f"extras/{own}_{name.removeprefix(f'{law}_')}"
