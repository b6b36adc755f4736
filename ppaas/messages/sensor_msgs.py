"""``sensor_msgs``."""

from msgspec import field

from ppaas.messages.message import Message
from ppaas.messages.std_msgs import Header


class LaserScan(Message):
    """``sensor_msgs/LaserScan``.

    Angles in radians, ranges in metres, counter-clockwise about z of the sensor's frame. A range outside
    [range_min, range_max], or null, is no reading.
    """

    header: Header
    angle_min: float
    angle_max: float
    angle_increment: float
    range_min: float
    range_max: float
    ranges: list[float | None]
    time_increment: float = 0.0
    scan_time: float = 0.0
    intensities: list[float | None] = field(default_factory=list)
