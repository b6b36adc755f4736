"""Planners for a robot's body: sets its footprint if the planner uses one."""

from typing import Any

from ppaas.clone.outline_planning import Outline, by_outline
from ppaas.parameters import FOOTPRINT
from ppaas.planners.base import Planner
from ppaas.planners.registry import PLANNERS
from ppaas.plugins import parameters_in_use
from ppaas.robot_model.known_models import RobotModel


def planner_of(body: RobotModel, name: str, parameters: dict[str, Any]) -> Planner:
    """Return a planner; if it uses a footprint, that is the body's unless the parameters contain another.

    For a body that is longer than wide, it also plans through passages in which the body cannot turn.

    Raises
    ------
    NotFound
        There is no planner of that name; the text lists those that exist.
    InvalidParameter
        A parameter is unknown or invalid.
    """
    planner = PLANNERS.create(name, parameters)
    if body.footprint and FOOTPRINT not in parameters and FOOTPRINT in parameters_in_use(planner):
        planner = PLANNERS.create(name, {**parameters, FOOTPRINT: body.footprint})
    if body.inner_radius is not None and FOOTPRINT not in parameters:
        planner = by_outline(planner, Outline(body.footprint, body.inner_radius))
    return planner
