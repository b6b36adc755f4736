"""Which nodes a robot's clone is made of, and which a container that only plans."""

from collections.abc import Callable, Collection, Mapping
from typing import Any, TypeVar

from ppaas import recoveries
from ppaas.clone.body_controllers import controller_of
from ppaas.clone.body_planners import planner_of
from ppaas.clone.robot_body import COSTMAP, VOXEL_LAYER, FootprintParameters, VoxelLayerParameters, robot_body
from ppaas.controllers.base import Controller
from ppaas.controllers.registry import CONTROLLERS
from ppaas.costmap.inflation_layer import COST_SCALING_FACTOR, INFLATION_RADIUS
from ppaas.costmap.local_costmap import LocalCostmap
from ppaas.costmap.map_layers import MapLayers
from ppaas.costmap.obstacle_layer import RAYTRACE_RANGE
from ppaas.costmap.obstacle_memory import ObstacleMemory
from ppaas.errors import InvalidParameter, Unavailable
from ppaas.geometry import Pose2D
from ppaas.localization.parameters import AmclParameters
from ppaas.navigation.parameters import MoveBaseParameters
from ppaas.navigation.passive_safety import GivingWay
from ppaas.navigation.recovery_sequence import recovery_behaviors, recovery_defaults
from ppaas.nodes.amcl.node import AmclNode
from ppaas.nodes.base import Context, Node
from ppaas.nodes.graph import Graph
from ppaas.nodes.map_server.costmap_filters import (
    KEEPOUT_FILTER,
    SPEED_FILTER,
    KeepoutFilterParameters,
    SpeedFilterParameters,
)
from ppaas.nodes.map_server.node import MapServerNode
from ppaas.nodes.move_base.node import MoveBaseNode
from ppaas.nodes.move_base.people import SeenPeople, SocialLayerParameters
from ppaas.nodes.move_base.speed_limits import SpeedFilter
from ppaas.nodes.move_base.surroundings import Surroundings
from ppaas.nodes.parameter_server.node import ParameterServerNode
from ppaas.nodes.planner_server.node import PlannerServerNode
from ppaas.nodes.tf.republisher import TfRepublisherNode
from ppaas.nodes.tf.state_publisher import StatePublisherNode, StatePublisherParameters
from ppaas.nodes.waypoint_follower.node import WaypointFollowerNode, WaypointFollowerParameters
from ppaas.parameters import Parameters, read_parameters
from ppaas.perception.tracking import MovingThings
from ppaas.planners.base import Planner
from ppaas.planners.registry import PLANNERS
from ppaas.plans.reuse.processor import Keeping, ReuseParameters
from ppaas.plugins import parameters_in_use
from ppaas.recoveries.base import Recovery
from ppaas.robot_model.description import RobotDescription
from ppaas.robot_model.known_models import PLANNING_MODEL, RobotModel, robot_model
from ppaas.thread_budget import Threads, one_thread

P = TypeVar("P", bound=Parameters)


class LocalCostmapParameters(Parameters, frozen=True):
    """Parameters of the local costmap, with the names of costmap_2d [m, 1/m].

    ``footprint_padding`` is added to the robot's radius around what the laser sees: a cell is marked by its middle,
    so what is seen may be half a cell nearer than it is marked. ``obstacle_range`` is 2.5 m in costmap_2d, less than
    ``raytrace_range``; here it is more, because a beam that clears but may not mark wears an obstacle away.
    """

    width: float = 6.0
    height: float = 6.0
    footprint_padding: float = 0.03
    inflation_radius: float = INFLATION_RADIUS
    cost_scaling_factor: float = COST_SCALING_FACTOR
    obstacle_range: float = 3.2
    raytrace_range: float = RAYTRACE_RANGE


DEFAULT_PLANNER = "dijkstra"
DEFAULT_CONTROLLER = "dwa"
DEPTH_CAMERA = "depthimage_to_laserscan"
"""The node of a clone whose robot has a depth camera, which its parameters say."""


def build_clone(
    graph: Graph,
    layers: MapLayers,
    *,
    model: str,
    urdf: RobotDescription | None = None,
    initial_pose: tuple[float, float, float],
    base_global_planner: str = DEFAULT_PLANNER,
    base_local_planner: str = DEFAULT_CONTROLLER,
    parameters: Mapping[str, Any] | None = None,
    threads: Threads = one_thread,
    keeping: Keeping | None = None,
    only: Collection[str] | None = None,
) -> None:
    """Add the nodes of a robot's clone to a graph: map server, state publisher, localization, Move Base, waypoints.

    Parameters
    ----------
    graph : Graph
        Of the home.
    layers : MapLayers
        The map, inflated for the robot's radius.
    model : str
        Of the robot.
    urdf : RobotDescription, optional
        What its URDF tells.
    initial_pose : tuple of float
        x, y [m], yaw [rad] in the map.
    base_global_planner, base_local_planner : str
        Plug-ins by name or ROS alias; what ``parameters`` says of ``move_base`` goes first.
    parameters : dict, optional
        Parameters of each node by its name, ``{"move_base": {...}, "amcl": {...}}``, and of planners, the
        controller, each recovery behaviour, the ``local_costmap``, the ``social_layer``, the ``voxel_layer``, the
        ``keepout_filter`` and the ``speed_filter`` by theirs. Planners other than the one that drives have theirs for
        requests that name them.
    threads : callable
        Returns the most threads that kernels may use now.
    keeping : Keeping, optional
        What is known of plans that were made before.
    only : collection of str, optional
        Names of nodes: those that are to be added, where the others live elsewhere or are here already.

    Raises
    ------
    NotFound
        No such model, planner, controller or recovery behaviour; the text lists those there are.
    InvalidParameter
        A parameter or the name of a node is unknown, or a value cannot be taken.
    Unavailable
        The layers lack a mask that the parameters want.
    """
    given = _Given(parameters or {})
    body = _body(given, robot_body(model, urdf, parameters))
    driving = _driving(given, base_global_planner, base_local_planner)
    amcl = given.read(AmclParameters, "amcl")
    state = given.read(StatePublisherParameters, "robot_state_publisher")
    move_base = _move_base(given, driving, body, layers, threads=threads, keeping=keeping or Keeping())
    touring = given.read(WaypointFollowerParameters, "waypoint_follower")
    camera = _camera(given)
    given.refuse_rest()
    makers: dict[str, Callable[[Context], Node]] = {
        MapServerNode.name: lambda context: MapServerNode(context, layers),
        StatePublisherNode.name: lambda context: StatePublisherNode(context, body, state),
        AmclNode.name: lambda context: AmclNode(context, layers, Pose2D(*initial_pose), amcl, threads),
        MoveBaseNode.name: move_base,
        WaypointFollowerNode.name: lambda context: WaypointFollowerNode(context, touring),
        ParameterServerNode.name: lambda context: ParameterServerNode(context, given.in_use),
        TfRepublisherNode.name: TfRepublisherNode,
        **camera,
    }
    for name in makers if only is None else only:
        graph.add(makers[name])


def _move_base(
    given: "_Given",
    driving: MoveBaseParameters,
    body: RobotModel,
    layers: MapLayers,
    *,
    threads: Threads,
    keeping: Keeping,
) -> Callable[[Context], MoveBaseNode]:
    (planner, path_planners), controller = _planners(driving, given, body), _controller(driving, given, body)
    recovering = _recoveries(driving, given)
    local = given.read(LocalCostmapParameters, "local_costmap")
    social = given.read(SocialLayerParameters, "social_layer")
    speed_filter = _filters(given, layers)

    def move_base(context: Context) -> MoveBaseNode:
        surroundings = _surroundings(layers, body, local, social, driving.transform_tolerance)
        processor = keeping.processor(layers.costmap, body.robot_radius, _reuse(driving))
        return MoveBaseNode(
            context,
            layers=layers, surroundings=surroundings, planner=planner, path_planners=path_planners,
            controller=controller, recoveries=recovering, parameters=driving, threads=threads,
            processor=processor, giving_way=GivingWay(body.robot_radius, body.limits.acc_lim_x),
            speed_filter=speed_filter,
        )  # fmt: skip

    return move_base


def _filters(given: "_Given", layers: MapLayers) -> SpeedFilter | None:
    """See to it that the masks are there that are wanted; that to keep out by is in the costs already."""
    keepout = given.read(KeepoutFilterParameters, KEEPOUT_FILTER)
    speed = given.read(SpeedFilterParameters, SPEED_FILTER)
    masks = ((KEEPOUT_FILTER, keepout.wanted, layers.keepout), (SPEED_FILTER, speed.wanted, layers.speed))
    for name, wanted, mask in masks:
        if wanted and mask is None:
            raise Unavailable(f"{name}: the mask {wanted!r} is not here; let the robot connect again")
    return SpeedFilter(layers.speed, speed) if speed.wanted and layers.speed is not None else None


def _camera(given: "_Given") -> dict[str, Callable[[Context], Node]]:
    """Return who makes scans of depth images, if there are parameters for it: most robots have a laser."""
    if not given.has(DEPTH_CAMERA):
        return {}
    # Its kernels are not for every container.
    from ppaas.nodes.depthimage_to_laserscan.node import DepthImageToLaserScanNode  # noqa: PLC0415
    from ppaas.perception.depth_scan import DepthScanParameters  # noqa: PLC0415

    parameters = given.read(DepthScanParameters, DEPTH_CAMERA)
    return {DEPTH_CAMERA: lambda context: DepthImageToLaserScanNode(context, parameters)}


def _body(given: "_Given", body: RobotModel) -> RobotModel:
    """Tell of the body where parameters are told of."""
    given.read(FootprintParameters, COSTMAP, {"robot_radius": body.robot_radius, "footprint": body.footprint})
    given.read(VoxelLayerParameters, VOXEL_LAYER, {"max_obstacle_height": body.height})
    return body


def _driving(given: "_Given", planner: str, controller: str) -> MoveBaseParameters:
    """What the robot's file says of its planners is the default; what it says of Move Base itself goes first."""
    base = {"base_global_planner": planner, "base_local_planner": controller}
    return given.read(MoveBaseParameters, "move_base", base)


def _reuse(driving: MoveBaseParameters) -> ReuseParameters:
    return ReuseParameters(driving.reuse_tolerance, driving.reuse_bound)


def build_planning(
    graph: Graph,
    layers: MapLayers,
    *,
    threads: Threads = one_thread,
    base_global_planner: str = DEFAULT_PLANNER,
    keeping: Keeping | None = None,
) -> None:
    """Add the nodes of a container that only plans, for a robot of `PLANNING_MODEL`: map server and planner server."""
    processor = (keeping or Keeping()).processor(layers.costmap, robot_model(PLANNING_MODEL).robot_radius)

    def planner_server(context: Context) -> PlannerServerNode:
        return PlannerServerNode(context, layers.costmap, base_global_planner, threads, processor=processor)

    graph.add(lambda context: MapServerNode(context, layers))
    graph.add(planner_server)


def _planners(driving: MoveBaseParameters, given: "_Given", body: RobotModel) -> tuple[Planner, dict[str, Planner]]:
    """Return one to drive by, and by name those for who asks for plans: two of one name may be at work at a time."""
    base = PLANNERS.own_name(driving.base_global_planner)
    own = given.take(*PLANNERS.spellings(base))
    drives, asked = planner_of(body, driving.base_global_planner, own), {base: planner_of(body, base, own)}
    given.note(base, drives)
    for name in PLANNERS.names():
        spellings = PLANNERS.spellings(name)
        if given.has(*spellings):
            asked[name] = planner_of(body, name, given.take(*spellings))
            given.note(name, asked[name])
    return drives, asked


def _controller(driving: MoveBaseParameters, given: "_Given", body: RobotModel) -> Controller:
    names = CONTROLLERS.spellings(driving.base_local_planner)
    controller = controller_of(body, driving.base_local_planner, given.take(*names))
    given.note(names[0], controller)
    return controller


def _recoveries(driving: MoveBaseParameters, given: "_Given") -> list[tuple[str, Recovery]]:
    behaviors, own = recovery_behaviors(driving), recovery_defaults(driving)
    types = {each.name: each.type for each in behaviors}
    made = {name: recoveries.create(kind, **(own.get(name, {}) | given.take(name))) for name, kind in types.items()}
    for name, recovery in made.items():
        given.note(name, recovery)
    return [(each.name, made[each.name]) for each in behaviors]


class _Given:
    """Parameters by the name of whom they are for; what nobody takes is refused.

    Attributes
    ----------
    in_use : dict of dict
        What came of it, defaults included, by the same names.
    """

    def __init__(self, parameters: Mapping[str, Any]) -> None:
        self.in_use: dict[str, dict[str, Any]] = {}
        self._rest = dict(parameters)
        self._asked: list[str] = []

    def read(self, cls: type[P], node: str, defaults: Mapping[str, Any] | None = None) -> P:
        """Return the parameters of a node."""
        parameters = read_parameters(cls, node, {**(defaults or {}), **self.take(node)})
        self.note(node, parameters)
        return parameters

    def note(self, name: str, of: object) -> None:
        """Take note of the parameters that a node or plug-in uses."""
        self.in_use[name] = parameters_in_use(of)

    def has(self, *names: str) -> bool:
        """Tell whether there are parameters of one that is known by these names."""
        return not self._rest.keys().isdisjoint(names)

    def take(self, *names: str) -> dict[str, Any]:
        """Return the parameters of one that is known by these names."""
        self._asked.append(names[0])
        merged: dict[str, Any] = {}
        for name in names:
            merged |= self._table(name)
        return merged

    def _table(self, name: str) -> dict[str, Any]:
        table = self._rest.pop(name, {})
        if not isinstance(table, dict):
            raise InvalidParameter(f"parameters of {name!r} must be an object of names and values, not {table!r}")
        return table

    def refuse_rest(self) -> None:
        """Refuse what nobody took."""
        if self._rest:
            raise InvalidParameter(
                f"parameters for unknown node {sorted(self._rest)[0]!r}; known: {', '.join(sorted(self._asked))}"
            )


def _surroundings(
    layers: MapLayers,
    body: RobotModel,
    parameters: LocalCostmapParameters,
    social: SocialLayerParameters,
    tolerance: float,
) -> Surroundings:
    radius = body.robot_radius + parameters.footprint_padding
    window = LocalCostmap(
        layers,
        width=parameters.width,
        height=parameters.height,
        robot_radius=radius,
        inflation_radius=parameters.inflation_radius,
        cost_scaling_factor=parameters.cost_scaling_factor,
        obstacle_range=parameters.obstacle_range,
        raytrace_range=parameters.raytrace_range,
        social=social.proxemics(),
    )
    memory = ObstacleMemory(
        layers,
        robot_radius=radius,
        inflation_radius=parameters.inflation_radius,
        cost_scaling_factor=parameters.cost_scaling_factor,
    )
    return Surroundings(
        window, memory, body.robot_radius,
        people=SeenPeople(social), moving=MovingThings(layers), tolerance=tolerance,
    )  # fmt: skip
