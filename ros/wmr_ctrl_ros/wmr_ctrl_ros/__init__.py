"""The ROS 2 nodes of wmr_ctrl, found where they are installed."""
