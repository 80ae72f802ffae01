"""The plain C in a law's FMU equals the FMU's law, called exactly as its description says."""

import xml.etree.ElementTree as ET

import pytest

from tests.commands import finished
from tests.compilers import where
from tests.export.fmi.raw import OK
from wmr_ctrl.export.fmi.extra import FOLDER, INTERFACE

STEPS = 20
PERIOD = 0.01


def given(k, names):
    """Inputs of sample k, within the velocity limits."""
    return {name: 0.01 * ((7 * i + 3 * k) % 11 - 5) for i, name in enumerate(names)}


def attributes(interface, tag, key="expression"):
    """Name of each element to one of its attributes: most to its C expression."""
    return {item.attrib["name"]: item.get(key) for item in interface.iter(tag)}


def program(interface, inputs):
    """A C program of the description's expressions alone: it prints the outputs of each sample."""
    functions, variables = attributes(interface, "Function"), attributes(interface, "Variable")
    lines = [f'#include "{name}"' for name in attributes(interface, "HeaderFile")]
    lines += ["#include <stdio.h>", "int main(void) {"]
    lines += [
        f"{kind} {name};" for name, kind in attributes(interface, "StructVariable", "type").items()
    ]
    lines += [f"{functions['setDefaults']};", f"{functions['startup']};"]
    lines += [f"{variables['robot.r']} *= 1.25;"]
    for k in range(STEPS):
        lines += [f"{variables[n]} = {value.hex()};" for n, value in given(k, inputs).items()]
        lines += [f"if ({functions['doStep']}) return 1;"]
        lines += [f'printf("%a %a\\n", {variables["tau_right"]}, {variables["tau_left"]});']
    return "\n".join([*lines, "return 0; }", ""])


@pytest.mark.parametrize(
    "law, scenario", [("prox", "paper-simulation"), ("kanayama", "robot-10ms")]
)
@pytest.mark.slow
def test_called_as_described_it_has_the_bits_of_the_fmu(raw, law, scenario):
    fmu = raw(law, 2, scenario)
    folder, interface = fmu.folder / FOLDER, ET.parse(fmu.folder / INTERFACE).getroot()
    inputs = [
        n for n, cause in attributes(interface, "Variable", "causality").items() if cause == "input"
    ]
    (folder / "main.c").write_text(program(interface, inputs), "utf-8")
    units = ["main.c", *attributes(interface, "SourceFile")]
    finished([where("gcc"), "-std=c99", "-O1", "-ffp-contract=off", *units, "-lm"], cwd=folder)
    printed = finished([folder / "a.out"]).stdout
    one, found = fmu.new(), []
    assert one.put({"robot.r": 1.25 * float(fmu.variables["robot.r"].start)}) == OK
    one.begin()
    for k in range(STEPS):
        assert (one.put(given(k, inputs)), one.step(k * PERIOD, PERIOD)) == (OK, OK)
        found.append(one.get("tau_right", "tau_left"))
    assert found == [[float.fromhex(x) for x in line.split()] for line in printed.splitlines()]


def test_its_variables_are_the_fmus_and_the_description_says_where(raw):
    fmu = raw("nn", 3)
    interface = ET.parse(fmu.folder / INTERFACE).getroot()
    files = {path.name for path in (fmu.folder / FOLDER).rglob("*")}

    for kind in ("SourceFile", "HeaderFile"):
        assert attributes(interface, kind).keys() <= files
    assert fmu.description.description.endswith(INTERFACE)
    for item in interface.iter("Variable"):
        variable = fmu.variables[item.attrib["name"]]
        for told in ("causality", "unit"):
            assert getattr(variable, told) == item.attrib[told]


@pytest.mark.parametrize("what", ["plant", "guard", "closed-loop"])
def test_what_is_no_law_says_nothing_of_it(raw, what):
    fmu = raw(what, 2)
    assert not (fmu.folder / FOLDER).exists()
    assert INTERFACE not in fmu.description.description
