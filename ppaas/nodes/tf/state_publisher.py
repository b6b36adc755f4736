"""Node ``robot_state_publisher``: publishes the robot's frames, from its odometry and its model.

A robot's odometry names the frame that it moves: ``base_link``, ``base_footprint``, ``robot1/base_link`` or another.
The robot is driven in one frame, ``base_link`` or the one of ``base_frame_id``. Where the robot's own transforms do not
connect the two, its URDF does, or else they are the same frame seen from above (REP 120).
"""

import logging
import re
from collections.abc import Iterable, Iterator
from contextlib import suppress
from typing import ClassVar

import msgspec

from ppaas.decoding import from_json
from ppaas.errors import TransformError
from ppaas.geometry import Pose2D
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import TransformStamped
from ppaas.messages.nav_msgs import Odometry
from ppaas.messages.tf2_msgs import MAX_FRAMES, TFMessage
from ppaas.nodes.base import Context, Node, Payload, Topic
from ppaas.nodes.frames import BASE_FOOTPRINT, BASE_LINK, MAP, FrameNames, is_scan_odometry, prefixed, unprefixed
from ppaas.nodes.frames import ODOM as ODOM_FRAME
from ppaas.nodes.message_checks import expect, finite_pose
from ppaas.nodes.tf.urdf_text import UrdfText
from ppaas.nodes.topics import ODOM, ROBOT_DESCRIPTION, TF, TF_STATIC
from ppaas.parameters import Parameters
from ppaas.robot_model.known_models import RobotModel
from ppaas.transforms.planar import transform_message
from ppaas.transforms.spatial import LatestFrames, Rigid

logger = logging.getLogger(__name__)

# -- frames of a robot's body, by its model, and how they join with the frames that the robot itself names -------------

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


# -- transforms that a robot sends itself ------------------------------------------------------------------------------

KEPT = 200
"""Largest number of static frames in a checkpoint."""

FRESH = 1.0
"""Time after a transform for which the robot's ``tf`` counts as the source of its frame [s]."""


class RobotTransforms:
    """Transforms that a robot sends itself."""

    def __init__(self) -> None:
        self._static: dict[str, tuple[str, Rigid]] = {}
        self._moved: dict[str, float] = {}
        self._state: bytes | None = None

    def note_static(self, transforms: Iterable[TransformStamped]) -> None:
        """Note static transforms; those that are not rigid are ignored."""
        for child, each, pose in _rigid(transforms):
            if child in self._static or len(self._static) < KEPT:
                self._static[child] = each.header.frame_id.lstrip("/"), pose
        self._state = msgspec.json.encode([(child, *known) for child, known in self._static.items()])

    def note_moving(self, transforms: Iterable[TransformStamped], now: float) -> None:
        """Note transforms that arrived at a time [s]; those that are not rigid move nothing."""
        for child, _, _ in _rigid(transforms):
            if child in self._moved or len(self._moved) < MAX_FRAMES:
                self._moved[child] = now

    def moves(self, child: str, now: float) -> bool:
        """Return whether the robot's ``tf`` moves a frame now [s]."""
        return now - self._moved.get(child, float("-inf")) <= FRESH

    def state(self) -> bytes | None:
        """Return the static transforms as JSON, None without any."""
        return self._state

    def restore(self, state: bytes) -> list[TransformStamped]:
        """Note the static transforms of a `state`, and return them."""
        for child, parent, pose in from_json(state, list[tuple[str, str, Rigid]]):
            self._static[child] = parent, pose
        self._state = state
        return [
            TransformStamped(Header(frame_id=parent), child, pose.to_message())
            for child, (parent, pose) in self._static.items()
        ]


def _rigid(transforms: Iterable[TransformStamped]) -> Iterator[tuple[str, TransformStamped, Rigid]]:
    """Yield the transforms that are rigid, with the name of the child."""
    for each in transforms:
        with suppress(TransformError):
            yield each.child_frame_id.lstrip("/"), each, Rigid.of(each.transform)


# -- node ``robot_state_publisher`` ------------------------------------------------------------------------------------


class StatePublisherParameters(Parameters, frozen=True):
    """Parameters of the state publisher.

    Parameters
    ----------
    laser_frame : str
        Frame of the robot's scans; empty for its model's frame.
    """

    laser_frame: str = ""


class StatePublisherNode(Node):
    """Publishes the frame of each odometry message on ``tf``, and the frames of the robot's body on ``tf_static``.

    It replaces ROS's robot_state_publisher and the transform broadcaster of the base driver, so that a small robot only
    has to send its odometry. A stamp of zero means now. A robot that publishes the transform of its odometry itself is
    believed: then its odometry messages only give its velocity, as in ROS.

    Odometry without frames moves the robot's body in its odometry frame. Whatever its frames are called, they are
    joined with the frame in which the robot is driven (`ppaas.nodes.tf.state_publisher`).

    Parameters
    ----------
    context : Context
        The node's context.
    model : RobotModel
        Model of the robot.
    parameters : StatePublisherParameters
    names : FrameNames, optional
        Names of the robot's frames.
    urdf : UrdfText, optional
        URDF of the robot, to be published on ``robot_description``.
    """

    name: ClassVar[str] = "robot_state_publisher"
    subscribes: ClassVar[tuple[Topic, ...]] = (ODOM, TF, TF_STATIC)
    publishes: ClassVar[tuple[Topic, ...]] = (TF, TF_STATIC, ROBOT_DESCRIPTION)

    def __init__(
        self,
        context: Context,
        model: RobotModel,
        parameters: StatePublisherParameters,
        names: FrameNames | None = None,
        urdf: UrdfText | None = None,
    ) -> None:
        super().__init__(context)
        self._names = names or FrameNames()
        self._body = BodyFrames(model, parameters.laser_frame, self._names)
        self._robot = RobotTransforms()
        self._own: list[TFMessage] = []
        self._urdf = urdf

    def start(self) -> None:
        """Publish the static transforms of the robot's body, and its URDF."""
        if self._urdf is not None:
            self.context.publish(ROBOT_DESCRIPTION.name, self._urdf)
        self._publish_static(self._body.at_start())

    def on_message(self, topic: str, message: Payload) -> None:
        """Handle odometry or transforms.

        Raises
        ------
        InvalidInput
            A number is not finite, or the orientation is all zero.
        TransformError
            The odometry belongs to a sensor, and nothing says where on the robot it is.
        """
        if topic == ODOM.name:
            self._on_odometry(expect(message, Odometry))
            return
        transforms = expect(message, TFMessage)
        if is_scan_odometry(transforms):
            return  # it ends with the first odometry of the robot, which is published below
        if any(transforms is own for own in self._own):
            self._own = [own for own in self._own if own is not transforms]
            return
        self._body.hear(transforms.transforms, static=topic == TF_STATIC.name)
        if topic == TF_STATIC.name:
            self._robot.note_static(transforms.transforms)
        else:
            self._robot.note_moving(transforms.transforms, self.context.elapsed())
            self._publish_static(self._body.joints_of_transforms(transforms.transforms))

    def _on_odometry(self, odometry: Odometry) -> None:
        pose = finite_pose(odometry.pose.pose, "odometry")
        parent = odometry.header.frame_id.lstrip("/") or self._names.odom or prefixed(self._names.prefix, ODOM_FRAME)
        child = odometry.child_frame_id.lstrip("/") or self._names.base
        if not self._robot.moves(child, self.context.elapsed()):
            self._publish_odometry(parent, child, pose, odometry.header.stamp)
        self._publish_static(self._body.joints_of_odometry(child, self.context.elapsed()))

    def _publish_odometry(self, parent: str, child: str, pose: Pose2D, stamp: Time) -> None:
        moment = Time.of(self.context.now()) if stamp == Time() else stamp
        self._publish(TF, TFMessage([transform_message(parent, child, pose, moment)]))

    def _publish_static(self, transforms: list[TransformStamped]) -> None:
        if transforms:
            stamp = Time.of(self.context.now())
            for each in transforms:
                each.header.stamp = stamp
            self._publish(TF_STATIC, TFMessage(transforms))

    def _publish(self, topic: Topic, message: TFMessage) -> None:
        self._body.hear(message.transforms, static=topic is TF_STATIC)
        self._own.append(message)
        self.context.publish(topic.name, message)

    # -- checkpoints ---------------------------------------------------------------------------------------------------

    def checkpoint(self) -> bytes | None:
        """Return the static transforms that the robot has sent as JSON, which it does only once; None without any."""
        return self._robot.state()

    def restore(self, state: bytes) -> None:
        """Publish the static transforms of a checkpoint again."""
        self._publish_static(self._robot.restore(state))
