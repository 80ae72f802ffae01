"""YAML text as plain values; damaged, endless or ambiguous text is refused."""

import math
from typing import Any

from wmr_ctrl.core.errors import ScenarioError, show

from .values import MOST_NODES


def yaml_document(text: str, place: str) -> object:
    """Return the first document of YAML text; None where there is none."""
    return next(iter(yaml_documents(text, place)), None)


def yaml_documents(text: str, place: str) -> list[object]:
    """Return the documents of YAML text that are not empty.

    Repeated tables are merged. Raises ScenarioError, starting with ``place``, if it is not YAML,
    repeats another key, or has more than MOST_NODES values, aliases written out.
    """
    import yaml  # seldom needed

    try:
        loader = yaml.SafeLoader(text)
    except yaml.YAMLError as problem:
        raise _no_yaml(place, problem) from None
    documents, size = [], 0.0
    try:
        while loader.check_node():
            node = loader.get_node()
            size += _size(node, {}, place)
            if size > MOST_NODES:
                raise ScenarioError(
                    f"{place} has more than {MOST_NODES} values, aliases written out. Save it "
                    "without anchors and aliases, or without what is not needed."
                )
            documents.append(loader.construct_document(node))
    except RecursionError:
        raise ScenarioError(f"{place} is not usable YAML: it is nested too deeply.") from None
    except (yaml.YAMLError, ValueError, TypeError, OverflowError) as problem:
        if isinstance(problem, ScenarioError):
            raise
        raise _no_yaml(place, problem) from None
    finally:
        loader.dispose()
    return [document for document in documents if document is not None]


def _no_yaml(place: str, problem: Exception) -> ScenarioError:
    detail = show(" ".join(str(problem).splitlines()[:1]))
    return ScenarioError(f"{place} is not YAML ({detail}). Check its indentation and quotes.")


def _size(node: Any, known: dict[int, float], place: str) -> float:
    """Values in a node of YAML with every alias written out; infinite if it holds itself."""
    if id(node) not in known:
        known[id(node)] = math.inf
        if node.id == "mapping":
            node.value = _once(node.value, place)
        inner = node.value if isinstance(node.value, list) else []
        parts = (part for item in inner for part in (item if isinstance(item, tuple) else (item,)))
        known[id(node)] = 1 + sum(_size(part, known, place) for part in parts)
    return known[id(node)]


def _once(pairs: list[tuple[Any, Any]], place: str) -> list[tuple[Any, Any]]:
    """Pairs of nodes with unique keys; tables with the same name are merged, as ROS does."""
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
