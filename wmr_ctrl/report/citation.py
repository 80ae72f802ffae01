"""The paper that is rerun."""

from __future__ import annotations

CITATION = (
    "Z. Chen, Y. Liu, W. He, H. Qiao, and H. Ji, “Adaptive-Neural-Network-Based Trajectory "
    "Tracking Control for a Nonholonomic Wheeled Mobile Robot With Velocity Constraints,” "
    "IEEE Transactions on Industrial Electronics, vol. 68, no. 6, pp. 5057–5067, June 2021, "
    "doi:10.1109/TIE.2020.2989711."
)
