"""The paper's robot on its circle, with noise and without changes, for tests that mean it."""

from dataclasses import replace

from wmr_ctrl.world.scenario import load_scenario, loads_scenario

HEAD = 'extends = "paper-simulation-no-switch"\n'


def paper(**parts):
    """The scenario without a name, title and law, with other parts."""
    preset = load_scenario("paper-simulation-no-switch")
    return replace(preset, **{"name": "unnamed", "title": "", "law": None, **parts})


def paper_toml(text, name="unnamed", folder="."):
    """The scenario of TOML text, in which what it leaves out is the paper's."""
    whole = isinstance(text, bytes) or "extends" in text or ("[robot]" in text and "v_u1" in text)
    if whole:
        return loads_scenario(text, name, folder)
    loaded = loads_scenario(HEAD + text, name, folder)
    own = {key: None if key == "law" else "" for key in ("law", "title") if f"{key} =" not in text}
    return replace(loaded, **own)
