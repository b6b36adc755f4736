"""Local planners for a robot's body: sets its limits and radius, and its footprint if the planner uses one."""

from typing import Any

from ppaas import controllers
from ppaas.controllers.base import Controller
from ppaas.controllers.registry import CONTROLLERS
from ppaas.footprints import goes_around
from ppaas.parameters import FOOTPRINT
from ppaas.plugins import parameters_in_use, taken_by
from ppaas.robot_model.known_models import RobotModel


def controller_of(body: RobotModel, name: str, parameters: dict[str, Any]) -> Controller:
    """Return a local planner for a body, with those limits of the body that it takes; given parameters take precedence.

    A body whose outline does not go around its origin is a disc for the local planner.

    Raises
    ------
    NotFound
        There is no local planner of that name; the text lists those that exist.
    InvalidParameter
        A parameter is unknown or invalid.
    """
    limits = body.limits
    of_body = {
        "max_vel_x": limits.max_vel_x,
        "min_vel_x": limits.min_vel_x,
        "max_vel_theta": limits.max_vel_theta,
        "acc_lim_x": limits.acc_lim_x,
        "acc_lim_theta": limits.acc_lim_theta,
        "robot_radius": body.robot_radius,
    }
    merged = {**taken_by(CONTROLLERS.load(name), of_body), **parameters}
    controller = controllers.create(name, **merged)
    if goes_around(body.footprint) and FOOTPRINT not in parameters and FOOTPRINT in parameters_in_use(controller):
        return controllers.create(name, **merged, footprint=body.footprint)
    return controller
