"""Rigid transforms in space, and the latest transform of each frame, for frames that may be tilted.

Navigation uses ``ppaas.transforms.planar``, which interpolates in time. Here frames may be tilted, as wheels and
cameras are, and a lookup combines the latest transforms, whatever their stamps. A sensor on the robot's body does not
move, so its mount is looked up here too.
"""

import contextlib
import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import TransformError
from ppaas.geometry import Pose2D, quaternion_of
from ppaas.messages.geometry_msgs import Quaternion, Transform, TransformStamped, Vector3
from ppaas.messages.tf2_msgs import MAX_FRAMES
from ppaas.transforms.connections import not_connected


class Rigid(NamedTuple):
    """Rigid transform: a translation [m] and a rotation as a unit quaternion."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    qx: float = 0.0
    qy: float = 0.0
    qz: float = 0.0
    qw: float = 1.0

    @classmethod
    def of(cls, transform: Transform) -> "Rigid":
        """Return the rigid transform of a message, whose quaternion need not be normalised.

        Raises
        ------
        TransformError
            A number is not finite, or the quaternion is zero.
        """
        t, q = transform.translation, transform.rotation
        norm = math.hypot(q.x, q.y, q.z, q.w)
        if not (math.isfinite(norm + t.x + t.y + t.z) and norm > 1e-6):
            raise TransformError("transform is not finite, or its rotation is the zero quaternion")
        return cls(t.x, t.y, t.z, q.x / norm, q.y / norm, q.z / norm, q.w / norm)

    @classmethod
    def planar(cls, pose: Pose2D, z: float = 0.0) -> "Rigid":
        """Return a pose in the plane as a rigid transform, at a height [m]."""
        return cls(pose.x, pose.y, z, *quaternion_of(pose.theta))

    def to_message(self) -> Transform:
        """Return ``geometry_msgs/Transform``."""
        return Transform(Vector3(self.x, self.y, self.z), Quaternion(x=self.qx, y=self.qy, z=self.qz, w=self.qw))

    def __matmul__(self, other: "Rigid") -> "Rigid":
        """Compose two transforms: ``self`` after ``other``."""
        ax, ay, az, aw = self[3:]
        bx, by, bz, bw = other[3:]
        # A unit quaternion (a, w) rotates v to v + w·t + a × t with t = 2·a × v (Rodrigues' formula).
        tx, ty, tz = (
            2.0 * (ay * other.z - az * other.y),
            2.0 * (az * other.x - ax * other.z),
            2.0 * (ax * other.y - ay * other.x),
        )
        return Rigid(
            self.x + other.x + aw * tx + ay * tz - az * ty,
            self.y + other.y + aw * ty + az * tx - ax * tz,
            self.z + other.z + aw * tz + ax * ty - ay * tx,
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
            aw * bw - ax * bx - ay * by - az * bz,
        )

    def inverse(self) -> "Rigid":
        """Return the inverse transform: ``r @ r.inverse()`` is the identity."""
        back = Rigid(qx=-self.qx, qy=-self.qy, qz=-self.qz, qw=self.qw)
        return back @ Rigid(-self.x, -self.y, -self.z)

    @property
    def tilt(self) -> float:
        """Angle between the planes of x and y of both frames, 0 to π/2, also for a frame upside down [rad]."""
        return math.acos(min(1.0, abs(1.0 - 2.0 * (self.qx * self.qx + self.qy * self.qy))))

    def distance_to(self, other: "Rigid") -> float:
        """Return the distance between the two origins [m]."""
        return math.dist(self[:3], other[:3])

    def angle_to(self, other: "Rigid") -> float:
        """Return the angle of the rotation from one to the other, 0 to π [rad]."""
        turn = self.inverse() @ other
        return 2.0 * math.atan2(math.hypot(turn.qx, turn.qy, turn.qz), abs(turn.qw))


def matrix_of(pose: Rigid) -> NDArray[np.float64]:
    """Return the matrix (4, 4) of a rigid transform."""
    x, y, z, w = pose[3:]
    matrix = np.eye(4)
    matrix[:3, :3] = (
        (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)),
        (2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)),
        (2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)),
    )
    matrix[:3, 3] = pose[:3]
    return matrix


class LatestFrames:
    """Latest transform of each frame to its parent."""

    def __init__(self) -> None:
        self._newest: dict[str, tuple[str, Rigid]] = {}

    def hear(self, transforms: Iterable[TransformStamped]) -> None:
        """Store transforms. As in tf2, those that are not rigid are ignored; so are frames beyond ``MAX_FRAMES``."""
        newest = self._newest
        for transform in transforms:
            child = transform.child_frame_id.lstrip("/")
            if child in newest or len(newest) < MAX_FRAMES:
                with contextlib.suppress(TransformError):
                    newest[child] = transform.header.frame_id.lstrip("/"), Rigid.of(transform.transform)

    def forget(self, child: str) -> None:
        """Remove the transform of a frame to its parent, if there is one."""
        self._newest.pop(child, None)

    def frames(self) -> tuple[str, ...]:
        """Return the sorted names of all frames."""
        return tuple(sorted({*self._newest, *(parent for parent, _ in self._newest.values())}))

    def connected(self, target: str, source: str) -> bool:
        """Return whether transforms connect two frames."""
        return not set(self._chain(target)).isdisjoint(self._chain(source))

    def lookup(self, target: str, source: str) -> Rigid:
        """Return the pose of ``source`` in ``target``.

        Raises
        ------
        TransformError
            A frame is unknown, or the two are not connected.
        """
        down, up = self._path(target, source)
        return self._along(down).inverse() @ self._along(up)

    def between(self, target: str, source: str) -> list[str]:
        """Return the frames whose transforms to their parents connect two frames; raises as `lookup`."""
        down, up = self._path(target, source)
        return [*down, *up]

    def newest(self, child: str) -> Rigid | None:
        """Return the pose of a frame in its parent; None if it has none."""
        known = self._newest.get(child)
        return None if known is None else known[1]

    def _path(self, target: str, source: str) -> tuple[list[str], list[str]]:
        down, up = self._chain(target), self._chain(source)
        common = next((frame for frame in up if frame in down), None)
        if common is None:
            raise not_connected(target, source, self.frames())
        return down[: down.index(common)], up[: up.index(common)]

    def root(self, frame: str, below: str = "") -> str:
        """Return the frame above a frame that has no parent, or whose parent is ``below``; itself if it has none."""
        chain = self._chain(frame)
        return chain[chain.index(below) - 1] if below in chain[1:] else chain[-1]

    def _chain(self, frame: str) -> list[str]:
        """Return a frame and its ancestors, up to the root or to where a loop closes."""
        chain = [frame]
        while (known := self._newest.get(chain[-1])) is not None and known[0] not in chain:
            chain.append(known[0])
        return chain

    def _along(self, chain: list[str]) -> Rigid:
        pose = Rigid()
        for child in chain:
            pose = self._newest[child][1] @ pose
        return pose
