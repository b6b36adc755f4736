"""``slam_toolbox``: services of a node that makes a map."""

from enum import IntEnum
from typing import ClassVar

from msgspec import field

from ppaas.messages.message import Empty, Message, ServiceType, UInt8
from ppaas.messages.std_msgs import String


class SaveMapResult(IntEnum):
    """The ``result`` of ``slam_toolbox/SaveMap``; the misspelled name is that of the definition."""

    RESULT_SUCCESS = 0
    RESULT_NO_MAP_RECEIEVD = 1
    RESULT_UNDEFINED_FAILURE = 255


class SaveMapRequest(Message):
    """``slam_toolbox/SaveMap`` request: the name of the map."""

    name: String = field(default_factory=lambda: String(""))


class SaveMapResponse(Message):
    """``slam_toolbox/SaveMap`` response."""

    constants: ClassVar[type[IntEnum] | None] = SaveMapResult

    result: UInt8 = 0


class PauseResponse(Message):
    """``slam_toolbox/Pause`` response: whether mapping is paused now."""

    status: bool = False


SaveMap = ServiceType("slam_toolbox/SaveMap", SaveMapRequest, SaveMapResponse)
Pause = ServiceType("slam_toolbox/Pause", Empty, PauseResponse)
Clear = ServiceType("slam_toolbox/Clear", Empty, Empty)

SERVICES = (SaveMap, Pause, Clear)
