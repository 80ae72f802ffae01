"""No field of a scenario is lost: native loop, closed-loop FMU and co-simulation act alike.

All fields of a section, of a kind of reference, or of a law's gains are changed at once, each to a
value of its own; that each of them matters by itself is seen in the native loop.  Each scenario is
run three ways.  Where it differs from the base in numbers only, the FMUs are the
base's with parameters set; else they are exported anew.
"""

from functools import cache
from itertools import groupby
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from fmpy import extract

from tests.export.fmi.fields import FULL, LOOSE, based, of_gains, of_sections
from tests.export.fmi.raw import OK, Fmu
from wmr_ctrl.api import simulate
from wmr_ctrl.control.laws import LAWS
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.fields.section import quantities
from wmr_ctrl.export.cosim import cosimulate
from wmr_ctrl.export.fmi.closed_loop import closed_loop_model
from wmr_ctrl.export.fmi.files import sources_of
from wmr_ctrl.export.fmi.fmu_files import export_fmu, model_of
from wmr_ctrl.world.scenario import override
from wmr_ctrl.world.scenario.sections import Body

LAW = "mb"
STATE = {"x", "y", "theta", "v1", "omega", "psi"}
WITHOUT_EFFECT = {
    "name",
    "title",
    "metrics.split",
    "metrics.rms_from",
    "metrics.tolerance",
    "corridor.start",
    "corridor.cells",
    "corridor.losses",
    "guard.trust",
    "ros.base_frame",
    *(f"body.{name}" for name, _ in quantities(Body)),
}
"""Fields that no run on the plane model depends on."""
BASE, LOOSER = based(FULL), based(LOOSE)


def by_section(changed):
    """Section, and whether the base leaves the field to be derived."""
    section, _, name = changed[0].rpartition(".")
    return section, getattr(getattr(BASE, section, None), name, 0) is None


def together(listed):
    """Several changes as one."""
    return {key: value for changes in listed for key, value in changes.items()}


def sections():
    """All fields of a section at once; those that replace a derived number apart."""
    found = []
    for (name, stated), listed in groupby(
        sorted(of_sections(BASE), key=by_section), key=by_section
    ):
        changed = together(changes for _, changes in listed)
        found.append((f"{name or 'title'}{' stated' if stated else ''}", changed))
    return found


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """FMUs, each made once: ``loop`` and ``parts``, which are plant and controller."""

    def export(what, law, scenario, version):
        out = tmp_path_factory.mktemp("fields")
        return export_fmu(what, law=law, scenario=scenario, fmi=version, out=out, arrays=False)[0]

    @cache
    def loop(scenario, law, version):
        path = export("closed-loop", law, scenario, version)
        return Fmu(path, Path(extract(str(path), str(tmp_path_factory.mktemp("loop")))), version)

    @cache
    def parts(scenario, law):
        return {
            "plant": export("plant", law, scenario, 2),
            "controller": export(law, law, scenario, 3),
        }

    return SimpleNamespace(loop=loop, parts=parts)


@cache
def code_of(scenario, law, version):
    """All C of the closed loop but start values and the token made of them."""
    found = sources_of(closed_loop_model(settle(scenario, law)), version, arrays=False)
    files = {name: text for name, text in found.files.items() if name != "model.c"}
    return {**files, "model.h": files["model.h"].replace(found.token, "")}


def flown(fmu, scenario, law, run):
    """Columns by element name and violations of a closed loop whose parameters are all set."""
    names = [name for signal in run.signals[1:] for name in signal.elements]
    numbers = (v for v in closed_loop_model(settle(scenario, law)).variables if v.parameter)
    loop, period = fmu.new(), scenario.clock.control
    assert loop.put({v.name: v.start for v in numbers if not v.integer}) == OK, fmu.messages[-1:]
    loop.begin(stop=scenario.clock.duration)
    rows = [loop.get(*names)]
    for k in range(scenario.clock.samples):
        assert loop.step(k * period, period) == OK
        rows.append(loop.get(*names))
    columns = zip(names, zip(*rows, strict=True), strict=True)
    found = {n: list(column[:-1] if n in STATE else column[1:]) for n, column in columns}
    speeds = loop.get("max_abs_v[1]", "max_abs_v[2]")
    loop.free()
    return found, speeds


def assert_loop_is(run, fmu, scenario, law):
    found, speeds = flown(fmu, scenario, law, run)
    assert tuple(speeds) == run.monitor.max_abs_v
    assert not [name for name in found if not np.array_equal(found[name], run[name])]


def assert_cosimulation_is(run, other):
    different = [
        name
        for name in run.columns
        if name != "e" and not np.array_equal(run[name], other[name], equal_nan=True)
    ]
    assert different == []
    assert np.abs(run["e"] - other["e"]).max() < 1e-12  # NumPy's sine, not the kernel's
    assert (run.monitor, run.settings, run.outcome) == (
        other.monitor,
        other.settings,
        other.outcome,
    )


def assert_alike(files, changes, base=BASE, law=LAW, version=3):
    scenario = override(base, changes)
    run = simulate(scenario, law)
    numbers_only = code_of(scenario, law, version) == code_of(base, law, version)
    loop = files.loop(base if numbers_only else scenario, law, version)
    assert_loop_is(run, loop, scenario, law)
    same = model_of(law, law, scenario).graph == model_of(law, law, base).graph
    assert_cosimulation_is(
        run, cosimulate(scenario, law, **(files.parts(base, law) if same else {}))
    )


SECTIONS = sections()


@pytest.mark.parametrize(
    "section, version",
    [
        ("actuator", 2),
        ("changes[1]", 3),
        ("clock", 2),
        ("disturbance", 3),
        ("guard", 2),
        ("robot", 3),
        ("sensor", 2),
    ],
)
@pytest.mark.slow
def test_a_section_acts_alike(files, section, version):
    assert_alike(files, dict(SECTIONS)[section], version=version)


@pytest.mark.slow
@pytest.mark.parametrize("law", ["pid", "nn", "kanayama"])
def test_gains_act_alike(files, law):
    assert_alike(files, together(changes for _, changes in of_gains(law)), LOOSER, law)


@pytest.mark.slow
def test_each_field_of_the_walk_matters():
    """The walk would not see a lost field that changes nothing in the native loop."""
    assert idle(BASE, LAW, of_sections(BASE)) == WITHOUT_EFFECT
    assert set().union(*(idle(LOOSER, law, of_gains(law)) for law in LAWS)) == set()


def idle(base, law, walk):
    """Fields without effect on the native run of ``base``."""
    run = simulate(base, law)
    others = ((key, simulate(override(base, changes), law)) for key, changes in walk)
    return {
        key
        for key, other in others
        if all(np.array_equal(run[n], other[n], equal_nan=True) for n in run.columns)
    }
