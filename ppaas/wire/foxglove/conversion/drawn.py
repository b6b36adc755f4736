"""Messages that the 3D panel draws, in Foxglove's own schemas: scans, transforms, poses.

They come often, and ``foxglove-sdk`` encodes them in a fraction of the time of CDR.
"""

import math
from collections.abc import Callable
from typing import Any, Final, Protocol, TypeVar

import msgspec
import numpy as np
from foxglove import messages as sdk

from ppaas.decoding import from_json
from ppaas.errors import MalformedMessage
from ppaas.messages import decode
from ppaas.messages.base.message import Message
from ppaas.messages.base.std_msgs import Time
from ppaas.messages.geometry_msgs import Pose, PoseArray, PoseStamped
from ppaas.messages.nav_msgs import Path
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.wire.foxglove.conversion.base import Conversion
from ppaas.wire.foxglove.conversion.frames import SharedFrames
from ppaas.wire.foxglove.conversion.schemas import protobuf

M = TypeVar("M", bound=Message)

ORIGIN: Final = sdk.Pose(position=sdk.Vector3(), orientation=sdk.Quaternion(w=1.0))


class Encodable(Protocol):
    """Message of ``foxglove-sdk``."""

    def encode(self) -> bytes:
        """Return it as protobuf."""
        ...


def drawn(kind: Any, cls: type[M], draw: Callable[[M, SharedFrames], Encodable]) -> Conversion:
    """Return the conversion of a type by a function.

    Parameters
    ----------
    kind : type
        Type of ``foxglove-sdk``.
    cls : type of Message
    draw : callable
        Returns the message for Foxglove.
    """

    def convert(payload: bytes, frames: SharedFrames) -> bytes:
        try:
            return draw(decode(cls, payload), frames).encode()
        except (OverflowError, ValueError, TypeError, msgspec.DecodeError) as error:
            raise MalformedMessage(f"not a {cls.__name__} that can be shown: {error}") from error

    return Conversion(protobuf(kind), convert)


def stamp_of(time: Time) -> sdk.Timestamp:
    """Return a stamp."""
    return sdk.Timestamp(time.secs, time.nsecs)


def pose_of(pose: Pose) -> sdk.Pose:
    """Return a pose in space."""
    at, q = pose.position, pose.orientation
    return sdk.Pose(
        position=sdk.Vector3(x=at.x, y=at.y, z=at.z), orientation=sdk.Quaternion(x=q.x, y=q.y, z=q.z, w=q.w)
    )


def _scan(scan: LaserScan, frames: SharedFrames) -> Encodable:
    ranges = np.array(scan.ranges, np.float64)
    ranges[(ranges < scan.range_min) | (ranges > scan.range_max)] = math.nan  # no readings, which the schema lacks
    return sdk.LaserScan(
        timestamp=stamp_of(scan.header.stamp),
        frame_id=frames.shared(scan.header.frame_id),
        pose=ORIGIN,
        start_angle=scan.angle_min,
        end_angle=scan.angle_min + scan.angle_increment * max(len(scan.ranges) - 1, 0),
        ranges=ranges.tolist(),
        intensities=np.array(scan.intensities, np.float64).tolist() if scan.intensities else [],
    )


def _transforms(message: TFMessage, frames: SharedFrames) -> Encodable:
    listed = []
    for one in message.transforms:
        at, q = one.transform.translation, one.transform.rotation
        listed.append(
            sdk.FrameTransform(
                timestamp=stamp_of(one.header.stamp),
                parent_frame_id=frames.shared(one.header.frame_id),
                child_frame_id=frames.shared(one.child_frame_id),
                translation=sdk.Vector3(x=at.x, y=at.y, z=at.z),
                rotation=sdk.Quaternion(x=q.x, y=q.y, z=q.z, w=q.w),
            )
        )
    return sdk.FrameTransforms(transforms=listed)


def _pose(message: PoseStamped, frames: SharedFrames) -> Encodable:
    return sdk.PoseInFrame(
        timestamp=stamp_of(message.header.stamp),
        frame_id=frames.shared(message.header.frame_id),
        pose=pose_of(message.pose),
    )


def _poses(message: PoseArray, frames: SharedFrames) -> Encodable:
    return sdk.PosesInFrame(
        timestamp=stamp_of(message.header.stamp),
        frame_id=frames.shared(message.header.frame_id),
        poses=list(map(pose_of, message.poses)),
    )


def _path(message: Path, frames: SharedFrames) -> Encodable:
    poses = message.poses
    listed = from_json(poses, list[PoseStamped]) if isinstance(poses, msgspec.Raw) else poses
    return sdk.PosesInFrame(
        timestamp=stamp_of(message.header.stamp),
        frame_id=frames.shared(message.header.frame_id),
        poses=[pose_of(one.pose) for one in listed],
    )


DRAWN: Final = {
    "sensor_msgs/LaserScan": drawn(sdk.LaserScan, LaserScan, _scan),
    "tf2_msgs/TFMessage": drawn(sdk.FrameTransforms, TFMessage, _transforms),
    "geometry_msgs/PoseStamped": drawn(sdk.PoseInFrame, PoseStamped, _pose),
    "geometry_msgs/PoseArray": drawn(sdk.PosesInFrame, PoseArray, _poses),
    "nav_msgs/Path": drawn(sdk.PosesInFrame, Path, _path),
}
"""Conversions by type, as spelled in ROS 1."""
