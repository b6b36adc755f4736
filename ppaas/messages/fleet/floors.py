"""Types of ``ppaas_msgs`` for robots that ride in lifts: on which floor is it?"""

from msgspec import field

from ppaas.geometry import Pose2D
from ppaas.messages.base.message import OwnMessage, ServiceType, UInt32
from ppaas.messages.geometry_msgs import Pose

PACKAGE = "ppaas_msgs"
"""ROS package of these types."""


def _at_origin() -> Pose:
    return Pose.of(Pose2D(0.0, 0.0))


class FloorPart(OwnMessage):
    """``ppaas_msgs/FloorPart``: part of the map of a floor, around the landing of a lift.

    Parameters
    ----------
    floor : str
        Name of the floor.
    elevation : float
        Height of the floor [m].
    change : Pose
        Pose of the frame of the robot's map in the frame of this map, if the car stands at this floor.
    resolution : float
        Edge of a cell [m].
    width, height : int
        Numbers of cells along x and y.
    origin : Pose
        Pose of the corner of the first cell in the frame of the map.
    data : bytes
        Cells, row by row, as in ``nav_msgs/OccupancyGrid``, compressed with zlib.
    """

    floor: str
    elevation: float
    resolution: float
    width: UInt32
    height: UInt32
    origin: Pose
    data: bytes
    change: Pose = field(default_factory=_at_origin)


class FindFloorRequest(OwnMessage):
    """``ppaas_msgs/FindFloor`` request.

    Parameters
    ----------
    origin, destination : str
        Floor at which the robot came into the car, and the one to which it was sent.
    named : str
        Floor at which the lift says that it stands; empty if it says nothing.
    floors : list of FloorPart
        Floors that the robot may be on. Without any, the answer has the pressure of the air alone, and comes at once.
    pressure : float
        Pressure of the air at the floor of origin [Pa]; 0 if it is not known.
    seconds : float
        Time since it was measured [s].
    clear : float
        Distance that the robot drives until it is out of the car [m]: scans from within show the car of every floor.
    timeout : float
        Time after which the answer comes although the floor is not known [s].
    """

    origin: str = ""
    destination: str = ""
    named: str = ""
    floors: list[FloorPart] = field(default_factory=list)
    pressure: float = 0.0
    seconds: float = 0.0
    clear: float = 0.0
    timeout: float = 10.0


class FindFloorResponse(OwnMessage):
    """``ppaas_msgs/FindFloor`` response.

    Parameters
    ----------
    floor : str
        The likeliest floor.
    known : bool
        Whether the floor is known, and the robot is localized on its map.
    probability : float
        Probability of the floor.
    fits : bool
        Whether the last scan fits the map of that floor.
    pose : Pose
        Pose of the robot in the frame of the map of that floor.
    pressure : float
        Pressure of the air now [Pa]; 0 without a barometer.
    """

    floor: str = ""
    known: bool = False
    probability: float = 0.0
    fits: bool = False
    pose: Pose = field(default_factory=_at_origin)
    pressure: float = 0.0


FindFloor = ServiceType("ppaas_msgs/FindFloor", FindFloorRequest, FindFloorResponse)

SERVICES = (FindFloor,)
