"""Publisher of where a robot is in its map: its pose, the entropy of the pose, and the transform of odometry."""

import msgspec

from ppaas.geometry import Pose2D
from ppaas.mapping.scan_tracker import Tracked
from ppaas.messages.base.std_msgs import Float64, Time
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.nodes import topics
from ppaas.nodes.amcl.messages import pose_message
from ppaas.nodes.base import Context
from ppaas.nodes.frames import MAP, FrameListener
from ppaas.nodes.grid_slam.messages import entropy_of, tracked_covariance
from ppaas.nodes.grid_slam.parameters import GridSlamParameters
from ppaas.transforms.planar import transform_message

JUST_AFTER = 1e-3
"""Time after the newest odometry of a transform that comes without a scan [s]: no two of tf have one stamp."""


class PosePublisher:
    """Publishes ``pose``, ``amcl_pose``, ``grid_slam/shared_pose``, ``entropy``, and ``tf`` map → odom.

    Parameters
    ----------
    context : Context
        Of the node.
    frames : FrameListener
        Frames of the robot.
    parameters : GridSlamParameters
    """

    def __init__(self, context: Context, frames: FrameListener, parameters: GridSlamParameters) -> None:
        self._context, self._frames, self._parameters = context, frames, parameters

    def publish(self, tracked: Tracked, robot: Pose2D, stamp: Time, *, shared: str | None) -> None:
        """Publish the pose of the robot at a tracked scan, and its entropy.

        Parameters
        ----------
        tracked : Tracked
        robot : Pose2D
            In the map frame.
        stamp : Time
            Stamp of the scan.
        shared : str, optional
            Name of the map frame for the other robots, if they know it, so that the pose is for them too.
        """
        covariance = tracked_covariance(tracked, robot)
        pose = pose_message(robot, covariance, stamp)
        for topic in (topics.SLAM_POSE, topics.AMCL_POSE):
            self._context.publish(topic.name, pose)
        if shared is not None:
            header = msgspec.structs.replace(pose.header, frame_id=shared)
            self._context.publish(topics.SHARED_POSE.name, msgspec.structs.replace(pose, header=header))
        self._context.publish(topics.ENTROPY.name, Float64(entropy_of(covariance)))

    def publish_jump(self, map_to_odom: Pose2D) -> None:
        """Publish the transform at once, without a scan: the map is in another frame."""
        newest = self._frames.newest()
        if newest is not None:
            self.publish_transform(map_to_odom, newest + JUST_AFTER)

    def publish_transform(self, map_to_odom: Pose2D, stamp: float) -> None:
        """Publish the pose of the odometry frame in the map frame, stamped ``transform_timeout`` after a time [s].

        Without odometry it is stamped with that time: it is then all of the robot's motion. Nothing is published if
        ``transform_publish_period`` is 0.
        """
        timeout = 0.0 if self._frames.is_without_odometry else self._parameters.transform_timeout
        self._publish(map_to_odom, stamp + timeout)

    def publish_start(self, map_to_odom: Pose2D) -> None:
        """Publish the transform of other odometry from its newest time on, for a robot whose first it is."""
        newest = self._frames.newest()
        if newest is not None:
            self._publish(map_to_odom, newest)

    def _publish(self, map_to_odom: Pose2D, stamp: float) -> None:
        if self._parameters.transform_publish_period > 0.0:
            correction = transform_message(MAP, self._frames.odom, map_to_odom, Time.of(stamp))
            self._context.publish(topics.TF.name, TFMessage([correction]))
