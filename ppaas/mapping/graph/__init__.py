"""Pose graph: nodes, edges with information, and the solver for the most likely poses."""
