"""The Systems as a Modelica package in one file."""

from .package import FILE, export_modelica, modelica_package

__all__ = ["FILE", "export_modelica", "modelica_package"]
