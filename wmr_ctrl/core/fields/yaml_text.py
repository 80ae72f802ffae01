"""YAML text as plain values; damaged, endless or ambiguous text is refused."""

from typing import Any

from wmr_ctrl.core.errors import ScenarioError, show


def yaml_document(text: str, place: str) -> object:
    """Return the first document of YAML text; None if there is none."""
    return next(iter(yaml_documents(text, place)), None)


def yaml_documents(text: str, place: str) -> list[object]:
    """Return the documents of YAML text that are not empty.

    Repeated tables are merged, as ROS does. Raises ScenarioError, starting with ``place``, if it is
    not YAML, repeats another key, or has an alias, which ROS does not read either.
    """
    import yaml  # seldom needed

    documents = []
    try:
        for node in yaml.compose_all(text, yaml.SafeLoader):
            _check(node, set(), place)
            documents.append(yaml.SafeLoader("").construct_document(node))
    except RecursionError:
        raise ScenarioError(f"{place} is not usable YAML: it is nested too deeply.") from None
    except (yaml.YAMLError, ValueError, TypeError, OverflowError) as problem:
        if isinstance(problem, ScenarioError):
            raise
        raise _no_yaml(place, problem) from None
    return [document for document in documents if document is not None]


def _no_yaml(place: str, problem: Exception) -> ScenarioError:
    detail = show(" ".join(str(problem).splitlines()[:1]))
    return ScenarioError(f"{place} is not YAML ({detail}). Check its indentation and quotes.")


def _check(node: Any, seen: set[int], place: str) -> None:
    """Merge repeated tables in a node of YAML; raise ScenarioError if an alias refers back to
    it.
    """
    if id(node) in seen:
        line = node.start_mark.line + 1
        raise ScenarioError(f"{place}: the anchor in line {line} has an alias. Write it out.")
    seen.add(id(node))
    if node.id == "mapping":
        node.value = _once(node.value, place)
    for item in node.value if isinstance(node.value, list) else ():
        for part in item if isinstance(item, tuple) else (item,):
            _check(part, seen, place)


def _once(pairs: list[tuple[Any, Any]], place: str) -> list[tuple[Any, Any]]:
    """Pairs of nodes with unique keys; tables with the same name are merged."""
    kept: dict[object, tuple[Any, Any]] = {}
    for key, value in pairs:
        name = key.value if isinstance(key.value, str) and key.value != "<<" else id(key)
        if name not in kept:
            kept[name] = (key, value)
        elif value.id == kept[name][1].id == "mapping":
            kept[name][1].value = [*kept[name][1].value, *value.value]
        else:
            line = key.start_mark.line + 1
            raise ScenarioError(f"{place}, line {line}: {show(name)} is stated twice. Keep one.")
    return list(kept.values())
