"""The templates of ``fmu/templates``: loops and names only; everything is decided before."""

from __future__ import annotations

from functools import cache

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from wmr_ctrl.codegen.resources import fmu_dir


def render(name: str, **values: object) -> str:
    """Text of the template ``name``; markup in XML and HTML is escaped."""
    return (
        _environment(name.endswith((".xml", ".html", ".ssd", ".ssv")))
        .get_template(f"{name}.jinja")
        .render(**values)
    )


@cache
def _environment(escape: bool) -> Environment:
    return Environment(
        loader=FileSystemLoader(fmu_dir() / "templates"),
        autoescape=escape,
        undefined=StrictUndefined,
        trim_blocks=escape,
        lstrip_blocks=escape,
        keep_trailing_newline=True,
    )
