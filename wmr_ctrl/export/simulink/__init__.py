"""A law as a Simulink S-function, with a script that builds the loop."""

from .kit import export_simulink, kit_files

__all__ = ["export_simulink", "kit_files"]
