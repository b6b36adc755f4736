"""Planners for a body: those that mind a footprint are given that of the robot."""

from typing import Any

from ppaas import planners
from ppaas.planners.base import Planner
from ppaas.plugins import parameters_in_use
from ppaas.robot_model.known_models import RobotModel

FOOTPRINT = "footprint"


def planner_of(body: RobotModel, name: str, parameters: dict[str, Any]) -> Planner:
    """Make a planner; one that minds a footprint has that of the body, unless the parameters give it another.

    Raises
    ------
    NotFound
        No planner of that name; the text lists those there are.
    InvalidParameter
        It takes no such parameter, or none of that type.
    """
    planner = planners.create(name, **parameters)
    if body.footprint and FOOTPRINT not in parameters and FOOTPRINT in parameters_in_use(planner):
        return planners.create(name, **parameters, footprint=body.footprint)
    return planner
