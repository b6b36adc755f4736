"""Planners in space: interface, registry, and one module for each algorithm."""

from ppaas.planners.base3d import PlanRequest3D, Pose3D, VolumePlanner, create, planner_names

__all__ = ["PlanRequest3D", "Pose3D", "VolumePlanner", "create", "planner_names"]
