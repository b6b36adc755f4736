"""Messages of ``octomap_server``: octrees as ``octomap_msgs/Octomap``."""

from dataclasses import dataclass

import msgspec
import numpy as np

from ppaas.errors import InvalidInput
from ppaas.maps.octomap import octomap_nodes
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.octomap_msgs import Octomap
from ppaas.nodes.frames import MAP
from ppaas.planar_poses import PoseArray

# Text of a byte as int8, padded to five characters, so that one look-up yields the text of a whole octree.
_TEXT = np.array([f"{value},".ljust(5).encode() for value in (*range(128), *range(-128, 0))], "S5")


@dataclass(frozen=True, slots=True)
class OctomapFile:
    """OctoMap file, converted to a message only when it leaves the process.

    Parameters
    ----------
    data : bytes
        The file.
    binary : bool
        Whether it is a binary file (``.bt``).
    resolution : float
        Edge of the finest voxels [m].
    stamp : Time
    """

    data: bytes
    binary: bool
    resolution: float
    stamp: Time

    def to_message(self) -> Octomap:
        """Return ``octomap_msgs/Octomap``."""
        nodes = np.frombuffer(octomap_nodes(self.data), np.uint8)
        text = np.take(_TEXT, nodes).tobytes().translate(None, b" ")
        data = msgspec.Raw(b"[%b]" % text[:-1])
        return Octomap(Header(stamp=self.stamp, frame_id=MAP), self.binary, "OcTree", self.resolution, data)


def poses_of(numbers: list[float], name: str) -> PoseArray:
    """Return the poses (k, 3) in a field of a request; raises ``InvalidInput`` if they are none."""
    poses = np.array(numbers, np.float64)
    if len(poses) % 3 or not np.isfinite(poses).all():
        raise InvalidInput(f"{name} must be poses: three finite numbers for each key frame")
    return poses.reshape(-1, 3)
