"""Planners in space: the interface, the registry, one algorithm a file."""

from ppaas.planners.volume.base import PlanRequest3D, Pose3D, VolumePlanner
from ppaas.planners.volume.registry import create, planner_names

__all__ = ["PlanRequest3D", "Pose3D", "VolumePlanner", "create", "planner_names"]
