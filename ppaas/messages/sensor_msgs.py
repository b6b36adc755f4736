"""``sensor_msgs``."""

from msgspec import field

from ppaas.messages.message import Float32, Message
from ppaas.messages.std_msgs import Header


class LaserScan(Message):
    """``sensor_msgs/LaserScan``.

    Angles in radians, ranges in metres, counter-clockwise about z of the sensor's frame. A range outside
    [range_min, range_max], or null, is no reading.
    """

    header: Header
    angle_min: Float32
    angle_max: Float32
    angle_increment: Float32
    range_min: Float32
    range_max: Float32
    ranges: list[Float32 | None]
    time_increment: Float32 = 0.0
    scan_time: Float32 = 0.0
    intensities: list[Float32 | None] = field(default_factory=list)
