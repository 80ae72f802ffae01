"""Map templates: rows that an FMU's names and units settle are filled in, and nothing else."""

import tomllib

import numpy as np
import pytest

from tests.export.cosim.foreign import PLANT
from wmr_ctrl.api import cosimulate
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.export.cosim.map_template import write_map_template
from wmr_ctrl.world.scenario import load_scenario

NOMINAL = "paper-simulation-nominal"


@pytest.mark.parametrize("fmi", [2, 3])
def test_template_of_an_fmu_with_our_names_runs_as_it_is(exported, tmp_path, fmi):
    plant, short = exported("plant", fmi, NOMINAL), load_scenario(NOMINAL, {"clock.duration": 0.5})
    path = write_map_template(tmp_path / "map.toml", plant, None)
    mapped = cosimulate(short, "pid", plant=plant, map_file=path)

    assert np.array_equal(mapped["v1"], cosimulate(short, "pid")["v1"])


@pytest.mark.parametrize("what", ["plant", "mb", "guard", "closed-loop", "reference"])
def test_template_lists_every_real_input_and_is_toml(exported, tmp_path, what):
    fmu = exported(what, 2, NOMINAL)
    text = write_map_template(tmp_path / "map.toml", None, fmu).read_text("utf-8")
    opened = "\n".join(line.removeprefix("# ") for line in text.splitlines()[2:])

    assert tomllib.loads(text).keys() == {"controller"}
    if what == "mb":
        rows = tomllib.loads(opened)["controller"]
        assert (rows["inputs"]["x_d"], rows["outputs"]["tau_right"]) == ("x_d", "tau_right")


def test_nothing_is_guessed_of_an_fmu_without_units(foreign, tmp_path):
    path = write_map_template(tmp_path / "map.toml", foreign("TheirRobot", PLANT), None)
    text = path.read_text("utf-8")

    assert not any(tomllib.loads(text)["plant"].values())
    assert '# motorR = { terms = { "" = 1.0 }, unit = "" }' in text
    assert "could be px, py, heading, wheelR, wheelL" in text


def test_template_overwrites_nothing_and_needs_an_fmu(exported, tmp_path):
    taken = tmp_path / "map.toml"
    taken.write_text("mine", "utf-8")
    plant = exported("plant", 2, NOMINAL)

    with pytest.raises(ArgumentError, match="exists"):
        write_map_template(taken, plant, None)
    with pytest.raises(ArgumentError, match="--plant"):
        write_map_template(tmp_path / "new.toml", None, None)
    assert taken.read_text("utf-8") == "mine"
