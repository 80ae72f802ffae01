"""Icons of the Modelica package's classes."""

from __future__ import annotations

_BLACK, _WHITE, _GREY, _BLUE = "{0,0,0}", "{255,255,255}", "{95,95,95}", "{0,0,127}"
_LIGHT, _PALE = "{215,225,240}", "{245,245,245}"


def _filled(kind: str, extent: str, line: str, fill: str, more: str = "") -> str:
    solid = f"lineColor={line}, fillColor={fill}, fillPattern=FillPattern.Solid"
    return f"{kind}(extent={extent}, {solid}{more})"


def _text(extent: str, text: str, colour: str) -> str:
    return f'Text(extent={extent}, textString="{text}", textColor={colour})'


_WHOLE = "{{-100,100},{100,-100}}"
_FRAME = _filled("Rectangle", _WHOLE, _BLUE, _WHITE)
_NAME = _text("{{-95,-62},{95,-92}}", "%name", "{0,0,255}")
_ROBOT = (
    _filled("Ellipse", "{{-45,45},{45,-45}}", _BLACK, _LIGHT),
    _filled("Rectangle", "{{-60,22},{-45,-22}}", _BLACK, _GREY),
    _filled("Rectangle", "{{45,22},{60,-22}}", _BLACK, _GREY),
    "Line(points={{0,0},{0,38}}, thickness=0.5, arrow={Arrow.None,Arrow.Filled})",
)
_PATH = (
    f"Ellipse(extent={{{{-45,55}},{{45,-35}}}}, lineColor={_BLACK}, pattern=LinePattern.Dash)",
    _filled("Ellipse", "{{38,17},{52,3}}", _BLACK, _BLACK),
)
_GUSTS = ("Line(points={{-80,10},{-55,10},{-45,40},{-30,-25},{-10,50},{20,25},{45,-5},{80,10}})",)
_PACKAGE = _filled("Rectangle", _WHOLE, _GREY, _PALE, ", radius=20")


def _icon(*drawn: str) -> str:
    return f"Icon(graphics={{\n{_joined(drawn)}}})"


def _joined(drawn: tuple[str, ...]) -> str:
    return ",\n".join(f"        {item}" for item in drawn)


def label(text: str) -> str:
    """The icon of a block with a text in its middle, beside what it inherits."""
    return _icon(_text("{{-90,40},{90,-30}}", text, _BLACK))


def connector(fill: str) -> str:
    """A triangle in an icon, with the connector's name in a diagram."""
    points = "points={{-100,100},{100,0},{-100,-100},{-100,100}}"
    solid = f"lineColor={_BLUE}, fillColor={fill}, fillPattern=FillPattern.Solid"
    triangle = f"Polygon({points}, {solid})"
    named = _joined((triangle, _text("{{-100,-120},{100,-220}}", "%name", _BLUE)))
    return f"{_icon(triangle)}, Diagram(graphics={{\n{named}}})"


ICONS = {
    "input": connector(_BLUE),
    "output": connector(_WHITE),
    "reference": _icon(_FRAME, *_PATH, _NAME),
    "controller": _icon(_FRAME, _NAME),
    "plant": _icon(_FRAME, *_ROBOT, _NAME),
    "disturbance": _icon(_FRAME, *_GUSTS, _NAME),
    "package": _icon(_PACKAGE),
    "whole": _icon(_PACKAGE, *_ROBOT),
}
"""Annotations of connectors, parts and packages."""
