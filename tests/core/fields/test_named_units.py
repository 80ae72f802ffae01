"""Numbers that are written with their unit: correctly rounded, of the right kind, in SI inside."""

import pickle
from dataclasses import replace
from decimal import Decimal, localcontext
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.tables import cases
from wmr_ctrl.control.setup import check_scenario
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.core.fields.named_units import KINDS, Stated, stated, unit_of
from wmr_ctrl.core.fields.section import quantities
from wmr_ctrl.world.scenario import load_scenario, loads_scenario, override, to_toml
from wmr_ctrl.world.scenario.scenario import sections

NOMINAL = load_scenario("paper-simulation-nominal")
TURN = Decimal("6.28318530717958647692528676655900576839433879875021164194988918461563281257242")
SIZES = {
    "mm": "0.001", "cm": "0.01", "in": "0.0254", "ms": "0.001", "min": "60", "h": "3600",
    "g": "0.001", "lb": "0.45359237", "mN m": "0.001", "kg cm2": "0.0001", "%": "0.01",
    "mm/s2": "0.001", "kgf": "9.80665", "mph": "0.44704",
}  # fmt: skip
QUOTIENTS = {"km/h": (Decimal(5), 18), "deg": (TURN, 360), "deg/s": (TURN, 360), "rpm": (TURN, 60)}
ALIKE = ("9 kg m2", "9 kg.m^2", "9 kg·m²", "9kg m2", "9.0 kg*m2", "90000 kg cm2", " 9 kg m2 ")


@given(st.decimals(allow_nan=False, allow_infinity=False, places=6, min_value=-1e9, max_value=1e9))
def test_conversions_are_correctly_rounded(number):
    with localcontext(prec=110):
        wanted = {unit: number * Decimal(size) for unit, size in SIZES.items()}
        wanted |= {unit: number * up / down for unit, (up, down) in QUOTIENTS.items()}

    assert {unit: stated(f"{number} {unit}") for unit in wanted} == {
        unit: float(Fraction(value)) for unit, value in wanted.items()
    }


OTHERS = ["101", "0x10", "5 foo", "m", "5 m m/q", "1.2.3 m", "inf s", ""]
DIGITS = ["1e99999999 m", "0e-99999999 m", f"{'1' * 5000} m"]


@pytest.mark.parametrize("text", [*OTHERS, *DIGITS])
def test_other_texts_stay_texts(text):
    assert stated(text) == text


def test_spellings_are_one_number():
    assert {stated(text) for text in ALIKE} == {9.0}
    assert stated("90°/s") == stated("90 deg/s")


def test_every_unit_of_a_field_can_be_written():
    units = {
        u.strip() for c in sections().values() for _, q in quantities(c) for u in q.unit.split(",")
    }

    assert {unit for unit in units - {""} if not isinstance(stated(f"2 {unit}"), Stated)} == set()
    for unit, (_, ways) in KINDS.items():
        for way in ways.split(", "):
            assert not stated(f"1 {way}").refused(unit), way
            assert unit_of(unit).factor == 1


def test_equal_values_are_equal_scenarios(tmp_path):
    text = (
        'extends = "paper-simulation-nominal"\ntitle = "5 m"\nframes = "rep103"\n'
        '[robot]\nm = "60000 g"\n[initial]\npose = ["-50 cm", 0, "30 deg"]\n[limits]\n'
        'v_u1 = ["3.6 km/h", "90 deg/s"]\n[gains.kanayama]\nk = ["2 1/s", 3, 4]\n'
        '[clock]\nduration = "0.5 min"\n[[changes]]\nt = "10 s"\nm = "70 kg"\n'
    )
    (tmp_path / "a.toml").write_text(text)
    one = load_scenario(tmp_path / "a.toml")
    keys = {"robot.m": 60.0, "initial.pose": [-0.5, 0, stated("30 deg") + 0.0]}
    keys |= {"limits.v_u1": "1.0, 90 deg/s", "gains.kanayama.k": [2, 3, 4], "clock.duration": 30}
    keys |= {"changes": [{"t": 10, "m": 70}], "title": "5 m", "frames": "rep103"}
    two = override(load_scenario("paper-simulation-nominal"), keys)

    assert replace(two, name=one.name) == one
    assert loads_scenario(to_toml(one), "a") == one
    assert pickle.loads(pickle.dumps(one)) == one
    assert hash(one.gains) == hash(two.gains)
    check_scenario(one)


WRONG = """
    robot.m | 60 cm | must be a mass (in g, kg, lb), not a length
    clock.control | 20 Hz | must be a time (in us, ms, s, min, h), not a rate
    limits.v_u1 | 2 m/s, 3 Hz | an angular velocity (in rad/s, deg/s, rpm), not a rate
    robot.mu | 2 m | must be a plain number (in 1, %), not a length
    robot.r | 10 foo | or one with its unit (mm, cm, m, km, in, ft)
    gains.mb.rho | 2 m, 3 | gains.mb.rho[1]
    changes[1].t | 3 kg | must be a time
    initial.pose | 0, 0, 2 m | must be an angle (in rad, deg, rev), not a length
    filter.kind | 5 m | is not known
"""


@pytest.mark.parametrize("key, value, said", cases(WRONG))
@pytest.mark.parametrize("frames", ["paper", "rep103"])
def test_another_kind_is_refused_with_the_kinds(key, value, said, frames):
    base = load_scenario("paper-simulation", {"frames": frames})

    with pytest.raises(ScenarioError) as caught:
        check_scenario(override(base, {key: value}))

    assert str(caught.value).startswith(key.partition("[")[0])
    assert said in str(caught.value)


def test_a_text_is_told_the_unit_of_its_element():
    with pytest.raises(ScenarioError, match=r"v_u1\[2\] = .*rad/s, deg/s, rpm"):
        override(NOMINAL, {"limits.v_u1": [1.0, "fast"]})
