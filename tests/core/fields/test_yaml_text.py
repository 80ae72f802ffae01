"""YAML as plain values."""

import pytest

from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.core.fields.yaml_text import yaml_document, yaml_documents

pytest.importorskip("yaml")


def test_documents_that_say_something_are_read_and_tables_joined():
    assert yaml_documents("a: 1\n---\n---\nb: [2, x]\n", "it") == [{"a": 1}, {"b": [2, "x"]}]
    assert yaml_document("", "it") is None
    assert yaml_document("a: {b: 1}\na: {c: 2}\n", "it") == {"a": {"b": 1, "c": 2}}


@pytest.mark.parametrize(
    "text, words",
    [
        ("a: 1\nb: 2\na: 3\n", 'it, line 3: "a" is stated twice'),
        ("a: [1", "it is not YAML ("),
        ("a: &a [*a]", "it: the anchor in line 1 has an alias"),
        ("[" * 5000, "nested too deeply"),
        ("a: \x01", "it is not YAML ("),
    ],
)
def test_what_is_damaged_endless_or_ambiguous_is_refused(text, words):
    with pytest.raises(ScenarioError) as caught:
        yaml_document(text, "it")
    assert words in str(caught.value)
