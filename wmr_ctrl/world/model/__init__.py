"""The model in CasADi SX: Systems, kinematics, dynamics, tracking errors and references."""
