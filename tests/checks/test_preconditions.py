"""Warnings about the reference and the kinematic gains."""

import pytest


def line(speed):
    return {"reference.kind": "line", "reference.speed": speed}


@pytest.mark.parametrize(
    "law, changes, said",
    [
        ("mb", line(0.8), ""),
        ("mb", line(1.2), "may not drive that fast"),
        ("mb", {"reference.radius": 0.1, "reference.rate": 1.4}, "1.4 rad/s"),
        ("mb", {"reference.radius": 0.1, "reference.rate": 1.4}, "wind up"),
        ("nn", {"reference.kind": "stop-and-go"}, "stands still"),
        ("nn", line(0), "stands still"),
        ("nn", {"reference.rate": -0.1}, "backwards"),
        ("mb", line(0.79), None),
        ("nn", line(1e-3), None),
        ("nn", line(0.05), None),
        ("mb", {"reference.kind": "circle"}, None),
        ("mb", {"reference.kind": "lemniscate"}, None),
    ],
)
def test_a_reference_that_no_theorem_covers_is_told(told, law, changes, said):
    found = [item.sentence for item in told(law, changes, key="reference")]

    assert len(found) == (said is not None)
    assert all(said in sentence for sentence in found)


def test_too_fast_reference_names_the_lag_that_it_ends_in(told):
    (warning,) = told("mb", scenario="fast-reference", key="reference")

    assert "reaches 0.9 m/s" in warning.sentence
    assert "about 1 m behind" in warning.sentence


def test_second_kinematic_gain_below_one(told):
    (warning,) = told("mb", {"gains.kinematics.k": (10, 0.5, 4)}, key="gains.kinematics.k")

    assert "k[2] = 0.5 is below 1" in warning.sentence
