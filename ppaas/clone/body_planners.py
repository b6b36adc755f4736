"""Planners for a robot's body: sets its footprint if the planner uses one."""

from typing import Any

from ppaas import planners
from ppaas.planners.base import Planner
from ppaas.plugins import parameters_in_use
from ppaas.robot_model.known_models import RobotModel

FOOTPRINT = "footprint"


def planner_of(body: RobotModel, name: str, parameters: dict[str, Any]) -> Planner:
    """Return a planner; if it uses a footprint, that is the body's unless the parameters contain another.

    Raises
    ------
    NotFound
        There is no planner of that name; the text lists those that exist.
    InvalidParameter
        A parameter is unknown or invalid.
    """
    planner = planners.create(name, **parameters)
    if body.footprint and FOOTPRINT not in parameters and FOOTPRINT in parameters_in_use(planner):
        return planners.create(name, **parameters, footprint=body.footprint)
    return planner
