"""Global planners: the interface, the registry, and what all of them share; one package below for each family."""

from ppaas.planners.base import Planner, PlanRequest, PlanResult
from ppaas.planners.registry import create, planner_names

__all__ = ["PlanRequest", "PlanResult", "Planner", "create", "planner_names"]
