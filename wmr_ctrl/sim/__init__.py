"""Simulation: the compiled loop behind ctypes, and the NumPy oracle.  No CasADi here."""
