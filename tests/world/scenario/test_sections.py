"""Every key has the default, unit and range listed in `keys.txt`.

So a file that omits a key keeps its meaning.  After an intended change, `python -m
tests.world.scenario.test_sections` writes the list again.
"""

from pathlib import Path

from wmr_ctrl.control.laws import LAWS
from wmr_ctrl.core.fields.section import REQUIRED, quantities
from wmr_ctrl.core.fields.unstated import Unstated
from wmr_ctrl.world.model.kinematics import KinematicGains
from wmr_ctrl.world.references import REFERENCES
from wmr_ctrl.world.scenario.scenario import sections
from wmr_ctrl.world.scenario.sections import Change

LIST = Path(__file__).with_name("keys.txt")


def tables():
    yield from sections().items()
    yield "changes", Change
    yield from ((f"reference ({kind})", REFERENCES[kind].section) for kind in REFERENCES)
    yield "gains.kinematics", KinematicGains
    own = {law: LAWS[law].gains for law in LAWS}
    yield from ((f"gains.{law}", own[law]) for law in own if is_ours(own[law]))


def is_ours(section):
    """False for gains of a law that another test registered."""
    return section.__module__.startswith("wmr_ctrl.")


def line(key, what):
    """Describe a key in one line: its default, its unit, and the other values it may have."""
    ends = {n: getattr(what.bounds, n) for n in ("above", "minimum", "below", "maximum")}
    said = [f"{name} {end:g}" for name, end in ends.items() if end is not None]
    said += ["or inf"] * what.bounds.infinite
    said += [f"one of {', '.join(what.options)}"] * bool(what.options)
    said += [f"usual {what.usual[0]:g} to {what.usual[1]:g}"] if what.usual else []
    said += [f"multiple of {what.multiple_of}, {what.most} at most"] * bool(what.multiple_of)
    said += [f"an orientation ({what.orientation:+d})"] * bool(what.orientation)
    unstated = what.default is REQUIRED or isinstance(what.default, Unstated)
    default = "-" if unstated else what.default
    return "; ".join([f"{key} = {default} [{what.unit}]", *said])


def listed():
    lines = [line(f"{place}.{n}", what) for place, own in tables() for n, what in quantities(own)]
    return "".join(f"{item}\n" for item in lines)


def test_a_key_that_is_left_out_means_what_it_did():
    assert listed().splitlines() == LIST.read_text(encoding="utf-8").splitlines()


if __name__ == "__main__":
    LIST.write_text(listed(), encoding="utf-8")
