"""Messages of localization: particle cloud, pose with covariance, and initial pose."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput, TransformError
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Pose, PoseArray, PoseWithCovariance, PoseWithCovarianceStamped
from ppaas.nodes.frames import MAP, FrameNames
from ppaas.nodes.message_checks import finite_pose

_PLANAR = np.ix_((0, 1, 5), (0, 1, 5))
"""Indices of x, y and yaw in ROS's 6×6 covariance."""


@dataclass(frozen=True, slots=True)
class ParticleCloud:
    """Reference to the particles; converted to ``geometry_msgs/PoseArray`` only when they leave the executor."""

    particles: NDArray[np.float64]
    stamp: float

    def to_message(self) -> PoseArray:
        """Return the message."""
        header = Header(stamp=Time.of(self.stamp), frame_id=MAP)
        return PoseArray(header, [Pose.of(Pose2D(*row)) for row in self.particles.tolist()])


def pose_message(pose: Pose2D, covariance: NDArray[np.float64], stamp: Time) -> PoseWithCovarianceStamped:
    """Return the message for ``amcl_pose``.

    Parameters
    ----------
    pose : Pose2D
        In the map frame.
    covariance : (3, 3) array
        Covariance of x [m], y [m], theta [rad].
    stamp : Time
        Stamp of the scan from which it was estimated.
    """
    spread = np.zeros((6, 6))
    spread[_PLANAR] = covariance
    stamped = PoseWithCovariance(Pose.of(pose), spread.ravel().tolist())
    return PoseWithCovarianceStamped(Header(stamp=stamp, frame_id=MAP), stamped)


def read_initial_pose(
    message: PoseWithCovarianceStamped, info: GridInfo, names: FrameNames
) -> tuple[Pose2D, NDArray[np.float64]]:
    """Return the pose of an ``initialpose`` and the (3, 3) covariance of its x, y and theta.

    Raises
    ------
    InvalidInput
        A number is not finite, the covariance has the wrong size, or the pose is outside the map.
    TransformError
        Its frame is not the map frame.
    """
    if not names.is_map(message.header.frame_id):
        raise TransformError(f"an initial pose must be in frame {MAP!r}, not {message.header.frame_id!r}")
    pose = finite_pose(message.pose.pose, "an initial pose")
    if len(message.pose.covariance) != 36:
        raise InvalidInput(f"a covariance must have 36 numbers, not {len(message.pose.covariance)}")
    if info.cell_of(pose.x, pose.y) is None:
        raise InvalidInput(
            f"the initial pose ({pose.x:g}, {pose.y:g}) is outside the map, which covers "
            f"{info.width * info.resolution:g} × {info.height * info.resolution:g} m from "
            f"({info.origin.x:g}, {info.origin.y:g})"
        )
    return pose, np.array(message.pose.covariance).reshape(6, 6)[_PLANAR]
