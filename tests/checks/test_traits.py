"""Warnings mention Eq. (7), a theorem, a barrier or a model only for laws that have one."""

import re

import pytest

from tests.control.laws.toys import PLAIN, install
from wmr_ctrl.control.laws import LAWS
from wmr_ctrl.control.setup import settle
from wmr_ctrl.theory.checks import warnings_for
from wmr_ctrl.world.scenario import load_scenario

FOREIGN = {
    "auxiliary": r"\(7\)|kinematic|\be2\b|\bk\[2\]|v_c0",
    "theorem": r"Theorem|theorems",
    "barrier": r"barrier|v_u2|Eqs?\. \((9|10|15)\)",
    "model": r"believe|model\.|the exact model",
}
"""Words about a trait, which a law without it must not read; the guard's own theorem is exempt."""
HARSH = {
    "gains.kinematics.k": "10, 0.5, 4",
    "reference.speed": "1.2",
    "reference.kind": "line",
    "initial.velocity": "1.3, 0.0",
    "actuator.delay": "0.02",
    "model.mu": "0.2",
    "disturbance.std": "1.0",
}


@pytest.fixture(autouse=True)
def plain(monkeypatch):
    install(monkeypatch, PLAIN)


def spoken(text, law):
    """Traits that a text mentions although the law does not state them."""
    stated = LAWS[law].traits
    return [name for name, words in FOREIGN.items()
            if re.search(words, text) and not getattr(stated, name)]  # fmt: skip


def warned(law, scenario="paper-simulation", **overrides):
    setup = settle(load_scenario(scenario, overrides), law)
    return "\n".join(map(str, warnings_for(setup))).replace("than the guard's theorem", "")


@pytest.mark.parametrize(
    "law, name, guard",
    [
        ("plain", "paper-experiment", True),
        ("plain", "paper-simulation", False),
        ("nn", "far-start", True),
    ],
)
def test_no_warning_mentions_a_trait_that_the_law_lacks(law, name, guard):
    assert spoken(warned(law, name, **{"guard.enabled": guard}), law) == []


@pytest.mark.parametrize("law", ["mb", "kanayama", "plain"])
def test_no_warning_mentions_a_missing_trait_when_everything_is_wrong(law):
    said = warned(law, **HARSH)

    assert said.count("\n") >= 2
    assert spoken(said, law) == []
