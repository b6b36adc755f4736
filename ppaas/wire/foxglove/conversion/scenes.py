"""Scenes of the 3D panel: bodies of robots, people, scans, transforms and poses in Foxglove's own schemas."""

import math
from collections.abc import Callable, Sequence
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
from ppaas.messages.people_msgs import People, Person
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.wire.foxglove.answers import Schema
from ppaas.wire.foxglove.conversion.base import Conversion, SharedFrames
from ppaas.wire.foxglove.conversion.schemas import protobuf

# -- messages that the 3D panel draws, in Foxglove's own schemas -------------------------------------------------------

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


# -- scenes of the 3D panel --------------------------------------------------------------------------------------------

SCENE: Final[Schema] = protobuf(sdk.SceneUpdate)

BODY: Final = "model"
"""Topic of the body of a robot."""

CORNERS: Final = 32
"""Corners of a round outline."""

PERSON_RADIUS, PERSON_HEIGHT = 0.25, 1.7
"""Size at which a person is drawn [m]."""

PERSON_LIFETIME: Final = sdk.Duration(2)
"""Time for which a person is drawn who is not seen any more [s]."""

_BLUE: Final = sdk.Color(r=0.1, g=0.45, b=0.9, a=1.0)
_ORANGE: Final = sdk.Color(r=0.95, g=0.55, b=0.1, a=0.7)
_LABEL: Final = sdk.Color(r=0.5, g=0.5, b=0.5, a=1.0)


def body(frame: str, name: str, outline: Sequence[tuple[float, float]], radius: float, height: float) -> bytes:
    """Return the scene of a robot: its outline, an arrow ahead and its name, which move with its frame.

    Parameters
    ----------
    frame : str
        Frame of the robot's body, as it is named in the tree.
    name : str
    outline : sequence of (x, y)
        Corners in that frame [m]; empty for a circle.
    radius : float
        Radius of the circle [m].
    height : float
        Height of the name [m].
    """
    corners = outline or [
        (radius * math.cos(2.0 * math.pi * i / CORNERS), radius * math.sin(2.0 * math.pi * i / CORNERS))
        for i in range(CORNERS)
    ]
    line = sdk.LinePrimitive(
        type=sdk.LinePrimitiveLineType.LineLoop,
        pose=_at(0.0, 0.0, 0.0),
        thickness=0.03,
        points=[sdk.Point3(x=x, y=y, z=0.02) for x, y in corners],
        color=_BLUE,
    )
    length = max((x for x, _ in corners), default=radius)
    arrow = sdk.ArrowPrimitive(
        pose=_at(0.0, 0.0, 0.05),
        shaft_length=0.6 * length,
        shaft_diameter=0.04,
        head_length=0.4 * length,
        head_diameter=0.1,
        color=_BLUE,
    )
    entity = sdk.SceneEntity(
        frame_id=frame,
        id=name,
        frame_locked=True,
        lines=[line],
        arrows=[arrow],
        texts=[_label(name, height + 0.2)],
    )
    return sdk.SceneUpdate(entities=[entity]).encode()


def _people(message: People, frames: SharedFrames) -> Encodable:
    header = message.header
    frame, stamp = frames.shared(header.frame_id), stamp_of(header.stamp)
    return sdk.SceneUpdate(entities=[_person(person, frames.robot, frame, stamp) for person in message.people])


def _person(person: Person, robot: str, frame: str, stamp: sdk.Timestamp) -> sdk.SceneEntity:
    x, y = person.position.x, person.position.y
    return sdk.SceneEntity(
        timestamp=stamp,
        frame_id=frame,
        id=f"{robot}/{person.name}",
        lifetime=PERSON_LIFETIME,
        cylinders=[
            sdk.CylinderPrimitive(
                pose=_at(x, y, PERSON_HEIGHT / 2.0),
                size=sdk.Vector3(x=2.0 * PERSON_RADIUS, y=2.0 * PERSON_RADIUS, z=PERSON_HEIGHT),
                bottom_scale=1.0,
                top_scale=1.0,
                color=_ORANGE,
            )
        ],
        texts=[_label(person.name, PERSON_HEIGHT + 0.2, x, y)],
    )


def _label(text: str, height: float, x: float = 0.0, y: float = 0.0) -> sdk.TextPrimitive:
    return sdk.TextPrimitive(pose=_at(x, y, height), billboard=True, font_size=0.2, color=_LABEL, text=text)


def _at(x: float, y: float, z: float) -> sdk.Pose:
    return sdk.Pose(position=sdk.Vector3(x=x, y=y, z=z), orientation=sdk.Quaternion(w=1.0))


PEOPLE: Final = drawn(sdk.SceneUpdate, People, _people)
"""Conversion of people to a scene."""
