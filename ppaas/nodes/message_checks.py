"""Checks of messages from robots and other clients: types, valid poses, and fingerprints of equal messages."""

import math
from hashlib import blake2b
from typing import TypeVar

from ppaas.errors import InvalidInput, TransformError
from ppaas.geometry import FARTHEST, Pose2D
from ppaas.messages import encode
from ppaas.messages.base.message import Message
from ppaas.messages.geometry_msgs import Pose, PoseStamped
from ppaas.nodes.base import Payload
from ppaas.nodes.frames import MAP, unprefixed
from ppaas.transforms.planar import TransformTree

M = TypeVar("M", bound=Message)


def expect(message: Payload, cls: type[M]) -> M:
    """Return a payload as a message of the expected type.

    Raises
    ------
    InvalidInput
        It has another type.
    """
    if not isinstance(message, cls):
        raise InvalidInput(f"expected {cls.__name__}, got {type(message).__name__}")
    return message


def finite_pose(pose: Pose, what: str) -> Pose2D:
    """Return a pose in the plane; ``what`` names it in errors.

    Raises
    ------
    InvalidInput
        A number is not finite or too large for a position, or the orientation is not a quaternion.
    """
    p, q = pose.position, pose.orientation
    if not all(map(math.isfinite, (p.x, p.y, p.z, q.x, q.y, q.z, q.w))):
        raise InvalidInput(f"the position and orientation of {what} must be finite")
    if q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w < 1e-12:
        raise InvalidInput(f"the orientation of {what} is all zero; without rotation it has w = 1")
    if max(abs(p.x), abs(p.y)) > FARTHEST:
        raise InvalidInput(f"the position of {what}, ({p.x:.3g}, {p.y:.3g}), is too far away: send metres")
    return pose.planar()


def pose_in(tree: TransformTree, frame: str, stamped: PoseStamped, what: str) -> Pose2D:
    """Return a stamped pose in another frame, by the latest transforms; ``what`` names it in errors.

    Raises
    ------
    InvalidInput
        The pose has no frame, or is not finite.
    TransformError
        Its frame is unknown.
    """
    pose = finite_pose(stamped.pose, what)
    source = stamped.header.frame_id.lstrip("/")
    if not source:
        raise InvalidInput(f"{what} needs header.frame_id, the frame of its pose, for example {frame!r}")
    if source == frame or unprefixed(source) == frame == MAP:
        return pose
    try:
        return tree.lookup(frame, source) @ pose
    except TransformError as error:
        raise TransformError(f"{what} cannot be transformed into {frame!r}: {error}") from error


def fingerprint(topic: str, message: Message) -> str:
    """Return a hash of topic and content: equal for the same message, wherever it was decoded."""
    return blake2b(topic.encode() + b"\0" + encode(message), digest_size=8).hexdigest()
