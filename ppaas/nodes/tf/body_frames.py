"""Frames of a robot's body, by its model, and how they join with the frames that the robot itself names.

A robot's odometry names the frame that it moves: ``base_link``, ``base_footprint``, ``robot1/base_link`` or another.
The robot is driven in one frame, ``base_link`` or the one of ``base_frame_id``. Where the robot's own transforms do not
connect the two, its URDF does, or else they are the same frame seen from above (REP 120).
"""

import logging
import re
from collections.abc import Iterable

from ppaas.errors import TransformError
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.geometry_msgs import TransformStamped
from ppaas.messages.tf2_msgs import MAX_FRAMES
from ppaas.nodes.frames import BASE_FOOTPRINT, BASE_LINK, MAP, FrameNames, prefixed, unprefixed
from ppaas.robot_model.known_models import RobotModel
from ppaas.transforms.spatial import LatestFrames, Rigid

logger = logging.getLogger(__name__)

BASES = (BASE_LINK, BASE_FOOTPRINT)

NOT_BODY = frozenset({"world", "map", "odom", "odom_combined", "earth"})
"""Links of a URDF that are not part of the robot: simulators fix it to them, and they are above it in ``tf``."""

GRACE = 1.0
"""Time in which a robot may publish its static transforms after its first odometry [s]."""

_SENSOR = re.compile(r"camera|imu|laser|lidar|scan|gps|gnss|optical|t265|zed|tracking")
"""Names of frames that are not the body of a robot, such as the frame of a camera that measures odometry."""


class BodyFrames:
    """Static transforms to publish for a robot.

    Parameters
    ----------
    model : RobotModel
        Model of the robot, with the frames of its URDF.
    laser_frame : str
        Frame of the robot's scans; empty for its model's frame.
    names : FrameNames
        Names of the robot's frames.
    """

    def __init__(self, model: RobotModel, laser_frame: str, names: FrameNames) -> None:
        self._names = names
        self._model = model.frames_with(laser_frame)
        self._frames = LatestFrames()
        self._moved: set[str] = set()
        self._prefix = ""
        self._warned = False
        self._refusing: tuple[str, float] = "", 0.0

    def hear(self, transforms: Iterable[TransformStamped], *, static: bool) -> None:
        """Note transforms of any node. Those within the robot's body join frames; others move the robot."""
        for each in transforms:
            parent, child = each.header.frame_id.lstrip("/"), each.child_frame_id.lstrip("/")
            if static or unprefixed(parent) in BASES:
                self._frames.hear((each,))
            elif child in self._moved or unprefixed(child) in BASES:
                self._frames.forget(child)
            elif parent != MAP:
                self._frames.hear((each,))

    def at_start(self) -> list[TransformStamped]:
        """Return the transforms that are known before the robot has sent anything.

        The frames on the ground are not among them: a robot may call either the parent of the other.
        """
        found = self._on_body(self._names.prefix)
        if self._names.map != MAP:
            found.append(_transform(self._names.map, MAP, Rigid()))
        return found

    def joints_of_transforms(self, transforms: Iterable[TransformStamped]) -> list[TransformStamped]:
        """Return transforms that join the base of a robot that publishes ``tf`` but no odometry."""
        return [
            joint
            for each in transforms
            if unprefixed(each.child_frame_id) in BASES and unprefixed(each.header.frame_id) not in (*BASES, MAP)
            for joint in self._joints(each.child_frame_id.lstrip("/"))
        ]

    def joints_of_odometry(self, child: str, now: float) -> list[TransformStamped]:
        """Return transforms that join the frame of the odometry with the robot's body, none if they are joined.

        Raises
        ------
        TransformError
            The frame is a sensor's, and for `GRACE` nothing has said where on the robot it is.
        """
        if len(self._moved) < MAX_FRAMES:
            self._moved.add(child)
        self._frames.forget(child)
        if not _SENSOR.search(unprefixed(child).lower()) or child in (self._names.base, *self._model):
            return self._joints(child)
        if self._frames.connected(child, self._names.base):
            return []
        if self._refusing[0] != child:
            self._refusing = child, now
        if now - self._refusing[1] < GRACE:
            return []
        raise TransformError(
            f"the odometry moves frame {child!r}, which no transform connects with {self._names.base!r}: publish on "
            f"'tf_static' where it is on the robot, or set base_frame_id of amcl to {child!r}"
        )

    def _joints(self, child: str) -> list[TransformStamped]:
        prefix = child.rpartition("/")[0]
        found = []
        for frame in dict.fromkeys((BASE_LINK, self._names.base)):
            if not self._frames.connected(child, frame):
                found.append(self._joint(child, frame))
                self.hear(found[-1:], static=True)
        if prefix and prefix != self._prefix:
            self._prefix = prefix
            found += [each for each in self._on_body(prefix) if not self._frames.connected(child, each.child_frame_id)]
        return found

    def _joint(self, child: str, frame: str) -> TransformStamped:
        """Return a transform of the highest frame above ``frame`` to ``child``, by the model or as one seen from above.

        The highest frame is joined, so that the transforms that the robot has sent stay valid.
        """
        upper, lower = self._model.get(unprefixed(child)), self._model.get(unprefixed(frame))
        pose = upper.inverse() @ lower if upper is not None and lower is not None else Rigid()
        if unprefixed(child) not in BASES:
            level, self._warned = logging.DEBUG if self._warned else logging.WARNING, True
            logger.log(
                level,
                "the odometry moves frame %r, which no transform connects with %r: both are taken as the same frame",
                child, frame,
            )  # fmt: skip
        root = self._frames.root(frame)
        return _transform(child, root, pose @ self._frames.lookup(root, frame).inverse())

    def _on_body(self, prefix: str) -> list[TransformStamped]:
        """Return the frames of the model on ``base_link``, with a prefix."""
        base = self._model.get(BASE_LINK, Rigid()).inverse()
        return [
            _transform(BASE_LINK, prefixed(prefix, name), base @ pose)
            for name, pose in self._model.items()
            if name not in BASES and name not in NOT_BODY
        ]


def _transform(parent: str, child: str, pose: Rigid) -> TransformStamped:
    return TransformStamped(Header(frame_id=parent), child, pose.to_message())
