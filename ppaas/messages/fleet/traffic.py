"""Types of ``ppaas_msgs`` between robots that drive by grants, the traffic node of their map, and its zones."""

from msgspec import field

from ppaas.messages.base.message import Empty, OwnMessage, ServiceType
from ppaas.messages.base.std_msgs import Header

PACKAGE = "ppaas_msgs"
"""ROS package of these types."""


# -- robots that drive by grants, and the traffic node of their map ----------------------------------------------------

NO_WAY = "a way"
"""What a robot waits for while no way to its goal is free."""


class MapPoint(OwnMessage):
    """``ppaas_msgs/MapPoint``: a point in the map frame [m]."""

    x: float
    y: float


class TrafficReport(OwnMessage):
    """``ppaas_msgs/TrafficReport``: what a robot holds, where it is, and where it wants to go.

    Parameters
    ----------
    header : Header
        Time of the pose; frame of the map.
    robot : str
        Robot ID.
    x, y, theta : float
        Pose of the robot [m, rad].
    radius : float
        Radius of its circumscribed circle [m].
    speed : float
        Its fastest speed [m/s].
    braking : float
        Distance that it needs to stop from that speed [m].
    epoch, grants : int
        Epoch and number of the last `TrafficGrants` that it took; 0 before the first.
    revision : int
        Revision of its way. It grows whenever the robot gives back the rest of its way.
    first : int
        Number of the first point of ``way`` within the revision.
    way : list of MapPoint
        Centres of the granted cells that it holds, in order: from the last one that it has reached. Before it has
        reached one, it also holds what it touches.
    ahead : int
        Number of the last points of ``way`` that it has not reached.
    free : bool
        Whether it drives freely, because it is alone.
    stray : bool
        Whether it has left what it holds. It stands until it is led back.
    blocked : list of MapPoint
        Centres of granted cells that something else occupies.
    goal_id : str
        Goal that it wants to reach; empty if it has none.
    goal : MapPoint
    goal_seconds : float
        Time for which it has wanted it [s].
    tolerance : float
        Distance from its goal within which it counts as reached [m].
    spur : list of MapPoint
        Where it is or may go beside the last cell of ``way``, by the spur that it took; one point or none.
    aside : str
        Why it follows no grants now: ``by_hand`` if an operator drives it, ``held`` if it is stopped; empty if it does.
        It holds what it touches, wherever it is.
    approach : list of MapPoint
        Both ends of the straight way on which it wants to dock or undock, or its place at a dock. It is ``held`` then,
        and holds what it touches there.
    """

    header: Header
    robot: str
    x: float
    y: float
    theta: float
    radius: float
    speed: float
    braking: float
    epoch: int = 0
    grants: int = 0
    revision: int = 0
    first: int = 0
    way: list[MapPoint] = field(default_factory=list)
    ahead: int = 0
    free: bool = False
    stray: bool = False
    blocked: list[MapPoint] = field(default_factory=list)
    goal_id: str = ""
    goal: MapPoint = field(default_factory=lambda: MapPoint(0.0, 0.0))
    goal_seconds: float = 0.0
    tolerance: float = 0.0
    spur: list[MapPoint] = field(default_factory=list)
    aside: str = ""
    approach: list[MapPoint] = field(default_factory=list)


class TrafficGrants(OwnMessage):
    """``ppaas_msgs/TrafficGrants``: how far a robot may drive.

    Parameters
    ----------
    header : Header
        Time; frame of the map.
    robot : str
        Robot that it is for.
    epoch : int
        Epoch of the traffic node. Grants of an earlier epoch than the latest are not valid.
    number : int
        Number of the message within the epoch; an older one than the last is ignored.
    revision : int
        Revision of the robot's way that the grants continue; grants of another revision are not valid.
    spacing : float
        Distance of neighbouring cells [m].
    first : int
        Number of the first point of ``way`` within the revision.
    way : list of MapPoint
        Centres of the granted cells, in the order in which the robot passes them.
    at_goal : bool
        Whether the last one is the cell of its goal.
    goal_id : str
        Goal that the way leads to, or that is refused; empty if it leads out of the way of others.
    free : bool
        Whether the robot may drive freely, because it is alone.
    give_back : bool
        Whether the robot should stop and give back the rest of its way.
    waits_for : str
        Why it cannot go on: names the robot that it waits for, for example.
    refused : str
        Why its goal cannot be reached: somebody stands on it for ever. Empty if it can.
    spur : list of MapPoint
        The goal, if the robot may drive to it from the centre of the last cell, although it touches other cells there.
        Without it, the robot stops in the last cell, or drives back to its centre.
    approach : list of MapPoint
        The approach that the robot reported, once it may drive there.
    """

    header: Header
    robot: str
    epoch: int
    number: int
    revision: int
    spacing: float
    first: int = 0
    way: list[MapPoint] = field(default_factory=list)
    at_goal: bool = False
    goal_id: str = ""
    free: bool = False
    give_back: bool = False
    waits_for: str = ""
    refused: str = ""
    spur: list[MapPoint] = field(default_factory=list)
    approach: list[MapPoint] = field(default_factory=list)


class TrafficRobot(OwnMessage):
    """``ppaas_msgs/TrafficRobot``: a robot of the traffic, for those who look.

    Parameters
    ----------
    robot : str
    state : str
        ``driving``, ``waiting``, ``idle``, ``free``, ``stopped``, ``stray``, ``by_hand``, ``held``, ``silent``,
        ``docking``, ``docked``, ``no_cells``, or ``out``.
    x, y, theta : float
        Pose in the map frame [m, rad].
    way : list of MapPoint
        Cells that it holds.
    waits_for : str
        Why it waits, or why there are no cells for it.
    goal_id : str
    goal : MapPoint
    waited : float
        Time for which it has waited [s].
    """

    robot: str
    state: str
    x: float
    y: float
    theta: float
    way: list[MapPoint] = field(default_factory=list)
    waits_for: str = ""
    goal_id: str = ""
    goal: MapPoint = field(default_factory=lambda: MapPoint(0.0, 0.0))
    waited: float = 0.0


class TrafficState(OwnMessage):
    """``ppaas_msgs/TrafficState``: the traffic of a map, published by its traffic node once a second.

    Parameters
    ----------
    header : Header
        Time; frame of the map.
    epoch : int
    spacing : float
        Distance of neighbouring cells [m]; 0 before there is a robot.
    robots : list of TrafficRobot
    goals : int
        Number of goals reached since the node began.
    seconds : float
        Time that it has planned for since then [s].
    """

    header: Header
    epoch: int
    spacing: float
    robots: list[TrafficRobot] = field(default_factory=list)
    goals: int = 0
    seconds: float = 0.0


class RobotOfTraffic(OwnMessage):
    """Request of ``ppaas_msgs/TakeOut`` and ``ppaas_msgs/PutBack``: the robot that is taken out or put back."""

    robot: str


GetTraffic = ServiceType("ppaas_msgs/GetTraffic", Empty, TrafficState)
"""Service that returns the traffic of a map."""

TakeOut = ServiceType("ppaas_msgs/TakeOut", RobotOfTraffic, Empty)
"""Service that takes a robot out of the traffic of its map: what it holds is free, and it is not waited for."""

PutBack = ServiceType("ppaas_msgs/PutBack", RobotOfTraffic, Empty)
"""Service that puts a robot back into the traffic, where it now stands."""


# -- zones -------------------------------------------------------------------------------------------------------------


class ZonesOfMap(OwnMessage):
    """Zones of a map, as GeoJSON in metres in the frame of the map."""

    geojson: str


GetZones = ServiceType("ppaas_msgs/GetZones", Empty, ZonesOfMap)
"""Service that returns the zones of a map."""

SERVICES = (GetTraffic, TakeOut, PutBack, GetZones)
