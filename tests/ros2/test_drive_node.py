"""The drive node over real DDS, in a namespace and with remapped topics: the run's bits."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import numpy as np
import pytest

from tests.ros2.conftest import OVER_DDS
from tests.ros2.lockstep import BASES, CARRIED, COMMON, messages, sent_by
from wmr_ctrl import simulate
from wmr_ctrl.scenario import load_scenario, to_toml
from wmr_ctrl.world.registry import EFFECTS

SCRIPT = Path(__file__).with_name("drive_outside.py")
pytestmark = [pytest.mark.slow, OVER_DDS]


@pytest.mark.parametrize("base", ["velocity, governor", "efforts, guard"])
def test_every_command_on_the_wire_is_that_of_the_run(
    ros, environment, tmp_path, monkeypatch, base
):
    law, changes = BASES[base]
    (tmp_path / "base.toml").write_text(
        to_toml(load_scenario("paper-simulation", {**COMMON, **changes}), comments=False),
        encoding="utf-8",
    )
    monkeypatch.setitem(EFFECTS.__dict__, "plugins", (CARRIED,))
    carried = load_scenario("paper-simulation", {**COMMON, **changes, "message.sent": 1.0})
    run = simulate(carried, law)
    rows = [[*message, stamp] for message, stamp in messages(run, carried.clock.control)]
    (tmp_path / "rows.json").write_text(json.dumps(rows), encoding="utf-8")
    given = [tmp_path / "base.toml", law, tmp_path / "rows.json", base.partition(",")[0]]
    done = subprocess.run(
        [ros, SCRIPT, *given], env=environment, capture_output=True, text=True, timeout=120,
        check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout[-500:] + done.stderr[-2000:]
    report = json.loads(done.stdout)

    assert np.array(report["answers"]).tobytes() == sent_by(run).tobytes()
    assert report["last"] == [0.0, 0.0]
    assert report["code"] == 0


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        (["scenario:={}"], "the parameter law is not set"),
        (["scenario:={}", "law:=fastest"], "fastest"),
        (["scenario:={}", "law:=pid", "reference:=path"], "waypoints"),
        (["scenario:={}", "law:=pid", "reference:=goal"], "must be one of scenario, path"),
        (["scenario:={}", "law:=pid", "wheels:=[left, left]"], "left and right"),
        (["scenario:={}", "law:=pid", "jump:=[0.1]"], "must have two"),
    ],
)
def test_what_cannot_be_configured_is_a_sentence(ros, environment, tmp_path, settings, said):
    path = tmp_path / "base.toml"
    path.write_text('extends = "paper-simulation"\n', encoding="utf-8")
    words = [part for word in settings for part in ("-p", word.format(path))]
    done = subprocess.run(
        [ros, "-m", "wmr_ctrl.ros2", "drive", "--ros-args", *words],
        env=environment, capture_output=True, text=True, timeout=60, check=False,
    )  # fmt: skip

    assert done.returncode == 2
    assert said in done.stderr
    assert "Traceback" not in done.stderr
