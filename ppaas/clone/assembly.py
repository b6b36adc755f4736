"""Assembly of a robot's clone: creates its nodes from a map, a robot model and parameters."""

from collections.abc import Callable, Collection, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import msgspec

from ppaas.clock import epoch
from ppaas.clone.driving import by_hand, docking, in_traffic, move_base_defaults, move_base_kind
from ppaas.clone.localization import Localization, on_map, while_mapping
from ppaas.clone.node_parameters import NodeParameters
from ppaas.clone.optional_nodes import exploring, octomap_makers, people_makers
from ppaas.clone.plugins import DEFAULT_CONTROLLER, DEFAULT_PLANNER, controller_for, planners_of, recoveries_of
from ppaas.clone.robot_body import COSTMAP, VOXEL_LAYER, VoxelLayerParameters, costmap_parameters, robot_body
from ppaas.clone.surroundings import LocalCostmapParameters, surroundings_of
from ppaas.costmap.build_layers import build_layers, without_unknown
from ppaas.costmap.costmap import Costmap
from ppaas.costmap.global_parameters import CostParameters, GlobalCostmapParameters, StaticLayerParameters
from ppaas.costmap.map_layers import MapLayers, unchanged
from ppaas.errors import Unavailable
from ppaas.maps.grid import GridMap
from ppaas.navigation.parameters import MoveBaseParameters
from ppaas.navigation.passive_safety import PassiveSafety
from ppaas.nodes.base import Context, Node
from ppaas.nodes.frames import FrameNames
from ppaas.nodes.graph import Graph
from ppaas.nodes.map_server.costmap_filters import (
    KEEPOUT_FILTER,
    SPEED_FILTER,
    KeepoutFilterParameters,
    SpeedFilterParameters,
    check_no_masks,
)
from ppaas.nodes.move_base.costmap_topics import CostmapTopics
from ppaas.nodes.move_base.node import MoveBaseNode, Processors
from ppaas.nodes.move_base.people import SocialLayerParameters
from ppaas.nodes.move_base.speed_limits import LimitsByPlace, SpeedFilter, ZoneSpeeds
from ppaas.nodes.parameter_server.node import ParameterServerNode
from ppaas.nodes.tf.republisher import TfRepublisherNode
from ppaas.nodes.tf.state_publisher import StatePublisherNode, StatePublisherParameters
from ppaas.nodes.tf.urdf_text import UrdfText
from ppaas.nodes.waypoint_follower.node import WaypointFollowerNode, WaypointFollowerParameters
from ppaas.parameters import FOOTPRINT
from ppaas.plans.reuse.processor import PlanProcessor, ReuseParameters
from ppaas.plans.reuse.setup import ReuseSetup
from ppaas.plugins import parameters_in_use
from ppaas.robot_model.description import RobotDescription
from ppaas.robot_model.known_models import RobotModel
from ppaas.thread_budget import Threads, one_thread

DEPTH_CAMERA = "depthimage_to_laserscan"
"""Node of robots with a depth camera; it is created only if the robot has parameters for it."""

LASER_PROC = "laser_proc"
"""Node of robots whose laser sends several echoes; it is created only if the robot has parameters for it."""

STATIC_LAYER = "static_layer"
"""Name of the parameters of the layer that is the map."""


def build_clone(
    graph: Graph,
    layers: MapLayers | None,
    *,
    model: str,
    urdf: RobotDescription | None = None,
    urdf_text: UrdfText | None = None,
    initial_pose: tuple[float, float, float],
    base_global_planner: str = DEFAULT_PLANNER,
    base_local_planner: str = DEFAULT_CONTROLLER,
    parameters: Mapping[str, Any] | None = None,
    threads: Threads = one_thread,
    reuse: ReuseSetup | None = None,
    only: Collection[str] | None = None,
    posegraph: Callable[[str], bytes | memoryview] | None = None,
    robot: str = "robot",
) -> dict[str, dict[str, Any]]:
    """Add the nodes of a robot's clone to a graph: map server, localization, state publisher, Move Base, waypoints.

    A robot that makes a new map has ``grid_slam`` in place of the map server and ``amcl``, and ``explore``.
    With a depth camera it also has ``octomap_server``, as a robot with parameters for that node has.
    A robot has the nodes that see and follow people (`ppaas.clone.optional_nodes`) if it has parameters for them.
    A robot with parameters for ``follow_path`` follows paths itself; one with parameters for ``traffic`` drives as far
    as the traffic of its map grants.

    Parameters
    ----------
    graph : Graph
        Graph of the executor.
    layers : MapLayers or None
        The map, inflated for the robot's radius; None for a robot that makes a new map.
    model : str
        Name of the robot model.
    urdf : RobotDescription, optional
        Description from the robot's URDF.
    urdf_text : UrdfText, optional
        The URDF itself, for clients that request it.
    initial_pose : tuple of float
        x, y [m], yaw [rad] in the map frame. Without effect on a new map, which has the odometry's frame.
    base_global_planner, base_local_planner : str
        Plug-ins by name or ROS alias; those in the parameters of ``move_base`` take precedence.
    parameters : dict, optional
        Parameters of each node by its name, ``{"move_base": {...}, "amcl": {...}}``, and likewise of planners, the
        controller, each recovery behaviour, ``local_costmap``, ``static_layer``, ``social_layer``, ``voxel_layer``,
        ``keepout_filter`` and ``speed_filter``. Parameters of planners other than the robot's own apply to requests
        that name them.
    threads : callable
        Returns the largest number of threads that kernels may use now.
    reuse : ReuseSetup, optional
        Access to stored plans and measured times.
    only : collection of str, optional
        Names of the nodes to add; all by default.
    posegraph : callable, optional
        Returns the file of the pose graph of the published map that a new map continues.
    robot : str
        Robot ID, for the frames of the people that it sees.

    Returns
    -------
    dict of dict
        All parameters in use, with their defaults, by the names of nodes and plug-ins.

    Raises
    ------
    NotFound
        There is no such model, planner, controller or recovery behaviour; the text lists those that exist.
    InvalidParameter
        A parameter or the name of a node is unknown, or a value is invalid; or a robot that makes a new map has masks.
    Unavailable
        The layers lack a mask that the parameters require.
    """
    given = NodeParameters(parameters or {})
    body, costs = _body(given, model, urdf, parameters), costmap_parameters(parameters or {}).costs
    driving = _driving(given, base_global_planner, base_local_planner)
    located = _located(given, layers, initial_pose, threads, posegraph)
    state = given.read(StatePublisherParameters, "robot_state_publisher")
    base_maker = partial(_move_base, costs=costs, threads=threads, reuse=reuse or ReuseSetup(), maps=layers is None)
    move_base = base_maker(given, driving, body, located, robot=robot)
    touring = given.read(WaypointFollowerParameters, "waypoint_follower")
    optional = _optional(given, body, costs, located.names, threads, layers=layers, robot=robot)
    given.refuse_rest()
    makers: dict[str, Callable[[Context], Node]] = {
        **located.makers,
        StatePublisherNode.name: lambda context: StatePublisherNode(context, body, state, located.names, urdf_text),
        MoveBaseNode.name: move_base,
        WaypointFollowerNode.name: lambda context: _follower_kind(layers is None)(context, touring),
        ParameterServerNode.name: lambda context: ParameterServerNode(context, given.in_use, urdf_text),
        TfRepublisherNode.name: TfRepublisherNode,
        **optional,
    }
    for name in makers if only is None else only:
        graph.add(makers[name])
    return given.in_use


def _located(
    given: NodeParameters,
    layers: MapLayers | None,
    initial_pose: tuple[float, float, float],
    threads: Threads,
    posegraph: Callable[[str], bytes | memoryview] | None,
) -> Localization:
    """Return localization on a map, or the mapping localization of a robot that makes one, which has no masks."""
    if layers is not None:
        return on_map(given, layers, initial_pose, threads)
    check_no_masks(given.given)
    return while_mapping(given, posegraph)


def _move_base(
    given: NodeParameters,
    driving: MoveBaseParameters,
    body: RobotModel,
    located: Localization,
    *,
    costs: CostParameters,
    threads: Threads,
    reuse: ReuseSetup,
    maps: bool,
    robot: str,
) -> Callable[[Context], MoveBaseNode]:
    """Return the maker of Move Base; with ``maps`` its map comes from topics, after these layers."""
    layers, controller = located.layers, controller_for(driving, given, body)
    if not parameters_in_use(controller).get(FOOTPRINT):
        body = replace(body, inner_radius=None)  # it drives a disc, which must not be led through narrow passages
    (planner, path_planners), recovering = planners_of(driving, given, body), recoveries_of(driving, given)
    local = given.read(LocalCostmapParameters, "local_costmap")
    social, limits_by_place = given.read(SocialLayerParameters, "social_layer"), _limits_of(given, body, layers)
    tracked = given.read(StaticLayerParameters, STATIC_LAYER).track_unknown_space
    adapt = unchanged if tracked else partial(without_unknown, robot_radius=body.robot_radius, costs=costs)
    build = partial(_built, threads, body.robot_radius, costs) if maps else None
    teleop = by_hand(given, body)
    kind = in_traffic(given, move_base_kind(given, _kind(maps), maps=maps), body, robot, maps=maps)

    def move_base(context: Context) -> MoveBaseNode:
        surroundings = surroundings_of(
            adapt(layers), body, local, social, costs=costs, tolerance=driving.transform_tolerance,
            names=located.names, by_robot=located.by_robot,
        )  # fmt: skip
        surroundings.mark_ahead(not controller.predicts)
        return kind(
            context, surroundings=surroundings, planner=planner, path_planners=path_planners,
            costmap_topics=CostmapTopics(context, surroundings, body=body, publish_frequency=local.publish_frequency),
            controller=controller, recoveries=recovering, parameters=driving, threads=threads,
            processors=_processors(reuse, body, driving, tracked=tracked), version=None if maps else reuse.version,
            passive_safety=PassiveSafety(body.robot_radius, body.limits.acc_lim_x), teleop=teleop,
            top_speed=body.limits.max_vel_x, limits_by_place=limits_by_place, adapt=adapt, build=build,
        )  # fmt: skip

    return move_base


def _built(threads: Threads, radius: float, costs: CostParameters, grid: GridMap) -> MapLayers:
    """Return the layers of a grid for a robot of a radius [m], in a thread beside others that call kernels."""
    return build_layers(grid, robot_radius=radius, **msgspec.structs.asdict(costs), threads=threads())


def _kind(maps: bool) -> type[MoveBaseNode]:
    if not maps:
        return MoveBaseNode
    # Imported only here, so that not every container loads key frames.
    from ppaas.nodes.move_base.mapping_node import MappingMoveBaseNode  # noqa: PLC0415

    return MappingMoveBaseNode


def _follower_kind(maps: bool) -> type[WaypointFollowerNode]:
    if not maps:
        return WaypointFollowerNode
    from ppaas.nodes.waypoint_follower.node import MappingWaypointFollowerNode  # noqa: PLC0415  # as above

    return MappingWaypointFollowerNode


def _processors(reuse: ReuseSetup, body: RobotModel, driving: MoveBaseParameters, *, tracked: bool) -> Processors:
    """Return the maker of processors for a map of a version; without a version nothing is reused or stored."""
    parameters = ReuseParameters(driving.reuse_tolerance, driving.reuse_bound)
    filters = {} if tracked else {STATIC_LAYER: msgspec.structs.asdict(StaticLayerParameters(tracked))}

    def processor(costmap: Costmap, version: str | None) -> PlanProcessor:
        setup = ReuseSetup() if version is None else replace(reuse, version=version)
        return setup.processor(costmap, body.robot_radius, parameters, filters=filters)

    return processor


def _masks(given: NodeParameters) -> tuple[KeepoutFilterParameters, SpeedFilterParameters]:
    keepout = given.read(KeepoutFilterParameters, KEEPOUT_FILTER)
    return keepout, given.read(SpeedFilterParameters, SPEED_FILTER)


def _limits_of(
    given: NodeParameters, body: RobotModel, layers: MapLayers
) -> Callable[[MapLayers, Callable[[], float]], list[LimitsByPlace]]:
    """Return the function that returns the speed limits by place of layers; check that these have the masks."""
    limits = partial(_limits, *_masks(given), body.robot_radius)
    limits(layers, epoch)
    return limits


def _limits(
    keepout: KeepoutFilterParameters,
    speed: SpeedFilterParameters,
    radius: float,
    layers: MapLayers,
    now: Callable[[], float],
) -> list[LimitsByPlace]:
    """Return the speed limits of masks and zones; check that the layers contain the masks required.

    The keepout mask is already part of the costmap.
    """
    masks = ((KEEPOUT_FILTER, keepout.wanted, layers.keepout), (SPEED_FILTER, speed.wanted, layers.speed))
    for name, wanted, mask in masks:
        if wanted and mask is None:
            raise Unavailable(f"{name}: mask {wanted!r} was not loaded with the map; reconnect the robot")
    limits: list[LimitsByPlace] = []
    if speed.wanted and layers.speed is not None:
        limits.append(SpeedFilter(layers.speed, speed))
    if slow := ZoneSpeeds(layers.zones, radius, now):
        limits.append(slow)
    return limits


def _optional(
    given: NodeParameters,
    body: RobotModel,
    costs: CostParameters,
    names: FrameNames,
    threads: Threads,
    *,
    layers: MapLayers | None,
    robot: str,
) -> dict[str, Callable[[Context], Node]]:
    """Return the makers of the docking server and of nodes that only some robots have: cameras, 3D maps, people …"""
    maps = layers is None
    octomap = octomap_makers(given, names, threads, wanted=maps and given.has(DEPTH_CAMERA))
    people = people_makers(given, names, layers, robot)
    explore = exploring(given, body, costs, names, maps=maps)
    return octomap | _camera(given) | _echoes(given) | explore | people | docking(given, body, names, layers)


def _camera(given: NodeParameters) -> dict[str, Callable[[Context], Node]]:
    """Return the maker of the node for depth cameras if there are parameters for it."""
    if not given.has(DEPTH_CAMERA):
        return {}
    # Imported only here, so that not every container loads its kernels.
    from ppaas.nodes.depthimage_to_laserscan.node import DepthImageToLaserScanNode  # noqa: PLC0415
    from ppaas.perception.depth_scan import DepthScanParameters  # noqa: PLC0415

    parameters = given.read(DepthScanParameters, DEPTH_CAMERA)
    return {DEPTH_CAMERA: lambda context: DepthImageToLaserScanNode(context, parameters)}


def _echoes(given: NodeParameters) -> dict[str, Callable[[Context], Node]]:
    """Return the maker of the node for lasers with several echoes if there are parameters for it."""
    if not given.has(LASER_PROC):
        return {}
    # As above.
    from ppaas.nodes.laser_proc import LaserProcNode, LaserProcParameters  # noqa: PLC0415

    parameters = given.read(LaserProcParameters, LASER_PROC)
    return {LASER_PROC: lambda context: LaserProcNode(context, parameters)}


def _body(
    given: NodeParameters, model: str, urdf: RobotDescription | None, parameters: Mapping[str, Any] | None
) -> RobotModel:
    """Return the body, and record its parameters among those in use."""
    body = robot_body(model, urdf, parameters)
    given.read(GlobalCostmapParameters, COSTMAP, {"robot_radius": body.robot_radius, "footprint": body.footprint})
    given.read(VoxelLayerParameters, VOXEL_LAYER, {"max_obstacle_height": body.height})
    return body


def _driving(given: NodeParameters, planner: str, controller: str) -> MoveBaseParameters:
    """Return the parameters of Move Base; the plug-ins of the robot's file are the defaults."""
    base = {"base_global_planner": planner, "base_local_planner": controller} | move_base_defaults(given)
    return given.read(MoveBaseParameters, "move_base", base)
