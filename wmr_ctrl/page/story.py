"""Scenes of the page: the story in five steps, or one scenario to play with.

What a step's text claims is held by a test, which runs the step.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from wmr_ctrl.scenario import Scenario, load_scenario, override

BOUNDED: Mapping[str, object] = {"disturbance.truncate": 3.0}
"""Noise with a bound, so that a guard can promise something."""


@dataclass(frozen=True)
class PageScene:
    """A start of the page: its scenario, what is said about it, and which laws are shown first.

    ``speed``: simulated seconds in one of the clock.
    """

    key: str
    title: str
    text: str
    scenario: Scenario
    shown: tuple[str, ...]
    speed: float = 1.0


@dataclass(frozen=True)
class StoryStep:
    """A step of the story: a preset with overrides."""

    key: str
    title: str
    text: str
    preset: str
    shown: tuple[str, ...]
    overrides: Mapping[str, object] = field(default_factory=dict)


STORY = (
    StoryStep(
        "barrier",
        "The barrier holds",
        "Both robots start beside the circle. PID shoots to three times the limit of 1 m/s at "
        "once; the paper’s model-based law (MB) keeps it, because its barrier function V1 grows "
        "as the velocity comes near. At 40 s the robot becomes heavier, with more friction.",
        "paper-simulation",
        ("mb", "pid"),
    ),
    StoryStep(
        "far",
        "Far away it breaks",
        "Now both of the paper’s laws start 7 m away, so they drive at the edge of the limit. At "
        "3 s the load falls off, and friction with it. The theorem says that the limit is kept; MB "
        "leaves it and never comes back, the adaptive network (NN) exceeds it for a moment.",
        "far-start-drop",
        ("mb", "nn"),
        BOUNDED,
    ),
    StoryStep(
        "guard",
        "The guard holds",
        "The same start and the same fall, with the velocity guard between law and wheels. It "
        "changes the force as little as the limit needs, for every mass, friction and noise "
        "within bounds that are stated. Switch it off below, and push the robot.",
        "far-start-drop",
        ("mb", "nn"),
        {**BOUNDED, "guard.enabled": True},
    ),
    StoryStep(
        "slow",
        "100 ms are too slow",
        "The paper’s experiment samples every 100 ms. Held for so long, the torque of both of its "
        "laws overshoots: they leave the limit within a tenth of a second, and MB does not follow "
        "the circle at all.",
        "paper-experiment-literal",
        ("mb", "nn"),
        BOUNDED,
    ),
    StoryStep(
        "tuned",
        "A law made for it",
        "The law prox takes the barrier’s step implicitly and estimates what disturbs. At the same "
        "100 ms, with a pose that is known to 5 cm, it follows the circle. Over 80 s the guard "
        "acts in half of all samples behind NN, and in one of two hundred behind prox.",
        "safe-experiment",
        ("prox", "nn"),
    ),
)
"""Told where the page is asked for with the scenario of its first step."""


def scenes(scenario: Scenario, laws: tuple[str, ...]) -> tuple[PageScene, ...]:
    """The story for ``laws`` where a scenario is the one it begins with, else one scene of it."""
    if scenario != load_scenario(STORY[0].preset):
        return (PageScene("own", scenario.title or scenario.name, "", scenario, laws[:4]),)
    return tuple(
        PageScene(
            step.key,
            step.title,
            step.text,
            override(load_scenario(step.preset), step.overrides),
            tuple(name for name in step.shown if name in laws) or laws[:2],
        )
        for step in STORY
    )
