"""Checks of what robots send: poses that mean something, or an error that says what to do."""

import math
from typing import TypeVar

from ppaas.errors import InvalidInput, TransformError
from ppaas.geometry import Pose2D
from ppaas.messages.geometry_msgs import Pose, PoseStamped
from ppaas.messages.message import Message
from ppaas.nodes.base import Payload
from ppaas.transforms.planar import TransformTree

M = TypeVar("M", bound=Message)


def expect(message: Payload, cls: type[M]) -> M:
    """Return a payload as the message it must be.

    Raises
    ------
    InvalidInput
        It is of another type.
    """
    if not isinstance(message, cls):
        raise InvalidInput(f"expected {cls.__name__}, got {type(message).__name__}")
    return message


def finite_pose(pose: Pose, what: str) -> Pose2D:
    """Return a pose in the plane.

    Raises
    ------
    InvalidInput
        A number is not finite, or the orientation is no quaternion.
    """
    p, q = pose.position, pose.orientation
    if not all(map(math.isfinite, (p.x, p.y, p.z, q.x, q.y, q.z, q.w))):
        raise InvalidInput(f"{what} must have finite numbers for its position and orientation")
    if q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w < 1e-12:
        raise InvalidInput(f"the orientation of {what} is all zero; no turn at all is w = 1")
    return pose.planar()


def pose_in(tree: TransformTree, frame: str, stamped: PoseStamped, what: str) -> Pose2D:
    """Return a stamped pose in another frame, by the latest transforms.

    Raises
    ------
    InvalidInput
        It has no frame, or is not finite.
    TransformError
        Its frame is unknown.
    """
    pose = finite_pose(stamped.pose, what)
    source = stamped.header.frame_id.lstrip("/")
    if not source:
        raise InvalidInput(f"{what} needs header.frame_id: the frame its pose is given in, such as {frame!r}")
    if source == frame:
        return pose
    try:
        return tree.lookup(frame, source) @ pose
    except TransformError as error:
        raise TransformError(f"{what} cannot be transformed into {frame!r}: {error}") from error
