"""Frames in a bag of ROS: of the odometry, the robot, its lasers and the map, under any names."""

import math
from collections.abc import Iterable
from typing import Any, NamedTuple

from ppaas.errors import TransformError
from ppaas.geometry import Pose2D
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Quaternion, Transform, TransformStamped, Vector3
from ppaas.nodes.frames import BASE_FOOTPRINT, BASE_LINK, MAP, ODOM, unprefixed
from ppaas.transforms.planar import TransformTree, is_level, tf_time
from ppaas.transforms.spatial import LatestFrames, Rigid
from robots.recordings.bag_times import APART
from robots.recordings.recording import RecordedFrames

BASES = (BASE_LINK, BASE_FOOTPRINT)
"""Names of a robot's base frame, each with or without a prefix."""


class _Above(NamedTuple):
    """Parent of a frame, its first pose in it, and whether another one followed."""

    parent: str
    first: Rigid
    moved: bool = False


class BagFrames:
    """Transforms of a bag at all times.

    Parameters
    ----------
    names : RecordedFrames
        Names that the user gives.

    Attributes
    ----------
    base : str
        Frame of the robot.
    """

    def __init__(self, names: RecordedFrames) -> None:
        self._names = names
        self._tree = TransformTree(math.inf)
        self._body = LatestFrames()
        self._source: tuple[str, str] | None = None
        self._above: dict[str, _Above] = {}
        self._times: tuple[float, ...] = ()
        self._others: dict[str, None] = {}
        self._unnamed: str | None = None
        self._parents: dict[str, list[str]] = {}
        self._wrong: list[TransformError] = []
        self.base = names.base or BASE_LINK

    def hear_parents(self, transforms: Iterable[Any]) -> None:
        """Take note of the parents of moving frames, of which `add_transforms` uses one for each frame."""
        for each in transforms:
            known = self._parents.setdefault(each.child_frame_id.lstrip("/"), [])
            if (parent := each.header.frame_id.lstrip("/")) not in known:
                known.append(parent)

    def add_transforms(self, transforms: Iterable[Any], *, static: bool) -> None:
        """Add transforms; those that are not rigid are left out, and those to other parents of a frame."""
        for each in transforms:
            if static or each.header.frame_id.lstrip("/") == self._parent(each.child_frame_id.lstrip("/")):
                self._add(_stamped(each.header, each.child_frame_id, each.transform), static=static)

    def _parent(self, frame: str) -> str:
        """Return the parent of a moving frame: the odometry's, or else the first that is not the map."""
        return min(self._parents[frame], key=self._preference)

    def _preference(self, parent: str) -> int:
        named = parent == self._names.odom, unprefixed(parent) == ODOM, unprefixed(parent) != MAP
        return next((place for place, fits in enumerate(named) if fits), len(named))

    def add_odometry(self, topic: str, message: Any) -> None:
        """Add odometry, unless transforms move its frame. Of several topics, the first counts.

        Frames without a name, or with one for both, belong to the odometry and the robot.
        """
        parent, child = message.header.frame_id.lstrip("/"), message.child_frame_id.lstrip("/")
        if not child or child == parent:
            parent, child = ("" if unprefixed(parent) in BASES else parent), self._root_base()
        if self._source is None and self._tree.newest(child) is None:
            self._source = topic, child
        if self._source == (topic, child):
            pose = message.pose.pose
            moved = Transform(_vector(pose.position), _quaternion(pose.orientation))
            header = _header(message.header, parent or self._names.odom or ODOM)
            self._add(TransformStamped(header, child, moved), static=False)
        elif self._source is not None:
            self._others[topic] = None

    def _root_base(self) -> str:
        """Return the frame of the robot by its name, or the one above the others before odometry moves it."""
        if self._unnamed is None:
            known = (frame for frame in self._above_all() if unprefixed(frame) in BASES)
            self._unnamed = self._names.base or next(known, BASE_LINK)
        return self._unnamed

    def _above_all(self) -> list[str]:
        return sorted({above.parent for above in self._above.values()} - self._above.keys())

    def join(self) -> None:
        """Find the frame of the robot, and merge unconnected frames of its names with it, as a clone does."""
        known = self._tree.frames()
        likely = [frame for name in BASES for frame in known if unprefixed(frame) == name]
        likely += [child for _, child in (self._source,) if child not in likely] if self._source else []
        moving = (frame for frame in likely if self._tree.moving_parent(frame, self.map) is not None)
        self.base = self._names.base or next(moving, likely[0] if likely else self.base)
        for frame in likely:
            if not self._body.connected(self.base, frame) and self._body.root(frame) == frame:
                joint = TransformStamped(Header(frame_id=self.base), frame, Rigid().to_message())
                self._add(joint, static=True)

    def _add(self, transform: TransformStamped, *, static: bool) -> None:
        try:
            self._note(transform, Rigid.of(transform.transform))
            if not static:
                times = (*self._times, tf_time(transform.header.stamp))
                self._times = min(times), max(times)
            # Cameras and wheels are not level: they only matter where a laser is mounted on them.
            if is_level(transform.transform.rotation):
                self._tree.set_message(transform, static=static)
            self._body.hear((transform,))
        except TransformError as error:
            self._wrong.append(error)

    def _note(self, transform: TransformStamped, pose: Rigid) -> None:
        parent, child = transform.header.frame_id.lstrip("/"), transform.child_frame_id.lstrip("/")
        known = self._above.get(child)
        if known is None or known.parent != parent:
            self._above[child] = _Above(parent, pose)
        elif not known.moved and pose != known.first:
            self._above[child] = known._replace(moved=True)

    def notes(self) -> list[str]:
        """Return what of the odometry and the transforms is not used."""
        notes = []
        if self._others and self._source is not None:
            notes.append(f"odometry on {self._source[0]} is used, that on {', '.join(self._others)} is not")
        for frame, parents in self._parents.items():
            others = [parent for parent in parents if parent != self._parent(frame)]
            if others:
                notes.append(
                    f"transforms of {frame} in {self._parent(frame)} are used, those in {', '.join(others)} are not"
                )
        if self._wrong:
            notes.append(f"{len(self._wrong)} transforms or poses of odometry left out; the first: {self._wrong[0]}")
        return notes

    # -- names ---------------------------------------------------------------------------------------------------------

    @property
    def odom(self) -> str:
        """Frame of the odometry."""
        return self._names.odom or self._tree.moving_parent(self.base, self.map) or ODOM

    @property
    def map(self) -> str:
        """Frame of the true poses."""
        known = (frame for frame in self._tree.frames() if unprefixed(frame) == MAP)
        return self._names.map or next(known, MAP)

    @property
    def is_base_known(self) -> bool:
        """Whether transforms or odometry have the frame of the robot."""
        return self.base in self._tree.frames()

    def missing(self, first: float, last: float) -> str:
        """Return a text that names the missing odometry, by the first and the last time of a scan [s]."""
        if self._times and (last < min(self._times) - APART or first > max(self._times) + APART):
            return (
                f"odometry at the time of any of them: they are stamped {first:.1f} to {last:.1f} s, and odometry and "
                f"transforms {min(self._times):.1f} to {max(self._times):.1f} s: set one clock where it is recorded"
            )
        frames = ", ".join(self._tree.frames())
        if not frames and self._wrong:
            return f"odometry that can be used: {self._wrong[0]}"
        return (
            f"odometry ({self.odom} → {self.base}) at the time of any of them; its frames are "
            f"{frames or 'none'}: name those of the robot by --odom-frame and --base-frame"
        )

    # -- poses ---------------------------------------------------------------------------------------------------------

    def has_odometry(self, lasers: Iterable[str]) -> bool:
        """Return whether the bag has odometry: by messages, or by transforms above the robot.

        Without a frame of the robot by any known name, transforms above its lasers count, if they move: the user is to
        name the frames.
        """
        if self._names.odom is not None or self._source is not None:
            return True
        if self.is_base_known:
            return self._tree.moving_parent(self.base, self.map) is not None
        return any(self.moves(laser.lstrip("/")) for laser in lasers)

    def moves(self, frame: str) -> bool:
        """Return whether a frame or one above it moves in another frame than the map's."""
        seen: set[str] = set()
        while frame not in seen and (known := self._above.get(frame)) is not None:
            seen.add(frame)
            if known.moved and unprefixed(known.parent) != MAP:
                return True
            frame = known.parent
        return False

    def odometry(self, stamp: float) -> Pose2D:
        """Return the pose of the robot in the odometry frame; raises ``TransformError`` if there is none at a time."""
        return self._tree.lookup(self.odom, self.base, stamp)

    def true_pose(self, stamp: float) -> Pose2D | None:
        """Return the true pose of the robot, None if the bag has none; raises as `odometry`."""
        return self._tree.lookup(self.map, self.base, stamp) if self.map in self._tree.frames() else None

    def mount(self, frame: str) -> Rigid | None:
        """Return the pose of a laser in the robot's frame, None if the bag has no transform to it."""
        return self._body.lookup(self.base, frame) if frame and self._body.connected(self.base, frame) else None


def _stamped(header: Any, child: str, transform: Any) -> TransformStamped:
    moved = Transform(_vector(transform.translation), _quaternion(transform.rotation))
    return TransformStamped(_header(header), child, moved)


def _header(header: Any, frame: str | None = None) -> Header:
    return Header(
        stamp=Time(header.stamp.sec, header.stamp.nanosec), frame_id=header.frame_id if frame is None else frame
    )


def _vector(at: Any) -> Vector3:
    return Vector3(at.x, at.y, at.z)


def _quaternion(q: Any) -> Quaternion:
    return Quaternion(x=q.x, y=q.y, z=q.z, w=q.w)
