"""Types of ``ppaas_msgs`` between robots that see people, and the node that coordinates them."""

from typing import Annotated

import msgspec
from msgspec import field

from ppaas.messages.base.message import Empty, OwnMessage, ServiceType
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Point, PoseStamped, PoseWithCovariance
from ppaas.messages.people_msgs import PositionMeasurement

PACKAGE = "ppaas_msgs"
"""ROS package of these types."""

PlanarCovariance = Annotated[list[float], msgspec.Meta(extra={"length": 4})]
"""2 × 2 covariance matrix of x and y [m²], row-major."""

SEEN, PREDICTED, LOST = "seen", "predicted", "lost"
"""States of a person: in some robot's view; hidden, at a predicted position; hidden for too long to be counted."""


class SensorView(OwnMessage):
    """``ppaas_msgs/SensorView``: the region in which a sensor of a robot detects people.

    Parameters
    ----------
    x, y, yaw : float
        Pose of the sensor in the robot's frame [m, rad].
    field_of_view : float
        Horizontal field of view [rad].
    range_min, range_max : float
        Limits of the distance at which people are detected [m].
    """

    x: float
    y: float
    yaw: float
    field_of_view: float
    range_min: float
    range_max: float


class PeopleReport(OwnMessage):
    """``ppaas_msgs/PeopleReport``: the people that a robot sees, and its own position with its uncertainty.

    Parameters
    ----------
    header : Header
        Time of the measurements; frame of the map.
    robot : str
        Robot ID.
    pose : PoseWithCovariance
        Pose of the robot in the map at that time.
    people : list of PositionMeasurement
        In the robot's base frame. ``object_id`` is the Torso ID, which the robot keeps while it tracks the person;
        ``name`` is the tf frame ``{Robot ID}/{Torso ID}``.
    views : list of SensorView
        Views of its detectors. A person in one of them who is not in ``people`` is hidden or has left.
    can_follow : bool
        Whether the robot can follow a person.
    following : int
        Id of the person that it follows; 0 for none.
    gave_up : int
        Id of the person whom it was ordered to follow, and gave up; 0 for none.
    """

    header: Header
    robot: str
    pose: PoseWithCovariance
    people: list[PositionMeasurement] = field(default_factory=list)
    views: list[SensorView] = field(default_factory=list)
    can_follow: bool = False
    following: int = 0
    gave_up: int = 0


class TrackedPerson(OwnMessage):
    """``ppaas_msgs/TrackedPerson``: a person on the map, as all robots together see them.

    Parameters
    ----------
    id : int
        Identity, from 1; it is never reused.
    name : str
        Name that a user gave; empty without one.
    position : Point
        In the frame of the map [m].
    velocity : Point
        [m/s].
    covariance : list of float
        Covariance of the position.
    state : str
        `SEEN`, `PREDICTED` or `LOST`.
    seen_by : list of str
        The tf frames ``{Robot ID}/{Torso ID}`` that are this person now.
    first_seen, last_seen : Time
    group : int
        Number of the group of people who stand and talk; 0 for nobody else.
    """

    id: int
    position: Point
    velocity: Point
    covariance: PlanarCovariance
    name: str = ""
    state: str = SEEN
    seen_by: list[str] = field(default_factory=list)
    first_seen: Time = field(default_factory=Time)
    last_seen: Time = field(default_factory=Time)
    group: int = 0


class FollowOrder(OwnMessage):
    """``ppaas_msgs/FollowOrder``: the robot that follows a person.

    Parameters
    ----------
    robot : str
        Robot ID.
    person : int
        Id of the person.
    cost : float
        Cost of the shortest path from the robot to the person.
    since : Time
        Start of this order.
    reason : str
        Why this robot follows this person, for people to read.
    """

    robot: str
    person: int
    cost: float
    since: Time
    reason: str = ""


class GroupRobot(OwnMessage):
    """``ppaas_msgs/GroupRobot``: a robot of the group.

    Parameters
    ----------
    robot : str
        Robot ID.
    position : Point
        Position in the frame of the map [m].
    deviation : float
        Maximum deviation of its position [m].
    sees : int
        Number of people that it sees.
    trusted : bool
        Whether its reports are used.
    reason : str
        Why they are not used; empty if they are.
    """

    robot: str
    position: Point
    deviation: float
    sees: int = 0
    trusted: bool = True
    reason: str = ""


class PeopleState(OwnMessage):
    """``ppaas_msgs/PeopleState``: the people on a map, and the robots that follow them.

    Parameters
    ----------
    header : Header
        Time of the positions; frame of the map.
    count : int
        Number of different people that robots see now: the total of the People Counter.
    people : list of TrackedPerson
    orders : list of FollowOrder
    robots : list of GroupRobot
    rule : str
        Name of the rule that chooses whom to follow.
    seconds : float
        Time that the last cycle took [s].
    """

    header: Header
    count: int
    people: list[TrackedPerson] = field(default_factory=list)
    orders: list[FollowOrder] = field(default_factory=list)
    robots: list[GroupRobot] = field(default_factory=list)
    rule: str = ""
    seconds: float = 0.0


IDLE, FOLLOWING, WAITING, SEARCHING, PAUSED, GAVE_UP = (
    "idle", "following", "waiting", "searching", "paused", "gave_up"
)  # fmt: skip
"""States of following: no order; driving after the person; standing near them; searching for them; a client drives the
robot or has stopped it; they were not found or could not be reached."""


class FollowStatus(OwnMessage):
    """``ppaas_msgs/FollowStatus``: what a robot does to follow a person.

    Parameters
    ----------
    header : Header
        Time of the message; frame of the map.
    state : str
        `IDLE`, `FOLLOWING`, `WAITING`, `SEARCHING`, `PAUSED` or `GAVE_UP`.
    person : int
        Id of the person of the robot's order; 0 without an order.
    distance : float
        Distance from the robot to where the person is believed to be [m]; 0 while it is unknown.
    reason : str
        Why it is in this state, for people to read.
    can_follow : bool
        Whether the robot can be ordered to follow a person now.
    """

    header: Header
    state: str = IDLE
    person: int = 0
    distance: float = 0.0
    reason: str = ""
    can_follow: bool = True

    @property
    def following(self) -> int:
        """Id of the person that the robot follows or searches for; 0 for none."""
        return self.person if self.state in (FOLLOWING, WAITING, SEARCHING) else 0

    @property
    def gave_up(self) -> int:
        """Id of the person that the robot gave up; 0 for none."""
        return self.person if self.state == GAVE_UP else 0


class GoalUpdate(OwnMessage):
    """``ppaas_msgs/GoalUpdate``: moves a goal of Move Base while the robot drives to it.

    Parameters
    ----------
    goal_id : str
        Id of the goal; without effect if another goal is active.
    target_pose : PoseStamped
        Pose of the goal from now on.
    speed_limit : float
        Fastest speed until the goal ends or is updated again [m/s]; 0 for no limit. Other limits apply too.
    """

    goal_id: str
    target_pose: PoseStamped
    speed_limit: float = 0.0


GetPeople = ServiceType("ppaas_msgs/GetPeople", Empty, PeopleState)


class ZoneCount(OwnMessage):
    """``ppaas_msgs/ZoneCount``: number of different people in a zone in one hour.

    Parameters
    ----------
    zone : str
        Name of the zone; empty for the whole map.
    hour : int
        Start of the hour [s since the epoch].
    people : int
        Number of different people who were seen in the zone.
    """

    zone: str
    hour: int
    people: int


class GetPeopleCountsRequest(OwnMessage):
    """``ppaas_msgs/GetPeopleCounts`` request.

    Parameters
    ----------
    since : int
        Hours that ended before this time are left out [s since the epoch].
    """

    since: int = 0


class GetPeopleCountsResponse(OwnMessage):
    """``ppaas_msgs/GetPeopleCounts`` response: the counts, also of the current hour; empty without history."""

    counts: list[ZoneCount] = field(default_factory=list)


GetPeopleCounts = ServiceType("ppaas_msgs/GetPeopleCounts", GetPeopleCountsRequest, GetPeopleCountsResponse)


class ConfigurePeopleRequest(OwnMessage):
    """``ppaas_msgs/ConfigurePeople`` request: settings of the group, as JSON of ``ppaas.people.settings``."""

    settings: str


ConfigurePeople = ServiceType("ppaas_msgs/ConfigurePeople", ConfigurePeopleRequest, Empty)

SERVICES = (GetPeople, GetPeopleCounts, ConfigurePeople)
