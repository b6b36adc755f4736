"""``people_msgs``: positions and velocities of people."""

from typing import Annotated

import msgspec
from msgspec import field

from ppaas.messages.base.message import Float32, Int8, Message
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.geometry_msgs import Point


class Person(Message):
    """``people_msgs/Person``: position [m] and velocity [m/s], in the frame of ``People``."""

    name: str
    position: Point
    velocity: Point = field(default_factory=lambda: Point(0.0, 0.0))
    reliability: float = 1.0
    tagnames: list[str] = field(default_factory=list)
    tags: list[str] = field(default_factory=list)


class People(Message):
    """``people_msgs/People``."""

    header: Header
    people: list[Person]


class PositionMeasurement(Message):
    """``people_msgs/PositionMeasurement``: a detected person.

    Parameters
    ----------
    name : str
        Name of the detector; of the robot's tracker, the tf frame of the person.
    object_id : str
        Id of the person for its detector.
    pos : Point
        Position in ``header.frame_id`` [m].
    reliability : float
        Score of the detection, from 0 to 1.
    covariance : list of float
        3 × 3 covariance matrix of the position [m²], row-major.
    initialization : int
        1 for a detection that may begin a track.
    """

    ros_order = ("header", "name", "object_id", "pos", "reliability", "covariance", "initialization")

    header: Header
    name: str
    object_id: str
    pos: Point
    reliability: float = 1.0
    covariance: Annotated[list[float], msgspec.Meta(extra={"length": 9})] = field(default_factory=lambda: [0.0] * 9)
    initialization: Int8 = 1


class PositionMeasurementArray(Message):
    """``people_msgs/PositionMeasurementArray``: the people in one measurement."""

    header: Header
    people: list[PositionMeasurement] = field(default_factory=list)
    cooccurrence: list[Float32] = field(default_factory=list)
