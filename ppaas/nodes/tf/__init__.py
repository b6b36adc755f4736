"""Nodes for transforms: ``robot_state_publisher`` and ``tf2_web_republisher``."""
