"""Frames of a robot: their names, and a listener of ``tf`` and ``tf_static`` that knows where they are."""

import contextlib
import re
from dataclasses import dataclass

from ppaas.errors import TransformError
from ppaas.geometry import Pose2D
from ppaas.messages.geometry_msgs import TransformStamped
from ppaas.messages.tf2_msgs import MAX_FRAMES, TFMessage
from ppaas.nodes.topics import TF_STATIC
from ppaas.transforms.planar import CACHE_TIME, TransformTree, is_level
from ppaas.transforms.spatial import LatestFrames, Rigid

MAP = "map"
"""Frame of the map, in which Move Base plans and drives."""

ODOM = "odom"
SCAN_ODOM = "scan_odom"
"""Odometry frame of a robot without odometry that makes a map: the robot stands still in it."""

BASE_LINK = "base_link"
BASE_FOOTPRINT = "base_footprint"


MOVED = 0.02
"""Change of a transform from which its frame moves [m plus rad]."""

PERSON = re.compile(r"([^/]+)/((?:torso|person|user)?_?[0-9]+)")
"""Frame of a person whom a robot sees: ``{Robot ID}/{Torso ID}``, where a Torso ID is a number, also as ``torso_1``,
``person_1`` or ``user_1``."""


@dataclass(frozen=True, slots=True)
class FrameNames:
    """Names of a robot's frames, from the parameters of ``amcl``.

    Parameters
    ----------
    odom : str
        Frame of the odometry; empty for the frame that the robot's odometry names.
    base : str
        Frame of the robot's body, to which its footprint refers.
    map : str
        Another name of the map's frame.
    prefix : str
        Prefix of the frames of the robot's model; empty for its odometry's prefix.
    """

    odom: str = ""
    base: str = BASE_LINK
    map: str = MAP
    prefix: str = ""

    @classmethod
    def of(cls, odom: str, base: str, map_frame: str, prefix: str) -> "FrameNames":
        """Return the names of the parameters ``odom_frame_id``, ``base_frame_id``, ``global_frame_id``, ``tf_prefix``.

        A prefix applies to names without a slash, as in ROS 1.
        """
        prefix = prefix.strip("/")
        return cls(
            prefixed(prefix, odom.lstrip("/")),
            prefixed(prefix, base.lstrip("/")) or BASE_LINK,
            map_frame.lstrip("/") or MAP,
            prefix,
        )

    def is_map(self, frame: str) -> bool:
        """Return whether a frame is the map's: ``map`` by any of its names, or without one."""
        name = frame.lstrip("/")
        return name in ("", MAP, self.map) or unprefixed(name) == MAP


def is_scan_odometry(message: TFMessage) -> bool:
    """Return whether transforms come from mapping for a robot without odometry, not from the robot."""
    return any(each.header.frame_id == SCAN_ODOM for each in message.transforms)


def prefixed(prefix: str, frame: str) -> str:
    """Return the name of a frame with a prefix; a name with a slash, or an empty one, is unchanged."""
    return f"{prefix}/{frame}" if prefix and frame and "/" not in frame else frame


def unprefixed(frame: str) -> str:
    """Return the name of a frame without its prefix."""
    return frame.rpartition("/")[2]


class FrameListener:
    """Frames of a robot, as ``tf`` and ``tf_static`` say.

    Parameters
    ----------
    names : FrameNames, optional
        Names of the robot's frames.

    Attributes
    ----------
    tree : TransformTree
        Level frames over the last seconds.
    base : str
        Frame of the robot's body.
    """

    def __init__(self, names: FrameNames | None = None) -> None:
        self.names = names or FrameNames()
        self.base = self.names.base
        self.tree = TransformTree()
        self._body = LatestFrames()
        self._heard: dict[str, float] = {}
        self._moved: set[str] = set()

    def hear(self, topic: str, message: TFMessage, now: float, stamp: float | None = None) -> None:
        """Add the transforms of a message.

        A transform that is not valid is left out, as in tf2; the others are added.

        Parameters
        ----------
        topic : str
            ``tf`` or ``tf_static``.
        message : TFMessage
        now : float
            Time of arrival [s].
        stamp : float, optional
            Meaning of a stamp of zero [s]; the time of arrival by default.

        Raises
        ------
        TransformError
            A transform is not finite, has no frame, or closes a loop; the text says which.
        """
        errors = []
        for transform in message.transforms:
            try:
                self._add(transform, static=topic == TF_STATIC.name, now=now, stamp=now if stamp is None else stamp)
            except TransformError as error:
                errors.append(error)
        if errors:
            raise errors[0]

    def _add(self, transform: TransformStamped, *, static: bool, now: float, stamp: float) -> None:
        child = transform.child_frame_id.lstrip("/")
        if "/" in child and PERSON.fullmatch(child):
            return  # people come and go, and nothing of the robot is mounted on them
        if child not in self._heard and len(self._heard) >= MAX_FRAMES and child not in (self.base, self.names.odom):
            raise TransformError(f"transform of {child!r} is left out: a robot has at most {MAX_FRAMES} frames")
        try:
            level = is_level(transform.transform.rotation)
        except TransformError as error:
            parent = transform.header.frame_id.lstrip("/")
            raise TransformError(f"transform {parent!r} → {child!r} is left out: {error}") from error
        # Wheels and cameras are not level: they only matter where a laser is mounted on them.
        if level:
            self.tree.set_message(transform, static=static, now=stamp)
        before = self._body.newest(child)
        self._body.hear((transform,))
        self._heard[child] = now
        after = self._body.newest(child)
        if static:
            self._moved.discard(child)
        elif before is not None and after is not None and before.distance_to(after) + before.angle_to(after) > MOVED:
            self._moved.add(child)

    # -- where the robot is --------------------------------------------------------------------------------------------

    @property
    def odom(self) -> str:
        """Frame of the odometry: from the parameters, or else the parent of the highest frame that moves.

        Of a robot without odometry it is `SCAN_ODOM`, whatever the parameters name.
        """
        found = self.tree.moving_parent(self.base, MAP)
        return SCAN_ODOM if found == SCAN_ODOM else self.names.odom or found or ODOM

    @property
    def is_without_odometry(self) -> bool:
        """Whether the robot makes a map without odometry."""
        return self.odom == SCAN_ODOM

    def newest(self) -> float | None:
        """Return the stamp of the newest odometry [s]; None if there is none."""
        return self.tree.common_time(self.odom, self.base)

    def odometry(self, stamp: float | None = None) -> Pose2D:
        """Return the pose of the robot in the odometry frame, by default the newest.

        Raises
        ------
        TransformError
            There is no odometry, or not at that time.
        """
        return self.tree.lookup(self.odom, self.base, stamp)

    def in_map(self, stamp: float | None = None) -> Pose2D:
        """Return the pose of the robot in the frame of the map; raises as `odometry`."""
        return self.tree.lookup(MAP, self.base, stamp)

    def restart_localization(self) -> None:
        """Use the newest pose of the odometry in the map alone, not those before: the map is in another frame."""
        self.tree.keep_newest(self.odom)

    def mount(self, frame: str, now: float | None = None) -> Rigid:
        """Return the pose of a sensor in the robot's body; a sensor without a frame is at its origin.

        Parameters
        ----------
        frame : str
        now : float, optional
            Time by the executor's clock [s], for a check that the sensor is still there.

        Raises
        ------
        TransformError
            The frame is unknown, or not connected with the robot's body; or it has moved on the body, and its transform
            does not come any more.
        """
        name = frame.lstrip("/")
        if not name:
            return Rigid()
        known = self._known(name)
        pose = self._body.lookup(self.base, known)
        if now is not None and self._moved:
            self._check_moving(known, now)
        return pose

    def _check_moving(self, sensor: str, now: float) -> None:
        """Raise ``TransformError`` if a transform between the body and a sensor has moved it, and comes no more."""
        for child in self._body.between(self.base, sensor):
            if child in self._moved and self.silence(child, now) > CACHE_TIME:
                raise TransformError(
                    f"frame {child!r} moves on the robot, and its transform has not come for more than "
                    f"{CACHE_TIME:g} s: publish it on 'tf' all the time"
                )

    def height_of(self, frame: str) -> float:
        """Return the height of a frame of the body in the robot's frame [m]; 0 if it is unknown."""
        known = self._known(frame)
        return self._body.lookup(self.base, known).z if self._body.connected(self.base, known) else 0.0

    def knows(self, frame: str) -> bool:
        """Return whether a sensor is connected with the robot's body; one without a frame is at its origin."""
        name = frame.lstrip("/")
        return not name or self._body.connected(self.base, self._known(name))

    def root(self, frame: str, below: str = "") -> str:
        """Return the highest frame above a frame of the robot: it has no parent, or its parent is ``below``."""
        return self._body.root(self._known(frame.lstrip("/")), below)

    def _known(self, frame: str) -> str:
        """Return a frame by its name, with the prefix of the robot if it is known only with it."""
        full = prefixed(self.names.prefix, frame)
        return full if full != frame and not self._body.connected(self.base, frame) else frame

    # -- silence -------------------------------------------------------------------------------------------------------

    def silence(self, child: str, now: float) -> float:
        """Return the time since the last transform of a frame, by the executor's clock instead of the stamps [s]."""
        return now - self._heard.get(child, float("-inf"))

    def odometry_silence(self, now: float) -> float:
        """Return the time since the odometry last moved the robot's body, infinite if it never did [s]."""
        if self.is_without_odometry:
            return float("inf")
        try:
            moving = self.tree.moving_between(self.odom, self.base)
        except TransformError:
            return float("inf")
        return max((self.silence(child, now) for child in moving), default=float("inf"))

    def localization_silence(self, now: float) -> float:
        """Return the time since localization last published the odometry frame in the map, infinite if never [s]."""
        return self.silence(self.odom, now)


class LateFrames:
    """Frames of a robot for nodes that need them now and then: until then, the newest transforms are only kept.

    Parameters
    ----------
    names : FrameNames, optional
        Names of the robot's frames.
    """

    def __init__(self, names: FrameNames | None = None) -> None:
        self._frames = FrameListener(names)
        self._kept: dict[str, tuple[str, TransformStamped, float, float]] = {}

    def keep(self, topic: str, message: TFMessage, now: float, stamp: float) -> None:
        """Keep the transforms of a message; parameters as of `FrameListener.hear`."""
        for transform in message.transforms:
            child = transform.child_frame_id
            if child in self._kept or self._may_keep(child):
                self._kept[child] = topic, transform, now, stamp

    def _may_keep(self, child: str) -> bool:
        """Return whether there is room for another frame; people come and go, and are left out."""
        own = child.lstrip("/") in (self._frames.base, self._frames.names.odom)
        return (own or len(self._kept) < MAX_FRAMES) and not PERSON.fullmatch(child)

    def now(self) -> FrameListener:
        """Return the frames as all transforms so far say; those that are not valid are left out."""
        kept, self._kept = self._kept, {}
        for topic, transform, now, stamp in kept.values():
            with contextlib.suppress(TransformError):  # localization and Move Base have refused it already
                self._frames.hear(topic, TFMessage([transform]), now, stamp)
        return self._frames
