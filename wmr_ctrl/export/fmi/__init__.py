"""FMUs of plant, laws, reference and closed loop: variable tables, packages, co-simulation, SSP."""
