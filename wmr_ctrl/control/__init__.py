"""Control of the robot: laws, velocity guard, command filter, and their wiring."""
