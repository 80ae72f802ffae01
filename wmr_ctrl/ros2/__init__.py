"""ROS 2: lifecycle nodes before a base that takes velocities; `python -m wmr_ctrl.ros2 filter`."""
