"""Facts of the diagnosis: what was observed of a robot in the last seconds. Processes send them as JSON."""

import math
import sys
from typing import Any

import msgspec

from ppaas.decoding import from_json

# -- facts of the diagnosis --------------------------------------------------------------------------------------------


class TopicFacts(msgspec.Struct, kw_only=True, frozen=True):
    """Messages of one topic.

    Parameters
    ----------
    name, type : str
        The topic, and its type by its name in ROS 1.
    count : int
        Messages since the container started.
    rate : float
        Messages a second while the robot was watched.
    bandwidth : float
        Data rate of the messages over the robot's connection [bytes/s].
    size : float
        Mean size of a message [bytes]; 0 if none came over the connection.
    silence : float, optional
        Time since the last message [s]; None if none came.
    gap : float, optional
        Longest time between two messages [s].
    burst : float
        Share of the messages that came within a tenth of the usual interval after the one before.
    late : float, optional
        Median of the time between the stamp of a message and its arrival, by the clock of the cloud [s].
    growth : float
        Steady growth of that time while the robot was watched [s].
    unstamped : float
        Share of the messages whose stamp is zero.
    backwards : int
        Number of messages that are stamped before the message before, of the same frame.
    senders : int
        Number of clients that sent messages; 0 if none came while the robot was watched.
    refused : int
        Messages that the clone refused while the robot was watched; 0 if it accepts them again.
    refused_count : int
        Messages that the clone refused since the container started.
    refusal : str
        Reason of the last refusal.
    """

    name: str
    type: str = ""
    count: int = 0
    rate: float = 0.0
    bandwidth: float = 0.0
    size: float = 0.0
    silence: float | None = None
    gap: float | None = None
    burst: float = 0.0
    late: float | None = None
    growth: float = 0.0
    unstamped: float = 0.0
    backwards: int = 0
    senders: int = 0
    refused: int = 0
    refused_count: int = 0
    refusal: str = ""


class ScanFacts(msgspec.Struct, kw_only=True, frozen=True):
    """Last scan of one laser.

    Parameters
    ----------
    frame : str
        Frame of the laser; empty if the scan names none.
    beams : int
    excess : float
        Number of ranges beyond the number that the angles give.
    increment, range_min, range_max : float
        Fields of the scan [rad, m, m].
    readings, zeros, empty, short : float
        Shares of the ranges: within the limits; zero; null, NaN or infinite; positive, but below ``range_min``.
    intensities : int
        Number of intensities.
    """

    frame: str = ""
    beams: int = 0
    excess: float = 0.0
    increment: float = 0.0
    range_min: float = 0.0
    range_max: float = 0.0
    readings: float = 0.0
    zeros: float = 0.0
    empty: float = 0.0
    short: float = 0.0
    intensities: int = 0


class MotionFacts(msgspec.Struct, kw_only=True, frozen=True):
    """Commands and odometry of the same seconds.

    Parameters
    ----------
    commands : int
        Number of messages on ``cmd_vel``.
    ordered, ordered_turn : float
        Distance and angle that the commands add up to, with their signs [m, rad].
    ordered_path : float
        Distance that they add up to, without signs, plus the angle times `ARM` of the recorder [m].
    moved, moved_turn, moved_path : float
        The same of the odometry.
    parent, child : str
        Frames that the odometry names.
    jump : float
        Largest distance between two messages of the odometry [m].
    """

    commands: int = 0
    ordered: float = 0.0
    ordered_turn: float = 0.0
    ordered_path: float = 0.0
    moved: float = 0.0
    moved_turn: float = 0.0
    moved_path: float = 0.0
    parent: str = ""
    child: str = ""
    jump: float = 0.0


class FrameFacts(msgspec.Struct, kw_only=True, frozen=True):
    """A frame of ``tf`` or ``tf_static``.

    Parameters
    ----------
    name : str
    parents : tuple of str
        Parents that it was given while the robot was watched, the last one last.
    static : bool
        Whether its last transform is static.
    silence : float
        Time since the last transform [s].
    alternates : bool
        Whether its transforms jump to and fro, as with two senders.
    """

    name: str
    parents: tuple[str, ...] = ()
    static: bool = False
    silence: float = 0.0
    alternates: bool = False


class PlaceFacts(msgspec.Struct, kw_only=True, frozen=True):
    """The robot on its map.

    Parameters
    ----------
    problem : str
        Reason for which localization uses no scans, from its own report; empty while it uses them.
    pose : tuple of float, optional
        Estimated pose in the map: x [m], y [m], yaw [rad].
    silence : float, optional
        Time since the last estimate [s].
    deviation, turn_deviation : float, optional
        Standard deviations of the estimate [m, rad].
    explained : float, optional
        Share of the beams of the last scan that end at a wall of the map.
    cell : {"", "free", "occupied", "unknown", "outside"}
        The map at the pose; empty if unknown.
    clearance : float, optional
        Distance from the pose to the nearest occupied cell of the map [m].
    barrier : str
        The keep-out zone or mask that the robot's centre is in, in words; empty if it is in none.
    radius : float
        Largest radius around the robot's centre that is within its footprint [m].
    """

    problem: str = ""
    pose: tuple[float, float, float] | None = None
    silence: float | None = None
    deviation: float | None = None
    turn_deviation: float | None = None
    explained: float | None = None
    cell: str = ""
    clearance: float | None = None
    barrier: str = ""
    radius: float = 0.0


class GoalFacts(msgspec.Struct, kw_only=True, frozen=True):
    """The newest goal of Move Base.

    Parameters
    ----------
    name : str
        Empty if there is none.
    status : int
        Number of ``actionlib_msgs/GoalStatus``.
    text : str
        What Move Base does for it, or the reason why it ended.
    """

    name: str = ""
    status: int = 0
    text: str = ""


class HandFacts(msgspec.Struct, kw_only=True, frozen=True):
    """Who drives the robot by hand.

    Parameters
    ----------
    driver : str
        User; empty if nobody drives.
    mode, text : str
        Of the newest ``ppaas_msgs/TeleopState``.
    """

    driver: str = ""
    mode: str = ""
    text: str = ""


class NodeFacts(msgspec.Struct, kw_only=True, frozen=True):
    """Home of a node, ``cloud`` or ``robot``, the wanted one, and the reasons for it."""

    name: str
    home: str = "cloud"
    wanted: str = "cloud"
    reasons: tuple[str, ...] = ()


class ReportFacts(msgspec.Struct, kw_only=True, frozen=True):
    """Status that a program of the robot publishes on ``diagnostics``: 0 is ok, 1 a warning, 2 an error, 3 stale."""

    name: str
    level: int = 0
    text: str = ""


class LinkFacts(msgspec.Struct, kw_only=True, frozen=True):
    """Connections of the robot, as the cloud sees them.

    Parameters
    ----------
    robots, operators : int
        Connected sockets in each role.
    round_trip : float, optional
        Time between a ping and its answer [s].
    dropped : int
        Messages to the robot that were dropped, because it reads too slowly; 0 if none was in the last minute.
    waiting : int
        Messages that wait for the robot now.
    connects : int
        Connections of the robot in the last minutes.
    subscribed : tuple of str
        Topics that clients in the role robot subscribe to.
    client_topics : dict of str to str
        Topics that clients advertise and the clone does not have, with their types.
    refused : dict of str to str
        Reasons of the last refusals of operations, by topic.
    """

    robots: int = 0
    operators: int = 0
    round_trip: float | None = None
    dropped: int = 0
    waiting: int = 0
    connects: int = 0
    subscribed: tuple[str, ...] = ()
    client_topics: dict[str, str] = {}
    refused: dict[str, str] = {}


class Observations(msgspec.Struct, kw_only=True):
    """Observations of a robot.

    Parameters
    ----------
    seconds : float
        Time for which the robot was watched [s].
    robot : str
        Id of the robot.
    base, prefix : str
        Frame in which the robot is driven, and the prefix of its frames.
    makes_map : bool
        Whether the robot makes a new map.
    camera : bool
        Whether a depth camera makes its scans.
    follows_paths : bool
        Whether the robot localizes itself and follows paths itself, as an AGV does.
    localizes_itself : bool
        Whether the robot localizes itself, and is driven by velocities.
    stopped : str
        The stops that hold the robot, in words; empty if it is not stopped.
    link : LinkFacts, optional
        None in the container, which does not know the robot's connection.
    """

    seconds: float
    robot: str = "ROBOT"
    base: str = "base_link"
    prefix: str = ""
    makes_map: bool = False
    camera: bool = False
    follows_paths: bool = False
    topics: list[TopicFacts] = []
    scans: list[ScanFacts] = []
    motion: MotionFacts = MotionFacts()
    frames: list[FrameFacts] = []
    place: PlaceFacts = PlaceFacts()
    goal: GoalFacts = GoalFacts()
    stopped: str = ""
    hand: HandFacts = HandFacts()
    nodes: list[NodeFacts] = []
    reports: list[ReportFacts] = []
    link: LinkFacts | None = None
    localizes_itself: bool = False

    def topic(self, name: str) -> TopicFacts:
        """Return the facts of a topic; the facts of a silent one if there are none."""
        return next((each for each in self.topics if each.name == name), TopicFacts(name=name))

    def on_robot(self, node: str) -> bool:
        """Return whether a node runs on the robot."""
        return any(each.name == node and each.home == "robot" for each in self.nodes)

    def frame(self, name: str) -> FrameFacts | None:
        """Return the facts of a frame that has a parent; None for any other."""
        return next((each for each in self.frames if each.name == name), None)


# -- facts about a robot that is not connected -------------------------------------------------------------------------


class AbsenceFacts(msgspec.Struct, kw_only=True, frozen=True):
    """What the cloud knows of a robot without its messages.

    Parameters
    ----------
    robot : str
    agv : str
        Manufacturer and serial number of the AGV that the robot is by its file; empty for other robots.
    refusal : str
        Reason for which its last attempt to connect was refused; empty without one, or if it connected since.
    refused_ago : float
        Time since then [s].
    map_problem, quota_problem : str
        Reasons for which its map cannot be used, and for which its user may have no more containers; else empty.
    cores : float
        Size of its container [cores].
    free : tuple of float
        What each machine that accepts containers could give it [cores].
    """

    robot: str
    agv: str = ""
    refusal: str = ""
    refused_ago: float = 0.0
    map_problem: str = ""
    quota_problem: str = ""
    cores: float = 1.0
    free: tuple[float, ...] = ()


# -- observations as JSON, which has neither NaN nor infinity, for another process -------------------------------------


def observations_to_json(seen: Observations) -> str:
    """Return observations as JSON; numbers that a robot has driven beyond all bounds are the largest ones, NaN is 0."""
    return msgspec.json.encode(_finite(msgspec.to_builtins(seen))).decode()


def observations_from_json(text: str) -> Observations:
    """Return the observations of a JSON text; raises ``msgspec.DecodeError`` if it is none of ours."""
    return from_json(text, Observations)


def _finite(value: Any) -> Any:
    match value:
        case float() if not math.isfinite(value):
            return 0.0 if math.isnan(value) else math.copysign(sys.float_info.max, value)
        case dict():
            return {key: _finite(each) for key, each in value.items()}
        case list() | tuple():
            return [_finite(each) for each in value]
        case _:
            return value
