"""``slam_toolbox``: services of a node that makes a map, and two of this project that exchange pose graphs."""

from enum import IntEnum
from typing import ClassVar

from msgspec import field

from ppaas.messages.base.message import Empty, Int8, Message, OwnMessage, ServiceType, UInt8
from ppaas.messages.base.std_msgs import String
from ppaas.messages.geometry_msgs import Pose2D


class SaveMapResult(IntEnum):
    """The ``result`` of ``slam_toolbox/SaveMap``; the definition has the misspelled name."""

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


class SerializePoseGraphResult(IntEnum):
    """The ``result`` of ``slam_toolbox/SerializePoseGraph``."""

    RESULT_SUCCESS = 0
    RESULT_FAILED_TO_WRITE_FILE = 255


class SerializePoseGraphRequest(Message):
    """``slam_toolbox/SerializePoseGraph`` request: the name of the file, without an ending."""

    filename: str = ""


class SerializePoseGraphResponse(Message):
    """``slam_toolbox/SerializePoseGraph`` response."""

    constants: ClassVar[type[IntEnum] | None] = SerializePoseGraphResult

    result: UInt8 = 0


class MatchType(IntEnum):
    """The ``match_type`` of ``slam_toolbox/DeserializePoseGraph``: the pose from which the map is continued."""

    UNSET = 0
    START_AT_FIRST_NODE = 1
    START_AT_GIVEN_POSE = 2
    LOCALIZE_AT_POSE = 3


class DeserializePoseGraphRequest(Message):
    """``slam_toolbox/DeserializePoseGraph`` request; the pose is the robot's, in the map frame."""

    constants: ClassVar[type[IntEnum] | None] = MatchType

    filename: str = ""
    match_type: Int8 = 0
    initial_pose: Pose2D = field(default_factory=Pose2D)


class PauseResponse(Message):
    """``slam_toolbox/Pause`` response: whether mapping is paused now."""

    status: bool = False


class GetPoseGraphRequest(Message):
    """``ppaas_msgs/GetPoseGraph`` request.

    Parameters
    ----------
    offset : int
        Offset in the file [bytes]: 0 takes a new one, and others continue it; −1 for the numbers alone.
    """

    offset: int = -1


class GetPoseGraphResponse(OwnMessage):
    """``ppaas_msgs/GetPoseGraph`` response.

    Parameters
    ----------
    data : str
        Bytes of the file from the offset, in base64; empty after its end.
    size : int
        Size of the file [bytes]; 0 without an offset.
    key_frames, edges, closures : int
        Numbers of key frames, of edges between them, and of those edges that are loop closures.
    resolution : float
        Edge of a cell of the map [m].
    min_pass_through : int
    occupancy_threshold : float
        Parameters of the map.
    scans : int
        Number of scans since the map was begun; of a joint map, of all its robots.
    frame : str
        Name of the map frame by its first key frame: equal for robots whose maps are joined. Empty if the map cannot
        be joined with others.
    do_loop_closing : bool
        Parameter of the map.
    """

    data: str = ""
    size: int = 0
    key_frames: int = 0
    edges: int = 0
    closures: int = 0
    resolution: float = 0.05
    min_pass_through: int = 2
    occupancy_threshold: float = 0.1
    scans: int = 0
    frame: str = ""
    do_loop_closing: bool = True


class UseJointMapRequest(OwnMessage):
    """``ppaas_msgs/UseJointMap`` request: a page of a joint map. After the last one the robot goes on with that map.

    Parameters
    ----------
    offset : int
        Offset of the page in the file [bytes]: 0 begins a file, and others continue it.
    size : int
        Size of the file [bytes].
    data : str
        The page, in base64.
    robots : list of str
        Robots whose maps were joined, for ``grid_slam/status``.
    """

    offset: int
    size: int
    data: str
    robots: list[str] = field(default_factory=list)


class UseJointMapResponse(OwnMessage):
    """``ppaas_msgs/UseJointMap`` response.

    Parameters
    ----------
    key_frames : int
        Number of key frames of the map that the robot goes on with; 0 before the last page.
    motion : Pose2D
        Motion of the pose of the robot in the map frame.
    """

    key_frames: int = 0
    motion: Pose2D = field(default_factory=Pose2D)


SaveMap = ServiceType("slam_toolbox/SaveMap", SaveMapRequest, SaveMapResponse)
Pause = ServiceType("slam_toolbox/Pause", Empty, PauseResponse)
Clear = ServiceType("slam_toolbox/Clear", Empty, Empty)

SerializePoseGraph = ServiceType(
    "slam_toolbox/SerializePoseGraph", SerializePoseGraphRequest, SerializePoseGraphResponse
)
DeserializePoseGraph = ServiceType("slam_toolbox/DeserializePoseGraph", DeserializePoseGraphRequest, Empty)
GetPoseGraph = ServiceType("ppaas_msgs/GetPoseGraph", GetPoseGraphRequest, GetPoseGraphResponse)
UseJointMap = ServiceType("ppaas_msgs/UseJointMap", UseJointMapRequest, UseJointMapResponse)

SERVICES = (SaveMap, Pause, Clear, SerializePoseGraph, DeserializePoseGraph, GetPoseGraph, UseJointMap)
