"""Local planners for a body: its limits and its radius, and to those that mind a footprint its outline."""

from typing import Any

from ppaas import controllers
from ppaas.clone.body_planners import FOOTPRINT
from ppaas.controllers.base import Controller
from ppaas.plugins import parameters_in_use
from ppaas.robot_model.known_models import RobotModel


def controller_of(body: RobotModel, name: str, parameters: dict[str, Any]) -> Controller:
    """Make a local planner for a body; what the parameters say goes first.

    Raises
    ------
    NotFound
        No local planner of that name; the text lists those there are.
    InvalidParameter
        It takes no such parameter, or none of that type.
    """
    limits = body.limits
    told = {
        "max_vel_x": limits.max_vel_x,
        "min_vel_x": limits.min_vel_x,
        "max_vel_theta": limits.max_vel_theta,
        "acc_lim_x": limits.acc_lim_x,
        "acc_lim_theta": limits.acc_lim_theta,
        "robot_radius": body.robot_radius,
        **parameters,
    }
    controller = controllers.create(name, **told)
    if body.footprint and FOOTPRINT not in parameters and FOOTPRINT in parameters_in_use(controller):
        return controllers.create(name, **told, footprint=body.footprint)
    return controller
