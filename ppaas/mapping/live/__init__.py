"""Mapping while the robot drives: scans are tracked at once, and loops are closed beside them."""
