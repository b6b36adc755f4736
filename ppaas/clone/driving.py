"""Ways of driving, with their parameters: as far as traffic grants, along paths by itself, by hand, into docks."""

from collections.abc import Callable
from functools import partial
from typing import Any

from ppaas.clone.node_parameters import NodeParameters
from ppaas.clone.plugins import controller_of
from ppaas.controllers.command_guard import CommandGuard
from ppaas.controllers.drive_parameters import body_of
from ppaas.costmap.map_layers import MapLayers
from ppaas.docking.approach import BodyOutline
from ppaas.docking.parameters import DockingParameters
from ppaas.docking.targets import DockTargets
from ppaas.errors import InvalidParameter
from ppaas.navigation.teleoperation import TeleopParameters
from ppaas.nodes.base import Context, Node
from ppaas.nodes.docking_server.node import DockingServerNode
from ppaas.nodes.follow_path.node import DEFAULTS, FollowPathParameters, PathFollowingNode, RobotPathFollower
from ppaas.nodes.frames import FrameNames
from ppaas.nodes.move_base.node import MoveBaseNode
from ppaas.nodes.move_base.teleop import Teleop
from ppaas.parameters import Parameters, check_numbers
from ppaas.plugins import parameters_in_use
from ppaas.robot_model.known_models import RobotModel
from ppaas.traffic.taking_part import TRAFFIC

STAYS_ON_PATH = "pure_pursuit"
"""Local planner for granted ways: unlike others it does not drive around what is in the way."""

ALONG_WAY = {
    "xy_goal_tolerance": 0.08, "lookahead_dist": 0.3, "min_lookahead_dist": 0.2,
    "use_cost_regulated_linear_velocity_scaling": False, "approach_velocity_scaling_dist": 0.4,
}  # fmt: skip
"""Its parameters: it keeps near to its path, beside others that do so too."""


class DrivingInTraffic(Parameters, frozen=True):
    """Parameters of a robot that takes part in the traffic of its map.

    Parameters
    ----------
    yaw_goal_tolerance : float
        Largest difference to the direction of a goal [rad].
    reaction : float
        Time from a command until the base obeys, for the distance in which the robot stops [s].
    """

    yaw_goal_tolerance: float = 0.1
    reaction: float = 0.2

    def __post_init__(self) -> None:
        """Check the ranges."""
        check_numbers(self, positive=("yaw_goal_tolerance",))


def in_traffic(
    given: NodeParameters, usual: Callable[..., MoveBaseNode], body: RobotModel, robot: str, *, maps: bool
) -> Callable[..., MoveBaseNode]:
    """Return the maker of Move Base for a robot that takes part in traffic, and for other robots the usual one.

    Parameters
    ----------
    given : NodeParameters
    usual : callable
        Maker of Move Base for other robots.
    body : RobotModel
    robot : str
        Robot ID.
    maps : bool
        Whether the robot makes a map.

    Raises
    ------
    InvalidParameter
        A parameter is unknown or invalid, or a robot in traffic makes a map or follows paths itself.
    """
    if not given.has(TRAFFIC):
        return usual
    if maps:
        raise InvalidParameter(f"a robot with parameters for {TRAFFIC!r} needs a map: it does not make one")
    if usual is not MoveBaseNode:
        raise InvalidParameter(f"a robot that follows paths itself has no parameters for {TRAFFIC!r}")
    # Imported only here, so that other containers do not load what only robots in traffic use.
    from ppaas.nodes.granted_move_base.node import GrantedMoveBaseNode, GrantFollower  # noqa: PLC0415
    from ppaas.nodes.granted_move_base.traffic_link import RobotTrafficFacts, TrafficLink  # noqa: PLC0415

    parameters = given.read(DrivingInTraffic, TRAFFIC)
    speed, limits = body.limits.max_vel_x, body.limits
    braking = speed * speed / (2.0 * limits.acc_lim_x) + speed * parameters.reaction
    along = controller_of(body, STAYS_ON_PATH, ALONG_WAY | {"yaw_goal_tolerance": parameters.yaw_goal_tolerance})

    def make(context: Context, **options: Any) -> MoveBaseNode:
        own = options.pop("controller")
        tolerance = float(parameters_in_use(own).get("xy_goal_tolerance", 0.0))
        link = TrafficLink(context, RobotTrafficFacts(robot, body.robot_radius, speed, braking, tolerance))
        follower = GrantFollower(link, own, along)
        return GrantedMoveBaseNode(context, link=link, controller=follower, **options)

    return make


FOLLOW_PATH = RobotPathFollower.name
"""Name of the parameters; a robot that has them, even empty ones, follows paths itself."""


def move_base_defaults(given: NodeParameters) -> dict[str, Any]:
    """Return the parameters of Move Base that differ for a robot that follows paths itself."""
    return dict(DEFAULTS) if given.has(FOLLOW_PATH) else {}


def move_base_kind(given: NodeParameters, usual: type[MoveBaseNode], *, maps: bool) -> Callable[..., MoveBaseNode]:
    """Return the maker of Move Base for a robot that follows paths itself, and for other robots the usual class.

    Parameters
    ----------
    given : NodeParameters
    usual : type of MoveBaseNode
    maps : bool
        Whether the robot makes a map.

    Raises
    ------
    InvalidParameter
        A parameter is unknown or invalid, or a robot that follows paths makes a map.
    """
    if not given.has(FOLLOW_PATH):
        return usual
    if maps:
        raise InvalidParameter(f"a robot with parameters for {FOLLOW_PATH!r} needs a map: it does not make one")
    parameters = given.read(FollowPathParameters, FOLLOW_PATH)

    def make(context: Context, **options: Any) -> MoveBaseNode:
        """Make the node; the local planner of the options is not used."""
        return PathFollowingNode(context, **options | {"controller": RobotPathFollower(context, parameters)})

    return make


TELEOP = "teleop"
"""Name of the parameters of driving by hand."""


def by_hand(given: NodeParameters, body: RobotModel) -> Callable[..., Teleop]:
    """Return the maker of the part of Move Base by which operators drive a robot by hand.

    Raises
    ------
    InvalidParameter
        A parameter is unknown or invalid.
    """
    parameters = given.read(TeleopParameters, TELEOP)
    guard = CommandGuard(body_of(body.footprint, body.robot_radius), body.limits, parameters.reaction_time)
    return partial(Teleop, parameters=parameters, guard=guard, base=body.limits)


def docking(
    given: NodeParameters, body: RobotModel, names: FrameNames, layers: MapLayers | None
) -> dict[str, Callable[[Context], Node]]:
    """Return the maker of the node that docks a robot, by its name; ``layers`` is None for a robot that makes its map.

    Raises
    ------
    NotFound, InvalidParameter
        A parameter is unknown or invalid, or names an unknown detector.
    """
    parameters = given.read(DockingParameters, DockingServerNode.name)
    outline = outline_of(body)
    targets = DockTargets(parameters, outline)
    options: dict[str, Any] = {"braking": body.limits.acc_lim_x, "granted": TRAFFIC in given.given}

    def make(context: Context) -> Node:
        return DockingServerNode(context, parameters, targets, outline, layers=layers, names=names, **options)

    return {DockingServerNode.name: make}


def outline_of(body: RobotModel) -> BodyOutline:
    """Return the extent of a robot."""
    if not body.footprint:
        return BodyOutline(body.robot_radius, body.robot_radius, body.robot_radius)
    x, y = zip(*body.footprint, strict=True)
    return BodyOutline(max(x), -min(x), max(*y, -min(y)))
