"""Half of all presets have a certified corridor within their tolerance; the others say why not."""

from importlib.resources import files

import pytest

from wmr_ctrl import simulate
from wmr_ctrl.results import distance
from wmr_ctrl.theory.checks.unknown_zero import COARSE, is_undisturbed
from wmr_ctrl.theory.corridor import find_corridor
from wmr_ctrl.world.references import sample
from wmr_ctrl.world.scenario import load_scenario, preset_names

pytestmark = pytest.mark.slow
CAUSES = ("disturbance.truncate", "[encoder]", "linear loop")
"""Causes that both a comment and the certificate's refusal name."""


@pytest.fixture(scope="module")
def corridors():
    """Corridors of all presets under kanayama, the law of most presets."""
    return {name: find_corridor(load_scenario(name), "kanayama") for name in preset_names()}


def is_told(name, corridor):
    """True for a corridor that is wider than a tape measure's step and within the tolerance."""
    most = load_scenario(name).metrics.tolerance
    return corridor.position is not None and COARSE <= corridor.position <= most


def reason_in_file(name):
    """The preset's comment that says why there is no certificate."""
    text = (files("wmr_ctrl.world.scenario") / "presets" / f"{name}.toml").read_text("utf-8")
    return next((line for line in text.splitlines() if line.startswith("# No corridor")), None)


def test_half_of_the_presets_have_a_corridor_within_their_tolerance(corridors):
    told = [name for name, corridor in corridors.items() if is_told(name, corridor)]

    assert 2 * len(told) >= len(corridors)
    assert [name for name in told if is_undisturbed(load_scenario(name))] == []


def test_presets_without_say_what_stops_it(corridors):
    for name, corridor in corridors.items():
        reason = reason_in_file(name)

        assert (reason is None) is is_told(name, corridor), name
        if reason is None:
            continue
        if corridor.position is None:
            assert any(cause in reason and cause in corridor.refused for cause in CAUSES), name
        else:
            assert "nothing disturbs" in reason
            assert is_undisturbed(load_scenario(name)), name


def test_runs_stay_in_the_corridors_of_their_presets(corridors):
    """Runs start on the path.  Bases are compared from 20 s on, because no run starts with commands
    in transit.
    """
    for name, corridor in corridors.items():
        if not is_told(name, corridor):
            continue
        case = load_scenario(name)
        x, y, theta, v, omega = map(float, sample(case, [0.0])[0][:5])
        on_path = {"initial.pose": [x, y, theta], "initial.velocity": [v, omega]}
        run = simulate(load_scenario(name, on_path), "kanayama")
        end = run.settings.index(corridor.until or run.settings.duration)
        first = run.settings.index(20.0) if corridor.late else 0

        assert distance(run)[first:end].max() <= (corridor.position or 0.0), name
