"""How to cite the paper."""

from __future__ import annotations

CITATION = """\
@article{chen2021,
  author  = {Chen, Ziyu and Liu, Yang and He, Wei and Qiao, Hong and Ji, Haibo},
  title   = {Adaptive-Neural-Network-Based Trajectory Tracking Control for a Nonholonomic
             Wheeled Mobile Robot With Velocity Constraints},
  journal = {IEEE Transactions on Industrial Electronics},
  volume  = {68},
  number  = {6},
  pages   = {5057--5067},
  year    = {2021},
  doi     = {10.1109/TIE.2020.2989711},
}
"""
"""BibTeX entry."""
