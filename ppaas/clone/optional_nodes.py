"""Nodes that a clone has on request: people, exploration and 3D maps, each by its parameters."""

from collections.abc import Callable
from functools import partial

import msgspec

from ppaas.clone.node_parameters import NodeParameters
from ppaas.costmap.build_layers import build_layers
from ppaas.costmap.global_parameters import CostParameters
from ppaas.costmap.map_layers import MapLayers
from ppaas.exploration.parameters import ExploreParameters
from ppaas.nodes.base import Context, Node
from ppaas.nodes.frames import FrameNames
from ppaas.people.names import FOLLOW_PERSON, LEG_DETECTOR, PEOPLE_TRACKER, TORSO_DETECTOR
from ppaas.robot_model.known_models import RobotModel
from ppaas.thread_budget import Threads

Makers = dict[str, Callable[[Context], Node]]


def people_makers(given: NodeParameters, names: FrameNames, layers: MapLayers | None, robot: str) -> Makers:
    """Return the makers of the nodes that the robot has parameters for.

    Parameters
    ----------
    given : NodeParameters
    names : FrameNames
        Names of the robot's frames.
    layers : MapLayers or None
        The map; None for a robot that makes it.
    robot : str
        Robot ID.

    Raises
    ------
    InvalidParameter
        A parameter is unknown or invalid.
    """
    detects = given.has(TORSO_DETECTOR, LEG_DETECTOR)
    tracker = _people_tracker(given, names, robot) if detects or given.has(PEOPLE_TRACKER) else {}
    detectors = _torso_detector(given, names) | _leg_detector(given, names, layers)
    return detectors | tracker | _follower(given, names, layers, robot)


def _torso_detector(given: NodeParameters, names: FrameNames) -> Makers:
    if not given.has(TORSO_DETECTOR):
        return {}
    # Imported only here, so that not every container loads it; likewise below.
    from ppaas.nodes.torso_detector.node import TorsoDetectorNode  # noqa: PLC0415
    from ppaas.perception.torso.parameters import TorsoDetectorParameters  # noqa: PLC0415

    parameters = given.read(TorsoDetectorParameters, TORSO_DETECTOR)
    return {TORSO_DETECTOR: lambda context: TorsoDetectorNode(context, parameters, names)}


def _leg_detector(given: NodeParameters, names: FrameNames, layers: MapLayers | None) -> Makers:
    if not given.has(LEG_DETECTOR):
        return {}
    from ppaas.nodes.leg_detector.node import LegDetectorNode  # noqa: PLC0415
    from ppaas.perception.legs.parameters import LegDetectorParameters  # noqa: PLC0415

    parameters = given.read(LegDetectorParameters, LEG_DETECTOR)
    return {LEG_DETECTOR: lambda context: LegDetectorNode(context, parameters, layers, names)}


def _people_tracker(given: NodeParameters, names: FrameNames, robot: str) -> Makers:
    from ppaas.nodes.people_tracker.node import PeopleTrackerNode  # noqa: PLC0415
    from ppaas.nodes.people_tracker.parameters import PeopleTrackerParameters  # noqa: PLC0415

    parameters = given.read(PeopleTrackerParameters, PEOPLE_TRACKER)
    return {PEOPLE_TRACKER: lambda context: PeopleTrackerNode(context, parameters, robot, names)}


def _follower(given: NodeParameters, names: FrameNames, layers: MapLayers | None, robot: str) -> Makers:
    """Return the maker of the node that follows people; a robot that makes its map has neither coordinator nor node."""
    if not given.has(FOLLOW_PERSON):
        return {}
    from ppaas.nodes.follow_person.node import FollowPersonNode  # noqa: PLC0415
    from ppaas.people.following.parameters import FollowParameters  # noqa: PLC0415

    if layers is None:
        given.check(FollowParameters, FOLLOW_PERSON)
        return {}
    parameters = given.read(FollowParameters, FOLLOW_PERSON)
    return {FOLLOW_PERSON: lambda context: FollowPersonNode(context, parameters, robot, layers, names)}


EXPLORE = "explore"
"""Name of the node."""


def exploring(
    given: NodeParameters, body: RobotModel, costs: CostParameters, names: FrameNames, *, maps: bool
) -> dict[str, Callable[[Context], Node]]:
    """Return the maker of the node if the robot makes a map; else its parameters are checked, but not used.

    Raises
    ------
    InvalidParameter
        A parameter is unknown or invalid.
    """
    if not maps:
        if given.has(EXPLORE):
            given.check(ExploreParameters, EXPLORE)
        return {}
    # Imported only here, so that not every container loads its kernels.
    from ppaas.nodes.explore.node import ExploreNode  # noqa: PLC0415

    parameters = given.read(ExploreParameters, EXPLORE)
    build = partial(build_layers, robot_radius=body.robot_radius, **msgspec.structs.asdict(costs))
    return {EXPLORE: lambda context: ExploreNode(context, parameters, build, names)}


OCTOMAP_SERVER = "octomap_server"
"""Node that makes a 3D map."""


def octomap_makers(
    given: NodeParameters, names: FrameNames, threads: Threads, *, wanted: bool
) -> dict[str, Callable[[Context], Node]]:
    """Return the maker of the node, if there are parameters for it or it is wanted without.

    Raises
    ------
    InvalidParameter
        A parameter is unknown, invalid, or not supported.
    Unavailable
        Clouds are to be registered, and the library for it is not installed.
    """
    if not (wanted or given.has(OCTOMAP_SERVER)):
        return {}
    # Imported only here, so that not every container loads its kernels.
    from ppaas.mapping.volume.registration import library  # noqa: PLC0415
    from ppaas.nodes.octomap_server.node import OctomapServerNode  # noqa: PLC0415
    from ppaas.nodes.octomap_server.parameters import OctomapServerParameters, spelled  # noqa: PLC0415

    parameters = given.read(OctomapServerParameters, OCTOMAP_SERVER, spelled(given.take(OCTOMAP_SERVER)))
    if parameters.registration:
        library()
    own = FrameNames.of(parameters.odom_frame_id, parameters.base_frame_id, parameters.frame_id, parameters.tf_prefix)
    frames = names if own == FrameNames() else own
    return {OCTOMAP_SERVER: lambda context: OctomapServerNode(context, parameters, threads, frames)}
