"""People around a clone's robot: the nodes that find, track and follow them, for robots with parameters for these."""

from collections.abc import Callable

from ppaas.clone.node_parameters import NodeParameters
from ppaas.costmap.map_layers import MapLayers
from ppaas.nodes.base import Context, Node
from ppaas.nodes.frames import FrameNames
from ppaas.people.nodes import FOLLOW_PERSON, LEG_DETECTOR, PEOPLE_TRACKER, TORSO_DETECTOR

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
