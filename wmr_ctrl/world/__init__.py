"""A law's surroundings: model, scenario file, references, sensors, disturbances, drives."""
