"""ROS 2: lifecycle nodes of bases; `python -m wmr_ctrl.ros2 filter`, `drive`."""
