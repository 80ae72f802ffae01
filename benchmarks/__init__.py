"""What `wmr-ctrl bench` measures against: hand-written C, idiomatic NumPy, and how to time them.

The folder is a package of its own in a checkout (``benchmarks``) and travels inside the wheel as
``wmr_ctrl._benchmarks``; its modules import each other relatively, so both names work.
"""
