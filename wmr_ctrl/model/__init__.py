"""The model: Signals, Systems, kinematics, dynamics, tracking errors and references in CasADi SX."""
