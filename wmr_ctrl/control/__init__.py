"""From a measurement to a command: laws, velocity guard, command filter, and their wiring."""
