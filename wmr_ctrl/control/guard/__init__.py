"""The velocity guard: formula, numbers, delay, monitor, and the maps onto the wheels."""
