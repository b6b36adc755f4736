"""``octomap_msgs``: 3D maps as octrees."""

from typing import ClassVar

from msgspec import Raw, field

from ppaas.messages.base.message import Empty, Int8, Message, OwnMessage, ServiceType
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.geometry_msgs import Point


class Octomap(Message):
    """``octomap_msgs/Octomap``.

    Parameters
    ----------
    binary : bool
        Whether the voxels are only free or occupied (``.bt``); else they have log-odds (``.ot``).
    id : str
        Type of the octree, ``OcTree``.
    resolution : float
        Edge of the finest voxels [m].
    data : list of int
        Nodes of the octree, as in a file after its header, each byte as int8. May be encoded JSON.
    """

    ros_order: ClassVar[tuple[str, ...]] = ("header", "binary", "id", "resolution", "data")

    header: Header
    binary: bool
    id: str
    resolution: float
    data: list[Int8] | Raw


class GetOctomapResponse(Message):
    """``octomap_msgs/GetOctomap`` response."""

    map: Octomap = field()


class BoundingBoxQueryRequest(Message):
    """``octomap_msgs/BoundingBoxQuery`` request: opposite corners of a box in the map frame [m]."""

    min: Point
    max: Point


class GetOctomapFileRequest(Message):
    """``ppaas_msgs/GetOctomapFile`` request.

    Parameters
    ----------
    offset : int
        Offset in the file [bytes]: 0 takes a new one, and others continue it.
    before, after : list of float
        Poses of the robot at key frames now, and where they are to be in a new file, which moves with them: x, y [m],
        theta [rad] one after the other. Without them, the file has the current map.
    """

    offset: int = 0
    before: list[float] = field(default_factory=list)
    after: list[float] = field(default_factory=list)


class GetOctomapFileResponse(OwnMessage):
    """``ppaas_msgs/GetOctomapFile`` response.

    Parameters
    ----------
    data : str
        Bytes of the file (``.bt``) from the offset, in base64; empty after its end.
    size : int
        Size of the file [bytes]; 0 if the map is empty.
    """

    data: str = ""
    size: int = 0


GetOctomap = ServiceType("octomap_msgs/GetOctomap", Empty, GetOctomapResponse)
BoundingBoxQuery = ServiceType("octomap_msgs/BoundingBoxQuery", BoundingBoxQueryRequest, Empty)
GetOctomapFile = ServiceType("ppaas_msgs/GetOctomapFile", GetOctomapFileRequest, GetOctomapFileResponse)

SERVICES = (GetOctomap, BoundingBoxQuery, GetOctomapFile)
