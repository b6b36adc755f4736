"""Mappings: what a map is made of, and from which mapping continues."""

from dataclasses import dataclass, field

import msgspec

from ppaas.decoding import from_msgpack
from ppaas.errors import InvalidGraph, InvalidInput
from ppaas.geometry import Pose2D
from ppaas.mapping.closures.closure import Closure
from ppaas.mapping.graph.pose_graph import PoseGraph
from ppaas.mapping.key_frames import KeyFrames
from ppaas.mapping.laser_geometry import LaserGeometry
from ppaas.mapping.serialization.records import RecordKind, pack_record
from ppaas.planar_poses import PoseArray


@dataclass(frozen=True, slots=True)
class Mapping:
    """Key frames of one laser, with their pose graph.

    Parameters
    ----------
    frames : KeyFrames
    graph : PoseGraph
        One node per key frame, at its pose. A key frame without an odometry edge from the one before starts a chain,
        as after the merge of two mappings.
    laser_frame : str
        Name of the frame of the laser.
    waiting : list of Closure
        Closures that wait for others to agree with; part of a log only.
    """

    frames: KeyFrames
    graph: PoseGraph
    laser_frame: str = ""
    waiting: list[Closure] = field(default_factory=list)

    def move(self, poses: PoseArray) -> None:
        """Move the key frames and the nodes of the graph to poses (k, 3) of the laser in the map frame."""
        self.frames.poses[:] = poses
        self.graph.move_nodes(poses)


class LaserRecord(msgspec.Struct):
    """Payload of a record of a laser, as MessagePack; see `LaserGeometry`."""

    frame: str
    angle_min: float
    angle_increment: float
    beams: int
    mount: tuple[float, float, float]
    time_increment: float
    stamped_at: float

    @property
    def geometry(self) -> LaserGeometry:
        """Geometry of the laser; raises ``InvalidGraph`` if it is not one."""
        try:
            return LaserGeometry(
                self.angle_min, self.angle_increment, self.beams, Pose2D(*self.mount), self.time_increment,
                self.stamped_at,
            )  # fmt: skip
        except InvalidInput as error:
            raise InvalidGraph(f"the pose graph has an impossible laser: {error}") from error


def pack_laser(geometry: LaserGeometry, frame: str) -> bytes:
    """Return the record of a laser."""
    record = LaserRecord(
        frame, geometry.angle_min, geometry.angle_increment, geometry.beams,
        (geometry.mount.x, geometry.mount.y, geometry.mount.theta), geometry.time_increment, geometry.stamped_at,
    )  # fmt: skip
    return pack_record(RecordKind.LASER, msgspec.msgpack.encode(record))


def unpack_laser(payload: memoryview | bytes) -> LaserRecord:
    """Return the laser of a record; raises ``InvalidGraph`` if it is none."""
    try:
        return from_msgpack(payload, LaserRecord)
    except msgspec.DecodeError as error:
        raise InvalidGraph(f"the pose graph has a laser that cannot be read: {error}") from error
