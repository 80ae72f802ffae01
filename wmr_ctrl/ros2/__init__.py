"""Lifecycle nodes of ROS 2 that filter commands or drive a base."""
