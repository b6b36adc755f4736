"""What localization says: the particles, where the robot is, and where odometry lies in the map."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput, TransformError
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo
from ppaas.messages.geometry_msgs import Pose, PoseArray, PoseWithCovariance, PoseWithCovarianceStamped
from ppaas.messages.std_msgs import Header, Time
from ppaas.nodes.frames import MAP
from ppaas.nodes.message_checks import finite_pose

_PLANAR = np.ix_((0, 1, 5), (0, 1, 5))
"""Where x, y and yaw stand in ROS's 6×6 covariance."""


@dataclass(frozen=True, slots=True)
class ParticleCloud:
    """The particles, by reference; they become ``geometry_msgs/PoseArray`` where they leave the home."""

    particles: NDArray[np.float64]
    stamp: float

    def to_message(self) -> PoseArray:
        """Return the message."""
        header = Header(stamp=Time.of(self.stamp), frame_id=MAP)
        return PoseArray(header, [Pose.of(Pose2D(*row)) for row in self.particles.tolist()])


def pose_message(pose: Pose2D, covariance: NDArray[np.float64], stamp: Time) -> PoseWithCovarianceStamped:
    """Return ``amcl_pose``.

    Parameters
    ----------
    pose : Pose2D
        In the map frame.
    covariance : (3, 3) array
        Of x [m], y [m], theta [rad].
    stamp : Time
        Of the scan that told it.
    """
    spread = np.zeros((6, 6))
    spread[_PLANAR] = covariance
    stamped = PoseWithCovariance(Pose.of(pose), spread.ravel().tolist())
    return PoseWithCovarianceStamped(Header(stamp=stamp, frame_id=MAP), stamped)


def read_initial_pose(message: PoseWithCovarianceStamped, info: GridInfo) -> tuple[Pose2D, NDArray[np.float64]]:
    """Return the pose of an ``initialpose`` and the (3, 3) covariance of its x, y and theta.

    Raises
    ------
    InvalidInput
        It is not finite, has the wrong size, or lies outside of the map.
    TransformError
        It is given in another frame than the map's.
    """
    if message.header.frame_id.lstrip("/") not in ("", MAP):
        raise TransformError(f"an initial pose is given in {MAP!r}, not in {message.header.frame_id!r}")
    pose = finite_pose(message.pose.pose, "an initial pose")
    if len(message.pose.covariance) != 36:
        raise InvalidInput(f"a covariance has 36 numbers, not {len(message.pose.covariance)}")
    if info.cell_of(pose.x, pose.y) is None:
        raise InvalidInput(
            f"an initial pose must lie in the map, whose {info.width * info.resolution:g} × "
            f"{info.height * info.resolution:g} m begin at ({info.origin.x:g}, {info.origin.y:g}); "
            f"({pose.x:g}, {pose.y:g}) does not"
        )
    return pose, np.array(message.pose.covariance).reshape(6, 6)[_PLANAR]
