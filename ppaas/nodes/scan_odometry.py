"""Odometry of a robot that has none: it stands still in a frame that mapping moves by the scans alone."""

import logging

from ppaas.geometry import Pose2D
from ppaas.messages.base.std_msgs import Time
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.nodes.base import Context
from ppaas.nodes.frames import SCAN_ODOM, FrameListener, is_scan_odometry
from ppaas.nodes.topics import TF
from ppaas.transforms.planar import tf_time, transform_message

logger = logging.getLogger(__name__)

PATIENCE, SCANS = 5.0, 10
"""Time that scans come without any odometry [s], and their number, from which on a map is made of scans alone."""

AT_BASE = Pose2D(0.0, 0.0, 0.0)


class ScanOdometry:
    """Publishes ``tf`` `SCAN_ODOM` → robot, which does not change, with each scan of a robot without odometry.

    It begins if `SCANS` scans come during `PATIENCE`, none of them more than `PATIENCE` after the one before, no
    message comes on ``odom`` meanwhile, and no transform moves the robot or a frame that is not of its body. It ends
    with the first transform that moves the robot. If no transform connects the laser with the robot, the
    highest frame above the laser is taken to be the robot; once there is odometry, a transform has to connect them.

    Parameters
    ----------
    context : Context
        Of the node.
    frames : FrameListener
        Frames of the robot.

    Attributes
    ----------
    is_active : bool
        Whether it is the odometry of the robot.
    """

    def __init__(self, context: Context, frames: FrameListener) -> None:
        self.is_active = False
        self._context, self._frames = context, frames
        self._first_at = self._last_at = self._odometry_at = float("-inf")
        self._count = 0
        self._still = AT_BASE
        self._laser = self._assumed = ""

    def resume(self) -> None:
        """Go on at once, as after a restart of the container."""
        self.is_active = True

    def odometry_came(self) -> None:
        """Note a message of the odometry, whether it can be used or not."""
        self._odometry_at = self._context.elapsed()

    def scan_came(self, scan: LaserScan, waiting: float | None) -> None:
        """Begin if a robot has no odometry, and publish where it is at a scan.

        Parameters
        ----------
        scan : LaserScan
        waiting : float, optional
            Stamp of the oldest scan that waits for odometry [s].
        """
        now = self._context.elapsed()
        if now - self._last_at > PATIENCE:
            self._first_at, self._count = now, 0
        self._last_at, self._count = now, self._count + 1
        if not self.is_active and self._is_missing(now):
            logger.warning("no odometry has come: the map is made of the scans alone, and the robot is not driven")
            self.is_active = True
            if waiting:
                self._publish(waiting, scan)
        if self.is_active:
            self._publish(tf_time(scan.header.stamp) or self._context.now(), scan)

    def _is_missing(self, now: float) -> bool:
        if now - self._first_at < PATIENCE or self._count < SCANS or now - self._odometry_at <= PATIENCE:
            return False
        return self._frames.newest() is None and not self._frames.tree.moving_apart_from(self._frames.base)

    def _publish(self, stamp: float, scan: LaserScan) -> None:
        frames, moment, laser = self._frames, Time.of(stamp), scan.header.frame_id.lstrip("/")
        transforms = [transform_message(SCAN_ODOM, frames.root(frames.base, SCAN_ODOM), AT_BASE, moment)]
        if not self._assumed and not frames.knows(laser):
            self._laser, self._assumed = laser, frames.root(laser)
            logger.warning(
                "no transform connects laser %r with the robot: %r is taken to be %r", laser, self._assumed, frames.base
            )
        if self._assumed:
            transforms.append(transform_message(frames.base, self._assumed, AT_BASE, moment))
        message = TFMessage(transforms)
        frames.hear(TF.name, message, self._context.elapsed())  # at once: the scan is not to wait
        self._still = frames.odometry()
        self._context.publish(TF.name, message)

    def heard(self, message: TFMessage) -> Pose2D | None:
        """Note transforms that the frames have heard. If they are odometry, end, and return the pose until then.

        Returns
        -------
        Pose2D or None
            Pose of the robot in `SCAN_ODOM`, if another odometry takes its place now.
        """
        if is_scan_odometry(message):
            return None
        if self._assumed and any(each.child_frame_id.lstrip("/") == self._assumed for each in message.transforms):
            self._assumed = ""
        if not self.is_active or self._frames.is_without_odometry or self._frames.newest() is None:
            return None
        logger.warning("odometry comes now, in frame %r: mapping goes on with it", self._frames.odom)
        self.is_active = False
        return self._still

    def assumes(self, laser: str) -> bool:
        """Return whether the mount of a laser is only assumed, because no transform connects it with the robot."""
        return bool(self._assumed) and laser == self._laser
