"""Poses of clouds in the map frame: by the key frames that they hang on, or by ``tf``."""

from collections import deque

from ppaas.errors import TransformError
from ppaas.geometry import Pose2D
from ppaas.mapping.volume.key_frame_poses import NO_KEY_FRAMES, Anchor, KeyFramePoses
from ppaas.nodes.frames import BASE_FOOTPRINT, MAP, FrameListener
from ppaas.nodes.octomap_server.clouds import SensorCloud
from ppaas.nodes.octomap_server.map_work import PlacedCloud
from ppaas.transforms.spatial import Rigid

KEPT = 100
"""Number of key frames of which the odometry is stored: more than clouds wait for."""

MOST_APART = 5.0
"""Distance from its key frame above which a cloud is placed by ``tf``: the odometry was reset [m]."""


class CloudPoses:
    """Finds the poses of clouds.

    While a node makes a map and publishes its key frames, a cloud is placed by the odometry since the last key frame.
    So it needs no transform of the map frame, which jumps when a loop is closed.

    Parameters
    ----------
    frames : FrameListener
        Frames of the robot.

    Attributes
    ----------
    key_frames : KeyFramePoses
        Newest poses of the key frames.
    """

    def __init__(self, frames: FrameListener) -> None:
        self.key_frames: KeyFramePoses = NO_KEY_FRAMES
        self._frames = frames
        self._odometry: deque[tuple[float, Pose2D]] = deque(maxlen=KEPT)

    def set_key_frames(self, key_frames: KeyFramePoses) -> None:
        """Use new poses of the key frames, and note the odometry at the newest of them."""
        self.key_frames = key_frames
        if not len(key_frames):
            self._odometry.clear()
            return
        newest = float(key_frames.stamps[-1])
        if self._odometry and self._odometry[-1][0] == newest:
            return
        try:
            self._odometry.append((newest, self._frames.odometry(newest)))
        except TransformError:
            return  # it is a key frame of an earlier drive

    def newest(self) -> float | None:
        """Return the time up to which clouds can be placed [s]; None if none can be."""
        if len(self.key_frames):
            return self._frames.newest()
        return self._frames.tree.common_time(MAP, self._frames.base)

    def place(self, cloud: SensorCloud, stamp: float) -> PlacedCloud:
        """Return a cloud with its pose at a time [s].

        Raises
        ------
        TransformError
            The frame of the sensor is unknown, or the pose of the robot at that time.
        """
        floor = Rigid(z=-self._frames.height_of(BASE_FOOTPRINT))
        anchor, robot = self._robot(stamp)
        return PlacedCloud(cloud.placed, floor @ self._frames.mount(cloud.frame), Rigid.planar(robot), anchor)

    def _robot(self, stamp: float) -> tuple[Anchor | None, Pose2D]:
        """Return the key frame for a cloud and the pose of the robot in the map frame."""
        anchor = self.key_frames.anchor(stamp) if len(self.key_frames) else None
        if anchor is not None:
            before = next((pose for at, pose in reversed(self._odometry) if at == anchor.stamp), None)
            moved = before.inverse() @ self._frames.odometry(stamp) if before is not None else None
            if moved is not None and moved.distance_to(Pose2D(0.0, 0.0)) <= MOST_APART:
                return anchor, anchor.pose @ moved
        return anchor, self._frames.in_map(stamp)
