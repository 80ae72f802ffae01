"""What the standards ask of a model description beyond their schemas."""

import pytest
from fmpy import read_model_description

from tests.export.fmi.test_model_description import every_fmu

CONTINUOUS = {"input", "output", "local"}


def described(exported, what, version):
    return read_model_description(str(exported(what, version)))


def elements(variable):
    return (
        [float(part) for part in str(variable.start).split()] if variable.start is not None else []
    )


@every_fmu
def test_start_values_keep_their_ranges(exported, what, version):
    for v in described(exported, what, version).modelVariables:
        if v.min is not None:
            assert all(float(v.min) <= start <= float(v.max) for start in elements(v)), v.name


@every_fmu
def test_unknowns_are_listed_once_in_order_with_dependencies_that_are_known(
    exported, what, version
):
    description = described(exported, what, version)
    place = {v.name: i for i, v in enumerate(description.modelVariables)}
    for group in (description.outputs, description.derivatives, description.initialUnknowns):
        order = [place[u.variable.name] for u in group]
        assert order == sorted(set(order))
    for unknown in (*description.outputs, *description.derivatives):
        for v in unknown.dependencies or []:
            state = v.variability == "continuous" and v.initial == "exact"
            assert v.causality in ("input", "independent") or state, (unknown.variable.name, v.name)
    for unknown in description.initialUnknowns:
        for v in unknown.dependencies or []:
            assert v.causality in ("input", "independent") or v.initial == "exact"
        assert set(unknown.dependenciesKind or []) <= {"dependent", "constant"}


@every_fmu
def test_states_and_their_rates_belong_together(exported, what, version):
    description = described(exported, what, version)
    for unknown in description.derivatives:
        state = unknown.variable.derivative
        assert unknown.variable.name == f"der({state.name})"
        assert state.variability == unknown.variable.variability == "continuous"
        assert state.causality in CONTINUOUS
    assert len(description.derivatives) == (5 if what == "plant" else 0)


@every_fmu
def test_references_are_unique_and_kinds_have_legal_variability(exported, what, version):
    variables = described(exported, what, version).modelVariables
    assert len({v.valueReference for v in variables}) == len(variables)
    for v in variables:
        if v.causality == "parameter":
            assert v.variability in ("fixed", "tunable")
            assert v.start is not None
        if v.initial == "calculated":
            assert v.start is None
        if v.type in ("Integer", "Int64"):
            assert v.variability != "continuous"


@pytest.mark.parametrize("version", [2, 3])
def test_experiment_is_the_scenarios(exported, version):
    experiment = described(exported, "plant", version).defaultExperiment
    assert float(experiment.stopTime) == 80.0
    assert float(experiment.stepSize) == 0.01
