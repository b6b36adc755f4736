"""Poses of a robot at the times of its measurements: where people are tracked, and where the robot is on the map."""

import math
from collections import deque

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import TransformError
from ppaas.geometry import Pose2D
from ppaas.messages.geometry_msgs import Pose, PoseWithCovariance, PoseWithCovarianceStamped
from ppaas.nodes.frames import MAP, FrameListener
from ppaas.nodes.message_checks import finite_pose
from ppaas.transforms.planar import tf_time
from ppaas.transforms.spatial import Rigid, matrix_of

KEPT = 100
"""Number of covariances of the pose that are stored."""

DEFAULT_SIGMA = 0.1, 0.05
"""Standard deviations of the pose of a robot that publishes no covariance [m, rad]."""

GROWTH = 0.05
"""Growth of the standard deviation since localization last gave it [m/s]."""

LONGEST_SILENCE = 3.0
"""Time without localization after which the robot's place on the map is unknown [s]."""


class RobotPoses:
    """Poses of a robot over the last seconds.

    Parameters
    ----------
    frames : FrameListener
        Frames of the robot.
    """

    def __init__(self, frames: FrameListener) -> None:
        self._frames = frames
        self._covariances: deque[tuple[float, list[float]]] = deque(maxlen=KEPT)
        self._alone = False

    def hear(self, message: PoseWithCovarianceStamped, now: float) -> None:
        """Note a pose that localization publishes; ``now`` is the meaning of a stamp of zero [s].

        It is also the pose of a robot without odometry.

        Raises
        ------
        InvalidInput
            A number is not finite.
        """
        pose = finite_pose(message.pose.pose, "the pose of the robot")
        stamp = tf_time(message.header.stamp) or round(now, 6)
        if all(map(math.isfinite, message.pose.covariance)):
            if self._covariances and stamp < self._covariances[-1][0]:
                self._covariances.clear()
            self._covariances.append((stamp, message.pose.covariance))
        tree, base = self._frames.tree, self._frames.base
        parents = tree.common_time(self._frames.odom, base), tree.common_time(MAP, base)
        if parents[0] is None and (parents[1] is None or self._alone):
            tree.set(MAP, base, pose, stamp)
            self._alone = True

    @property
    def frame(self) -> str:
        """Frame in which people are tracked: the odometry's, or the map for robots without odometry."""
        return self._frames.odom if self._frames.newest() is not None else MAP

    def newest(self) -> float | None:
        """Return the time up to which the pose of the robot in `frame` is known [s]; None if it is not known at all."""
        odometry = self._frames.newest()
        return odometry if odometry is not None else self._frames.tree.common_time(MAP, self._frames.base)

    def robot(self, stamp: float) -> Pose2D:
        """Return the pose of the robot in `frame` at a time [s]; raises ``TransformError`` if it is not known."""
        return self._frames.tree.lookup(self.frame, self._frames.base, stamp)

    def in_map(self, stamp: float, now: float) -> PoseWithCovariance:
        """Return the pose of the robot on the map at a time.

        Parameters
        ----------
        stamp : float
            Time [s].
        now : float
            Time by the executor's clock [s].

        Raises
        ------
        TransformError
            The robot is not localized; the text says for how long.
        """
        silence = self._frames.localization_silence(now)
        if self.frame != MAP and silence > LONGEST_SILENCE:
            since = f"for {silence:.1f} s" if math.isfinite(silence) else "yet"
            raise TransformError(f"the robot is not localized {since}: see amcl/status")
        covariance, age = self._covariance(stamp)
        return PoseWithCovariance(Pose.of(self._planar(stamp)), _grown(covariance, age))

    def _planar(self, stamp: float) -> Pose2D:
        if self.frame == MAP:
            return self._frames.in_map(stamp)
        try:
            return self._frames.in_map(stamp)
        except TransformError:
            # Localization lags behind odometry; its newest correction still holds.
            return self._frames.tree.lookup(MAP, self._frames.odom) @ self._frames.odometry(stamp)

    def _covariance(self, stamp: float) -> tuple[list[float] | None, float]:
        """Return the covariance nearest in time, and the time to it [s]."""
        if not self._covariances:
            return None, 0.0
        at, covariance = min(self._covariances, key=lambda each: abs(each[0] - stamp))
        return covariance, abs(at - stamp)

    def to_base(self, frame: str, stamp: float) -> NDArray[np.float64]:
        """Return the (4, 4) matrix from a frame to the robot's body at a time [s].

        Raises
        ------
        TransformError
            The frame is unknown, or not connected with the robot's body at that time.
        """
        base = self._frames.base
        if not frame or frame == base:
            return np.eye(4)
        if self._frames.names.is_map(frame):
            return matrix_of(Rigid.planar(self._planar(stamp).inverse()))
        if frame == self._frames.odom:
            return matrix_of(Rigid.planar(self._frames.odometry(stamp).inverse()))
        return matrix_of(self._frames.mount(frame))


def _grown(covariance: list[float] | None, age: float) -> list[float]:
    """Return a covariance (row-major 6 × 6) after a time without localization [s]; the default one without any."""
    if covariance is None:
        grown = [0.0] * 36
        grown[0] = grown[7] = DEFAULT_SIGMA[0] ** 2
        grown[35] = DEFAULT_SIGMA[1] ** 2
    else:
        grown = list(covariance)
    for axis in (0, 7):
        grown[axis] = max(grown[axis], 0.0) + (GROWTH * age) ** 2
    return grown
