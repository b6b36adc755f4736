"""``people_msgs``: positions and velocities of people."""

from msgspec import field

from ppaas.messages.geometry_msgs import Point
from ppaas.messages.message import Message
from ppaas.messages.std_msgs import Header


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
