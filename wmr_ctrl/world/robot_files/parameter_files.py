"""Parameter files of ROS: the nodes in them, with parameters by dotted name."""

from collections.abc import Iterator, Mapping

Flat = dict[str, object]
PARAMETERS = "ros__parameters"


def nodes(document: object, path: tuple[str, ...] = ()) -> Iterator[tuple[str, Flat]]:
    """Name and parameters of each node of a ROS 2 file, or of each controller of a ROS 1 file."""
    if not isinstance(document, Mapping):
        return
    inner = document.get(PARAMETERS)
    if isinstance(inner, Mapping):
        yield "/".join(path), dict(_flat(inner))
    elif path and "type" in document:
        yield "/".join(path), dict(_flat(document))
    for name, part in document.items():
        if name != PARAMETERS:
            own = () if name == "/**" else (str(name).strip("/"),)
            yield from nodes(part, (*path, *own))


def _flat(params: Mapping[object, object], prefix: str = "") -> Iterator[tuple[str, object]]:
    """Parameters by dotted name; elements of lists by name[1] ... as well."""
    for name, value in params.items():
        key = f"{prefix}{name}"
        if isinstance(value, Mapping):
            yield from _flat(value, f"{key}.")
        else:
            yield key, value
            if isinstance(value, list):
                yield from ((f"{key}[{i}]", item) for i, item in enumerate(value, start=1))
