"""Global planners: the interface, the registry and shared code. Each family of planners has a package below."""

from ppaas.planners.base import Planner, PlanRequest, PlanResult
from ppaas.planners.registry import create, planner_names

__all__ = ["PlanRequest", "PlanResult", "Planner", "create", "planner_names"]
