"""Planar tf tree: buffers transforms between frames over time and looks them up, as tf2 does.

It is planar on purpose: the frames of a clone (map, odom, base_link, laser) differ by rotations about z only. The
height of a ``TransformStamped`` is ignored, and ``set_message`` refuses a transform with roll or pitch.
"""

import bisect
import logging
import math
from operator import itemgetter

from ppaas.errors import TransformError
from ppaas.geometry import Pose2D, wrap_angle, yaw_of
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Quaternion, Transform, TransformStamped, Vector3
from ppaas.transforms.connections import not_connected

logger = logging.getLogger(__name__)

CACHE_TIME = 10.0
"""Length of a frame's buffer [s], as in tf2."""

SET_BACK = 0.2
"""Age relative to the newest transform of a frame above which two transforms in a row mean that the sender's clock was
set back [s]."""

MAX_TILT = 0.02
"""Largest roll or pitch that counts as level [rad]."""

USEFUL_TILT = math.radians(15.0)
"""Tilt of a laser above which most of its beams end on the floor or above the robot [rad]."""

LARGEST_TILT = math.radians(60.0)
"""Tilt of a laser above which its scans are refused [rad]."""

IDENTITY = Pose2D(0.0, 0.0, 0.0)

_stamp_of = itemgetter(0)


def tf_time(stamp: Time) -> float:
    """Return a stamp in seconds, rounded to the microsecond.

    This is the precision of a float with seconds since the epoch. Without rounding, one stamp that is converted in two
    messages could give two different times.
    """
    return round(stamp.seconds(), 6)


def transform_message(parent: str, child: str, pose: Pose2D, stamp: Time) -> TransformStamped:
    """Return a planar transform as ``geometry_msgs/TransformStamped``."""
    rotation = Quaternion(z=math.sin(pose.theta / 2.0), w=math.cos(pose.theta / 2.0))
    transform = Transform(Vector3(pose.x, pose.y, 0.0), rotation)
    return TransformStamped(Header(stamp=stamp, frame_id=parent), child, transform)


class TransformTree:
    """Tree of frames, with the transforms of each frame to its parent over the last seconds.

    Transforms may arrive out of order; they are sorted into the buffer by their stamps. If one is older than the whole
    buffer, or two in a row are older than the newest by more than `SET_BACK`, the sender's clock was set back, and the
    frame's buffer starts again from there. tf2 would instead ignore the robot until its clock has caught up. Of two
    senders whose clocks differ, each clears nothing, since their transforms take turns.

    Parameters
    ----------
    cache_time : float
        Length of a frame's buffer, back from its newest transform [s]. An infinite one is sorted, and never cleared.
    """

    def __init__(self, cache_time: float = CACHE_TIME) -> None:
        self._cache_time = cache_time
        self._parents: dict[str, str] = {}
        self._static: dict[str, Pose2D] = {}
        self._moving: dict[str, list[tuple[float, Pose2D]]] = {}
        self._behind: dict[str, tuple[float, Pose2D]] = {}

    # -- setting -------------------------------------------------------------------------------------------------------

    def set(self, parent: str, child: str, pose: Pose2D, stamp: float) -> None:
        """Set the pose of ``child`` in ``parent`` at a time.

        Raises
        ------
        TransformError
            A number is not finite, or beyond `ppaas.geometry.FARTHEST`; a frame has no name, or the frames would form
            a loop.
        """
        if not math.isfinite(stamp):
            raise TransformError(f"stamp of transform {parent!r} → {child!r} is not finite")
        self._connect(parent, child, pose)
        self._static.pop(child, None)
        buffer = self._moving.setdefault(child, [])
        if buffer and self._cache_time < math.inf:
            self._note_clock(child, buffer, pose, stamp)
        index = bisect.bisect_left(buffer, stamp, key=_stamp_of)
        if index < len(buffer) and buffer[index][0] == stamp:
            buffer[index] = (stamp, pose)
        else:
            buffer.insert(index, (stamp, pose))
        del buffer[: bisect.bisect_left(buffer, buffer[-1][0] - self._cache_time, key=_stamp_of)]

    def _note_clock(self, child: str, buffer: list[tuple[float, Pose2D]], pose: Pose2D, stamp: float) -> None:
        """Empty a frame's buffer if its sender's clock was set back; keep the transform before, if it shows that."""
        before, behind = self._behind.pop(child, None), buffer[-1][0] - stamp
        if behind <= SET_BACK:
            return
        if behind <= self._cache_time and (before is None or stamp < before[0]):
            self._behind[child] = stamp, pose
            return
        logger.warning("the clock of frame %r was set back by %.3f s: clearing its buffer", child, behind)
        buffer[:] = [before] if before is not None and before[0] < stamp else []

    def set_static(self, parent: str, child: str, pose: Pose2D) -> None:
        """Set the pose of ``child`` in ``parent`` for all times.

        A static transform that would close a loop with the new one is removed: the latest sender knows best.

        Raises
        ------
        TransformError
            As for ``set``.
        """
        self._connect(parent, child, pose, static=True)
        self._moving.pop(child, None)
        self._static[child] = pose

    def keep_newest(self, child: str) -> None:
        """Forget the transforms of a moving frame before its newest one, which has jumped: it holds from now on."""
        buffer = self._moving.get(child)
        if buffer:
            del buffer[:-1]

    def set_message(self, transform: TransformStamped, *, static: bool = False, now: float = 0.0) -> None:
        """Set a transform from ``geometry_msgs/TransformStamped``; a stamp of zero means ``now`` [s].

        Raises
        ------
        TransformError
            As for ``set``, or the transform has roll or pitch.
        """
        parent, child = transform.header.frame_id.lstrip("/"), transform.child_frame_id.lstrip("/")
        pose = _planar(transform.transform, f"{parent!r} → {child!r}")
        if static:
            self.set_static(parent, child, pose)
        else:
            self.set(parent, child, pose, tf_time(transform.header.stamp) or round(now, 6))

    def _connect(self, parent: str, child: str, pose: Pose2D, *, static: bool = False) -> None:
        if not parent or not child:
            raise TransformError(f"transform {parent!r} → {child!r}: both frames need a name")
        if not pose.is_finite():
            raise TransformError(f"transform {parent!r} → {child!r} is not finite")
        if not pose.is_near():
            raise TransformError(
                f"transform {parent!r} → {child!r}, ({pose.x:.3g}, {pose.y:.3g}), is too far: send metres"
            )
        if static:
            self._open_loop(parent, child)
        if child in self._chain(parent):
            raise TransformError(f"transform {parent!r} → {child!r} would close a loop of frames")
        if self._parents.get(child, parent) != parent:
            self._moving.pop(child, None)
            self._behind.pop(child, None)
        self._parents[child] = parent

    def _open_loop(self, parent: str, child: str) -> None:
        """Remove a static transform between a new child and its new parent below it, if there is one."""
        chain = self._chain(parent)
        if child != parent and child in chain:
            static = [frame for frame in chain[: chain.index(child)] if frame in self._static]
            for frame in static[-1:]:
                del self._parents[frame], self._static[frame]

    # -- looking up ----------------------------------------------------------------------------------------------------

    def frames(self) -> tuple[str, ...]:
        """Return the sorted names of all frames."""
        return tuple(sorted({*self._parents, *self._parents.values()}))

    def newest(self, child: str) -> float | None:
        """Return the newest stamp of a frame [s]; None if it is static or unknown."""
        buffer = self._moving.get(child)
        return buffer[-1][0] if buffer else None

    def common_time(self, target: str, source: str) -> float | None:
        """Return the latest time at which all transforms between two frames are known [s].

        It is None if all of them are static, or if the frames are not connected.
        """
        try:
            down, up = self._path(target, source)
        except TransformError:
            return None
        return self._common_time(down, up)

    def _common_time(self, down: list[str], up: list[str]) -> float | None:
        return min((self._moving[child][-1][0] for child in (*down, *up) if child in self._moving), default=None)

    def moving_parent(self, frame: str, below: str) -> str | None:
        """Return the parent of the highest moving transform between a frame and ``below``, or the root of the tree.

        The transform to ``below`` itself does not count. Returns None if no transform moves.
        """
        highest, parent = None, self._parents.get(frame)
        while parent is not None and below not in (frame, parent):
            if frame in self._moving:
                highest = parent
            frame, parent = parent, self._parents.get(parent)
        return highest

    def moving_between(self, target: str, source: str) -> list[str]:
        """Return the frames between two frames whose transform to their parent moves.

        Raises
        ------
        TransformError
            A frame is unknown, or the two are not connected.
        """
        down, up = self._path(target, source)
        return [child for child in (*down, *up) if child in self._moving]

    def moving_apart_from(self, frame: str) -> list[str]:
        """Return the frames whose transform to their parent moves, without those below a frame."""
        return [child for child in self._moving if frame not in self._chain(child)[1:]]

    def lookup(self, target: str, source: str, stamp: float | None = None) -> Pose2D:
        """Return the pose of ``source`` in ``target``.

        Parameters
        ----------
        target, source : str
            Frames.
        stamp : float, optional
            Time [s]. Transforms are interpolated between stamps, never extrapolated. The default is the latest time at
            which all transforms between the two frames are known. If there is none, because the clock of a sender was
            set, the oldest transform of a frame that begins later is taken.

        Raises
        ------
        TransformError
            A frame is unknown, or the two are not connected at all or not at that time.
        """
        down, up = self._path(target, source)
        if stamp is None:
            common = self._common_time(down, up) or 0.0
            return self._along(down, common, closest=True).inverse() @ self._along(up, common, closest=True)
        return self._along(down, stamp).inverse() @ self._along(up, stamp)

    def _along(self, chain: list[str], stamp: float, *, closest: bool = False) -> Pose2D:
        pose = IDENTITY
        for child in chain:
            at = max(stamp, self._moving[child][0][0]) if closest and child in self._moving else stamp
            pose = self._at(child, at) @ pose
        return pose

    def _path(self, target: str, source: str) -> tuple[list[str], list[str]]:
        """Return the frames from target up to the common ancestor, and those from source; both without the ancestor."""
        down, up = self._chain(target), self._chain(source)
        common = next((frame for frame in up if frame in down), None)
        if common is None:
            raise not_connected(target, source, self.frames())
        return down[: down.index(common)], up[: up.index(common)]

    def _chain(self, frame: str) -> list[str]:
        chain = [frame]
        while chain[-1] in self._parents:
            chain.append(self._parents[chain[-1]])
        return chain

    def _at(self, child: str, stamp: float) -> Pose2D:
        if child in self._static:
            return self._static[child]
        buffer = self._moving[child]
        first, last = buffer[0][0], buffer[-1][0]
        if not first <= stamp <= last:
            raise TransformError(
                f"{self._parents[child]!r} → {child!r} is known from {first:.3f} to {last:.3f} s, not at {stamp:.3f} s"
            )
        index = bisect.bisect_left(buffer, stamp, key=_stamp_of)
        after, right = buffer[index]
        if after == stamp:
            return right
        before, left = buffer[index - 1]
        return _between(left, right, (stamp - before) / (after - before))


def _between(a: Pose2D, b: Pose2D, share: float) -> Pose2D:
    """Interpolate linearly from a (``share`` = 0) to b (1), turning in the shorter direction."""
    turn = wrap_angle(b.theta - a.theta)
    return Pose2D(
        a.x + share * (b.x - a.x),
        a.y + share * (b.y - a.y),
        wrap_angle(a.theta + share * turn),
    )


def is_level(rotation: Quaternion) -> bool:
    """Return whether a rotation keeps the z axis upright within ``MAX_TILT``.

    Parameters
    ----------
    rotation : Quaternion
        Need not be normalised.

    Raises
    ------
    TransformError
        The quaternion is not finite, or zero.
    """
    q = rotation
    squared = q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w
    if not (math.isfinite(squared) and squared > 1e-12):
        raise TransformError(f"({q.x}, {q.y}, {q.z}, {q.w}) is not a rotation quaternion")
    lean = 2.0 * math.hypot(q.x * q.z + q.w * q.y, q.y * q.z - q.w * q.x) / squared
    upright = (q.w * q.w + q.z * q.z - q.x * q.x - q.y * q.y) > 0.0
    return upright and lean <= math.sin(MAX_TILT)


def _planar(transform: Transform, name: str) -> Pose2D:
    q = transform.rotation
    if not is_level(q):
        raise TransformError(f"transform {name} has roll or pitch, but this tf tree is planar: only yaw is supported")
    translation = transform.translation
    return Pose2D(translation.x, translation.y, yaw_of(q.x, q.y, q.z, q.w))
