"""Simulation: the compiled loop behind ctypes, and the same graphs without a compiler."""
