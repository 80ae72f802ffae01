"""The paper's robot on its circle, with noise and without changes, for tests that mean it."""

from dataclasses import replace
from functools import partial

from tests.tables import changes
from wmr_ctrl.world.scenario import load_scenario, loads_scenario

HEAD = 'extends = "paper-simulation-no-switch"\n'


def paper(**parts):
    """The scenario without a name, title and law, with other parts."""
    return replace(
        preset("paper-simulation-no-switch"),
        **{"name": "unnamed", "title": "", "law": None, **parts},
    )


def preset(name, *parts):
    """A preset with changes, each part a mapping or text of `tests.tables`."""
    told = [changes(part) if isinstance(part, str) else part for part in parts]
    return load_scenario(name, {key: value for part in told for key, value in part.items()})


safe = partial(preset, "safe-simulation")


def paper_toml(text, name="unnamed", folder="."):
    """The scenario of TOML text; omitted values are the paper's."""
    whole = isinstance(text, bytes) or "extends" in text or ("[robot]" in text and "v_u1" in text)
    if whole:
        return loads_scenario(text, name, folder)
    loaded = loads_scenario(HEAD + text, name, folder)
    own = {key: None if key == "law" else "" for key in ("law", "title") if f"{key} =" not in text}
    return replace(loaded, **own)
