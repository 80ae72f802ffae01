"""What a law meets: the model, the scenario file, references, sensors, disturbances, drives."""
