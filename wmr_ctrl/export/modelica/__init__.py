"""The Systems as a Modelica package: one file that compiles as it is."""

from .package import FILE, export_modelica, modelica_package

__all__ = ["FILE", "export_modelica", "modelica_package"]
