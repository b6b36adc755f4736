"""``map_msgs``: changes of a map."""

from msgspec import Raw

from ppaas.messages.base.message import Int8, Message, UInt32
from ppaas.messages.base.std_msgs import Header


class OccupancyGridUpdate(Message):
    """``map_msgs/OccupancyGridUpdate``: new cells of a rectangle, whose lower-left cell is column ``x``, row ``y``.

    ``data`` may be encoded JSON, like the cells of a grid.
    """

    header: Header
    x: int
    y: int
    width: UInt32
    height: UInt32
    data: list[Int8] | Raw
