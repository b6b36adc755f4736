"""Plug-ins of a clone: its planners, controller and recovery behaviours, configured for its body."""

from typing import Any

from ppaas import controllers, recoveries
from ppaas.clone.node_parameters import NodeParameters
from ppaas.clone.outline_planning import planner_of
from ppaas.controllers.base import Controller
from ppaas.controllers.registry import CONTROLLERS
from ppaas.footprints import goes_around
from ppaas.navigation.parameters import MoveBaseParameters, recovery_behaviors, recovery_defaults
from ppaas.parameters import FOOTPRINT
from ppaas.planners.base import Planner
from ppaas.planners.registry import PLANNERS
from ppaas.plugins import parameters_in_use, taken_by
from ppaas.recoveries.base import Recovery
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


DEFAULT_PLANNER = "dijkstra"
DEFAULT_CONTROLLER = "dwa"


def planners_of(
    driving: MoveBaseParameters, given: NodeParameters, body: RobotModel
) -> tuple[Planner, dict[str, Planner]]:
    """Return the robot's own planner, and by name the path services' planners.

    The services have another instance of the robot's planner, since both may plan at the same time.
    """
    base = PLANNERS.own_name(driving.base_global_planner)
    own = given.take(*PLANNERS.spellings(base))
    own_planner, service_planners = (
        planner_of(body, driving.base_global_planner, own),
        {base: planner_of(body, base, own)},
    )
    given.note(base, own_planner)
    for name in PLANNERS.names():
        spellings = PLANNERS.spellings(name)
        if given.has(*spellings):
            service_planners[name] = planner_of(body, name, given.take(*spellings))
            given.note(name, service_planners[name])
    return own_planner, service_planners


def controller_for(driving: MoveBaseParameters, given: NodeParameters, body: RobotModel) -> Controller:
    """Return the robot's controller."""
    names = CONTROLLERS.spellings(driving.base_local_planner)
    controller = controller_of(body, driving.base_local_planner, given.take(*names))
    given.note(names[0], controller)
    return controller


def recoveries_of(driving: MoveBaseParameters, given: NodeParameters) -> list[tuple[str, Recovery]]:
    """Return the recovery behaviours in the order in which they are tried, each with its name."""
    behaviors, own = recovery_behaviors(driving), recovery_defaults(driving)
    types = {each.name: each.type for each in behaviors}
    made = {name: recoveries.create(kind, **(own.get(name, {}) | given.take(name))) for name, kind in types.items()}
    for name, recovery in made.items():
        given.note(name, recovery)
    return [(each.name, made[each.name]) for each in behaviors]
