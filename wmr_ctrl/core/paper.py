"""The paper as data: its citation, and the times that it states."""

CITATION = (
    "Z. Chen, Y. Liu, W. He, H. Qiao, and H. Ji, “Adaptive-Neural-Network-Based Trajectory "
    "Tracking Control for a Nonholonomic Wheeled Mobile Robot With Velocity Constraints,” "
    "IEEE Transactions on Industrial Electronics, vol. 68, no. 6, pp. 5057–5067, June 2021, "
    "doi:10.1109/TIE.2020.2989711."
)
EVALUATIONS = 10_000
"""Evaluations of a law that were timed."""
PAPER_TIMES = {"pid": 0.4056, "smc": 2.0662, "mb": 0.3875, "nn": 1.4294}
"""Time that so many evaluations of each law took the authors [s]."""
