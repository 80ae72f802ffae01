"""Warnings about where the run starts."""

import pytest

OUTSIDE = "outside-start"
GUARDED = {"guard.enabled": True}
NOMINAL = "paper-simulation-nominal"
AXES = (
    "initial.velocity[1] = 1.3 m/s is outside limits.v_u1[1] = 1",
    "initial.velocity[2] = 2 rad/s is outside limits.v_u1[2] = 1.5",
)
FAR = ("|v1| = 7.17 m/s (limit 1) and |omega| = 3.02 rad/s (limit 1.5)",)


def at(v1, omega=0.0):
    return {"initial.velocity": (v1, omega)}


@pytest.mark.parametrize(
    "law, changes, scenario, said",
    [
        *((law, {}, OUTSIDE, AXES) for law in ("pid", "smc", "mb", "nn")),
        *(("mb", at(v1), NOMINAL, ("",)) for v1 in (-1.3, -1 + 5e-7, 1 - 5e-7, 1.0)),
        ("mb", at(0.9999999), NOMINAL, ("0.9999999 m/s is within limits.clip",)),
        ("mb", GUARDED, OUTSIDE, ("only the guard brings it back", "")),
        ("pid", at(1.0, 1.5), NOMINAL, ()),
        *(("mb", at(v1), NOMINAL, ()) for v1 in (0.0, 0.95, -0.99999)),
    ],
)
def test_a_start_at_or_beyond_the_limit_is_told_per_axis(told, law, changes, scenario, said):
    found = told(law, changes, scenario=scenario, key="initial.velocity")

    assert len(found) == len(said)
    assert all(words in item.sentence for words, item in zip(said, found, strict=True))


def test_start_exactly_at_the_limit_is_not_outside_it(told):
    """|v| <= v_u1 is what is promised, with equality."""
    (warning,) = told("mb", at(1.0, -1.0), key="initial.velocity")

    assert "outside" not in warning.sentence


@pytest.mark.parametrize(
    "law, changes, said",
    [
        ("pid", {}, FAR), ("smc", {}, FAR), ("mb", {}, ()), ("nn", {}, ()),
        ("pid", {"initial.pose": (0.0, 0.0, -1.57)}, ()), ("pid", GUARDED, ()),
    ],
)  # fmt: skip
def test_laws_that_ignore_the_limit_are_told_apart(told, law, changes, said):
    found = told(law, changes, key="law")

    assert len(found) == len(said)
    assert all(words in item.sentence for words, item in zip(said, found, strict=True))
