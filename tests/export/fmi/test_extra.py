"""The plain C in a law's FMU is the FMU's law, called as its description says and no other way."""

import subprocess
import xml.etree.ElementTree as ET
import zipfile
from pathlib import Path

import pytest

from tests.export.fmi.raw import OK, Fmu
from tests.export.fmi.test_targets import tool
from wmr_ctrl.export.fmi.extra import FOLDER, INTERFACE

STEPS = 20
PERIOD = 0.01


def given(k, names):
    """Inputs of sample k, within the velocity limits."""
    return {name: 0.01 * ((7 * i + 3 * k) % 11 - 5) for i, name in enumerate(names)}


def expressions(interface, tag, **having):
    """Name to C expression of the elements that have these attributes."""
    listed = (item.attrib for item in interface.iter(tag))
    return {i["name"]: i["expression"] for i in listed if having.items() <= i.items()}


def program(interface):
    """A C program of the description's expressions alone: it prints the outputs of each sample."""
    functions = {
        item.attrib["name"]: item.attrib["expression"] for item in interface.iter("Function")
    }
    places = {
        kind: expressions(interface, "Variable", causality=kind)
        for kind in ("input", "output", "parameter")
    }
    lines = [f'#include "{item.attrib["name"]}"' for item in interface.iter("HeaderFile")]
    lines += ["#include <stdio.h>", "int main(void) {"]
    lines += [
        f"{item.attrib['type']} {item.attrib['name']};" for item in interface.iter("StructVariable")
    ]
    lines += [f"{functions['setDefaults']};", f"{functions['startup']};"]
    lines += [f"{places['parameter']['robot.r']} *= 1.25;"]
    for k in range(STEPS):
        values = given(k, list(places["input"]))
        lines += [f"{places['input'][name]} = {value.hex()};" for name, value in values.items()]
        lines += [f"if ({functions['doStep']}) return 1;"]
        lines += [
            f'printf("%a %a\\n", {places["output"]["tau_right"]}, {places["output"]["tau_left"]});'
        ]
    return "\n".join([*lines, "return 0; }", ""])


@pytest.mark.parametrize(
    "law, scenario", [("prox", "paper-simulation"), ("kanayama", "robot-10ms")]
)
@pytest.mark.slow
def test_called_as_described_it_has_the_bits_of_the_fmu(exported, tmp_path, law, scenario):
    path = exported(law, 2, scenario=scenario)
    with zipfile.ZipFile(path) as archive:
        archive.extractall(tmp_path)
    folder, interface = tmp_path / FOLDER, ET.parse(tmp_path / INTERFACE).getroot()
    (folder / "main.c").write_text(program(interface), "utf-8")
    units = [item.attrib["name"] for item in interface.iter("SourceFile")]
    command = [tool("gcc"), "-std=c99", "-O1", "-ffp-contract=off", "-o", "main", "main.c", *units]
    subprocess.run([*command, "-lm"], cwd=folder, check=True)
    printed = subprocess.run([folder / "main"], check=True, capture_output=True, text=True).stdout

    fmu = Fmu(path, Path(tmp_path), 2)
    inputs = list(expressions(interface, "Variable", causality="input"))
    one, found = fmu.new(), []
    assert one.put({"robot.r": 1.25 * float(fmu.variables["robot.r"].start)}) == OK
    one.begin()
    for k in range(STEPS):
        assert one.put(given(k, inputs)) == OK
        assert one.step(k * PERIOD, PERIOD) == OK
        found.append([value.hex() for value in one.get("tau_right", "tau_left")])
    one.free()
    wanted = [[float.fromhex(x).hex() for x in line.split()] for line in printed.splitlines()]
    assert found == wanted


def test_its_variables_are_the_fmus_and_the_description_says_where(raw):
    fmu = raw("nn", 3)
    with zipfile.ZipFile(fmu.path) as archive:
        interface = ET.fromstring(archive.read(INTERFACE).decode())
        files = {Path(name).name for name in archive.namelist() if name.startswith(FOLDER)}
    needed = {
        item.attrib["name"]
        for kind in ("SourceFile", "HeaderFile")
        for item in interface.iter(kind)
    }

    assert needed <= files
    assert fmu.description.description.endswith(INTERFACE)
    for item in interface.iter("Variable"):
        variable = fmu.variables[item.attrib["name"]]
        assert (variable.causality, variable.unit) == (
            item.attrib["causality"],
            item.attrib["unit"],
        )


@pytest.mark.parametrize("what", ["plant", "guard", "closed-loop"])
def test_what_is_no_law_says_nothing_of_it(raw, what):
    fmu = raw(what, 2)
    with zipfile.ZipFile(fmu.path) as archive:
        assert not [name for name in archive.namelist() if name.startswith(FOLDER)]
    assert INTERFACE not in fmu.description.description
