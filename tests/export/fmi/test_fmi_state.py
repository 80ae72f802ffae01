"""States of an FMU: taken, restored, serialised, read elsewhere; damaged bytes are refused."""

import json
import sys
from itertools import product
from pathlib import Path

import pytest

from tests.commands import finished
from tests.export.fmi.raw import CS, ERROR, ME, OK

ROOT = Path(__file__).resolve().parents[3]
every_fmu = pytest.mark.parametrize(
    "what, version",
    [
        *product(("plant", "reference", "nn", "closed-loop"), (2, 3)),
        *(pytest.param("mb", version, marks=pytest.mark.slow) for version in (2, 3)),
    ],
)
ELSEWHERE = """
import json, sys
from pathlib import Path
from tests.export.fmi.raw import Fmu
path, folder, version, content = json.loads(sys.argv[1])
one = Fmu(Path(path), folder, version).new()
assert one.restore(bytes.fromhex(content)) == 0
assert one.step(0.3, 0.2) == 0
print("ALL", json.dumps([x.hex() for x in one.all()]))
"""


def advanced(fmu, first, count, instance=None):
    """An instance after ``count`` steps from step ``first`` on, with inputs that differ."""
    instance = instance or fmu.new().begin()
    for k in range(first, first + count):
        for name in {"tau_right", "v1"}.intersection(fmu.inputs):
            assert instance.put({name: 0.02 * (k % 7)}) == OK
        assert instance.step(0.01 * k, 0.01) == OK
    return instance


@every_fmu
def test_a_state_put_back_and_a_reset_give_the_same_continuation(raw, what, version):
    fmu, fresh = raw(what, version), raw(what, version).new()
    instance = advanced(fmu, 0, 30)
    kept = instance.bytes_of_state()
    straight = advanced(fmu, 30, 25, instance).all()
    for one in (instance, fmu.new()):
        assert one.restore(kept) == OK
        assert advanced(fmu, 30, 25, one).all() == straight
    assert instance.reset() == OK
    assert instance.all() == fresh.all()
    assert advanced(fmu, 0, 55, instance.begin()).all() == straight != fresh.begin().all()


@every_fmu
def test_a_state_brings_its_parameters_into_a_new_instance(raw, what, version):
    """The tables that the model reads its numbers from are rebuilt with the state."""
    fmu = raw(what, version)
    names = {"robot.m", "gains.nn.rho1[1]", "limits.v_u2[1]", "ref_rate"}
    for name in names.intersection(fmu.variables):
        changed, new = fmu.new(), fmu.new()
        assert changed.put({name: 1.05 * float(fmu.variables[name].start)}) == OK
        changed.begin()
        kept = advanced(fmu, 0, 10, changed).bytes_of_state()
        straight = advanced(fmu, 10, 10, changed).all()
        assert new.restore(kept) == OK
        assert advanced(fmu, 10, 10, new).all() == straight, name


@pytest.mark.parametrize(
    "what, version", [("nn", 2), ("nn", 3), ("closed-loop", 2), ("closed-loop", 3)]
)
@pytest.mark.slow_but("nn-3", "closed-loop-2")
def test_the_bytes_mean_the_same_in_another_process(raw, what, version):
    fmu = raw(what, version)
    instance = fmu.new().begin()
    assert instance.step(0.0, 0.3) == OK
    given = [str(fmu.path), str(fmu.folder), version, instance.bytes_of_state().hex()]
    done = finished([sys.executable, "-c", ELSEWHERE, json.dumps(given)], cwd=ROOT)
    assert instance.step(0.3, 0.2) == OK
    assert json.loads(done.stdout.rpartition("ALL ")[2]) == [x.hex() for x in instance.all()]


@pytest.mark.parametrize(
    "what, version", [("closed-loop", 3), ("plant", 2), ("reference", 3), ("nn", 2)]
)
@pytest.mark.slow_but("closed-loop-3")
def test_damaged_and_foreign_bytes_are_refused(raw, what, version):
    fmu = raw(what, version)
    instance = advanced(fmu, 0, 5)
    kept, before = instance.bytes_of_state(), instance.all()
    places = (0, 9, 17, 25, 33, 41, len(kept) // 2, len(kept) - 1)
    damaged = [kept[:k] + bytes([kept[k] ^ 0x10]) + kept[k + 1 :] for k in places]
    for wrong in (*damaged, kept[:-1], kept + b"\0", b"", b"\0" * len(kept)):
        assert instance.restore(wrong) == ERROR
    other = raw("reference" if what == "plant" else "plant", version).new().begin()
    assert instance.restore(other.bytes_of_state()) == ERROR
    assert instance.all() == before
    assert instance.step(0.05, 0.01) == OK


def test_a_state_of_the_other_interface_is_refused(raw):
    fmu = raw("plant", 2)
    assert fmu.new(ME).begin().restore(fmu.new(CS).begin().bytes_of_state()) == ERROR
