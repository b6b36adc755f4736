"""Robots of a group: their reports in the world frame, deviations, offsets, clocks and trust."""
