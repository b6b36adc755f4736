"""Key frames of a map as ``nav_msgs/Path``, for nodes whose data hang on them."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.mapping.key_frames import KeyFrames
from ppaas.mapping.volume.key_frame_poses import NO_KEY_FRAMES, KeyFramePoses
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Pose, PoseStamped
from ppaas.messages.nav_msgs import Path
from ppaas.nodes.base import Context, Payload
from ppaas.nodes.frames import MAP
from ppaas.nodes.message_checks import expect
from ppaas.nodes.topics import KEY_FRAMES
from ppaas.planar_poses import compose
from ppaas.transforms.planar import tf_time


@dataclass(frozen=True, slots=True, eq=False)
class KeyFramePath:
    """Poses of the robot at the key frames, converted to a message only when they leave the process.

    Parameters
    ----------
    key_frames : KeyFramePoses
    stamp : Time
        Time at which the poses were found.
    """

    key_frames: KeyFramePoses
    stamp: Time

    def to_message(self) -> Path:
        """Return ``nav_msgs/Path``: each pose in the map frame, stamped with the time of its scan."""
        stamps, poses = self.key_frames.stamps.tolist(), self.key_frames.poses.tolist()
        path = [
            PoseStamped(Header(stamp=Time.of(stamp), frame_id=MAP), Pose.of(Pose2D(*pose)))
            for stamp, pose in zip(stamps, poses, strict=True)
        ]
        return Path(Header(stamp=self.stamp, frame_id=MAP), path)


class KeyFrameTimes:
    """Times of key frames by the indices of their scans.

    Attributes
    ----------
    numbers : list of int
        Indices of the scans.
    stamps : list of float
        Times of these, ascending [s].
    edition : int
        Number of times that known times were removed or got other numbers.
    """

    def __init__(self) -> None:
        self.numbers: list[int] = []
        self.stamps: list[float] = []
        self.edition = 0

    def add(self, number: int, stamp: float) -> None:
        """Note the time of a key frame. Earlier ones with later times are forgotten: the clock was set back."""
        while self.stamps and self.stamps[-1] >= stamp:
            del self.stamps[-1], self.numbers[-1]
            self.edition += 1
        self.numbers.append(number)
        self.stamps.append(stamp)

    def renumber(self, numbers: Mapping[int, int]) -> None:
        """Keep the times of some scans, which have other indices now."""
        kept = [
            (numbers[number], stamp)
            for number, stamp in zip(self.numbers, self.stamps, strict=True)
            if number in numbers
        ]
        self.use([number for number, _ in kept], [stamp for _, stamp in kept])

    def use(self, numbers: list[int], stamps: list[float]) -> None:
        """Replace all times."""
        self.numbers, self.stamps = numbers, stamps
        self.edition += 1


class KeyFramePublisher:
    """Publishes ``key_frames``, while somebody subscribes to it.

    Parameters
    ----------
    context : Context
        Of the node.
    times : KeyFrameTimes
        Times of the key frames, which are noted there.
    """

    def __init__(self, context: Context, times: KeyFrameTimes) -> None:
        self._context, self._times = context, times

    def add(self, key_frames: KeyFrames, stamp: float) -> None:
        """Note the time of the newest key frame [s], and publish."""
        self._times.add(int(key_frames.scans[-1]), stamp)
        if len(self._times.numbers) > 2 * len(key_frames):  # most of them were removed from the map
            self.renumber(key_frames.scans, key_frames.scans)
        self.publish(key_frames)

    def renumber(self, before: NDArray[np.int64], after: NDArray[np.int64]) -> None:
        """Note that scans (k,) have other numbers now; the times of all others are forgotten."""
        self._times.renumber(dict(zip(before.tolist(), after.tolist(), strict=True)))

    def publish(self, key_frames: KeyFrames) -> None:
        """Publish the poses of the robot at the key frames whose times are known."""
        if not self._context.has_subscribers(KEY_FRAMES.name):
            return
        _, frames, times = np.intersect1d(key_frames.scans, self._times.numbers, return_indices=True)
        robot = compose(key_frames.poses[frames], np.array(key_frames.geometry.mount.inverse()))
        self._publish(KeyFramePoses(np.array(self._times.stamps)[times], robot))

    def clear(self) -> None:
        """Publish that there are no key frames: the map was cleared."""
        self._times.use([], [])
        self._publish(NO_KEY_FRAMES)

    def _publish(self, key_frames: KeyFramePoses) -> None:
        self._context.publish(KEY_FRAMES.name, KeyFramePath(key_frames, Time.of(self._context.now())))


def key_frames_of(message: Payload) -> KeyFramePoses:
    """Return the key frames of a message.

    Raises
    ------
    InvalidInput
        It is another message, a number is not finite, or the stamps do not ascend.
    """
    if isinstance(message, KeyFramePath):
        return message.key_frames
    path = expect(message, Path)
    if not isinstance(path.poses, list):
        raise InvalidInput("the poses of the key frames must be a list of geometry_msgs/PoseStamped")
    stamps = np.array([tf_time(pose.header.stamp) for pose in path.poses], np.float64)
    poses = np.array([pose.pose.planar() for pose in path.poses], np.float64).reshape(-1, 3)
    if not (np.isfinite(poses).all() and (np.diff(stamps) > 0.0).all()):
        raise InvalidInput("the poses of the key frames must be finite, and their stamps ascend")
    return KeyFramePoses(stamps, poses)
