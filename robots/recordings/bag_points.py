"""Points of the depth images and point clouds of a bag, in the frame of the robot, for a 3D map of the drive."""

from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput
from ppaas.mapping.volume.depth_points import points_of_depth
from ppaas.mapping.volume.registration import apply
from ppaas.messages.base.std_msgs import Time
from ppaas.perception.point_cloud import coordinates_of_cloud
from ppaas.transforms.planar import tf_time
from ppaas.transforms.spatial import Rigid, matrix_of
from robots.recordings.bag import ROS_ENCODINGS, Bag
from robots.recordings.bag_frames import BagFrames
from robots.recordings.bag_objects import BagObjects, full_type
from robots.recordings.recording import RecordedFrames
from robots.recordings.ros_bags import ODOMETRY, TRANSFORMS, is_static
from robots.recordings.sensor_scans import CAMERA_INFO, CLOUD, COMPRESSED, IMAGE, DepthImages

SENSORS = (IMAGE, COMPRESSED, CLOUD)


class RobotPoints(NamedTuple):
    """Points that a sensor saw at one time.

    Parameters
    ----------
    stamp : float
        Time [s].
    points : (n, 3) float32 array
        Points x, y, z in the frame of the robot [m].
    sensor : Rigid
        Pose of the sensor in that frame.
    """

    stamp: float
    points: NDArray[np.float32]
    sensor: Rigid


class BagPoints:
    """Depth images and clouds of a bag.

    Parameters
    ----------
    path : Path
    frames : RecordedFrames
        Names of frames.

    Attributes
    ----------
    left_out : Counter of str
        Number of images and clouds that could not be used, by the reason.

    Raises
    ------
    InvalidInput
        The bag cannot be read.
    """

    def __init__(self, path: Path, frames: RecordedFrames) -> None:
        self._path = path
        self._frames = frames
        self.left_out: Counter[str] = Counter()

    def read(self) -> Iterator[RobotPoints]:
        """Yield the points of each image and cloud, in the order of recording; raises as the constructor."""
        frames, objects, images = self._transforms(), BagObjects(), DepthImages()
        for message in Bag(self._path).messages():
            kind, topic = full_type(message.channel.type), message.channel.topic
            if kind not in (*SENSORS, CAMERA_INFO) or message.channel.encoding not in ROS_ENCODINGS:
                continue
            if kind in (IMAGE, COMPRESSED) and not images.may_be_depths(topic):
                continue
            read = objects.read(message)
            try:
                found = None if read is None else self._points(kind, topic, read, images, frames)
            except InvalidInput as error:
                self.left_out[str(error)] += 1
                continue
            if found is not None:
                yield found

    def _transforms(self) -> BagFrames:
        """Return the frames by all transforms and odometry of the bag."""
        frames, objects = BagFrames(self._frames), BagObjects()
        odometry: list[tuple[str, Any]] = []
        moving: list[Any] = []
        static: list[Any] = []
        for message in Bag(self._path).messages():
            kind, topic = full_type(message.channel.type), message.channel.topic
            if kind not in (*TRANSFORMS, ODOMETRY) or message.channel.encoding not in ROS_ENCODINGS:
                continue
            if (read := objects.read(message)) is None:
                continue
            if kind == ODOMETRY:
                odometry.append((topic, read))
            else:
                (static if is_static(topic) else moving).append(read.transforms)
        for transforms in moving:
            frames.hear_parents(transforms)
        for are_static, lists in ((True, static), (False, moving)):
            for transforms in lists:
                frames.add_transforms(transforms, static=are_static)
        for topic, message in odometry:
            frames.add_odometry(topic, message)
        frames.join()
        return frames

    def _points(
        self, kind: str, topic: str, message: Any, images: DepthImages, frames: BagFrames
    ) -> RobotPoints | None:
        if kind == CAMERA_INFO:
            images.add_info(topic, message)
            return None
        read = None if kind == CLOUD else images.read(topic, message)
        if kind != CLOUD and read is None:
            return None
        name = message.header.frame_id.lstrip("/")
        mount = frames.mount(name)
        if mount is None:
            self.left_out[f"no transform leads from {frames.base} to {name or 'their sensor'}"] += 1
            return None
        stamp = tf_time(Time(message.header.stamp.sec, message.header.stamp.nanosec))
        matrix = matrix_of(mount)
        if read is not None:
            lens, depths = read
            return RobotPoints(stamp, points_of_depth(depths, lens.lens, matrix, fy=lens.fy), mount)
        own = np.stack([axis.ravel() for axis in coordinates_of_cloud(message)], axis=1).astype(np.float32)
        return RobotPoints(stamp, apply(matrix, own[np.isfinite(own).all(axis=1)]), mount)
