"""The files of presets state the numbers listed in `presets.txt`.

After an intended change, `python -m tests.world.scenario.test_scenario_preset_numbers` writes
the list again.
"""

import tomllib
from importlib.resources import files
from pathlib import Path

from wmr_ctrl.world.scenario import preset_names

LIST = Path(__file__).with_name("presets.txt")


def tables(place, content):
    """Yield one line per table: its own values first, then the tables within it."""
    own = {key: value for key, value in content.items() if not isinstance(value, dict)}
    if own:
        yield f"{place}: {', '.join(f'{key} = {value}' for key, value in own.items())}"
    for key, value in content.items():
        if isinstance(value, dict):
            yield from tables(f"{place} {key}", value)


def listed():
    for name in preset_names():
        text = (files("wmr_ctrl.world.scenario") / "presets" / f"{name}.toml").read_text("utf-8")
        yield from tables(name, {k: v for k, v in tomllib.loads(text).items() if k != "title"})


def test_a_preset_is_the_robot_that_it_was():
    assert list(listed()) == LIST.read_text(encoding="utf-8").splitlines()


if __name__ == "__main__":
    LIST.write_text("".join(f"{item}\n" for item in listed()), encoding="utf-8")
