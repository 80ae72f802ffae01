"""Files for other tools: FMUs, SSP, Modelica, Simulink and the live page."""
