"""Global planners: the interface, the registry, one algorithm a file."""

from ppaas.planners.base import Planner, PlanRequest, PlanResult
from ppaas.planners.registry import create, planner_names

__all__ = ["PlanRequest", "PlanResult", "Planner", "create", "planner_names"]
