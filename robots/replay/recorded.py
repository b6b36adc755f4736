"""Recorded drives: what a robot and its operators sent, and how to set up their clone again."""

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from operator import itemgetter
from pathlib import Path
from typing import NamedTuple

import msgspec

from ppaas.decoding import from_json
from ppaas.errors import InvalidInput, PPaaSError
from ppaas.maps.grid import GridMap
from ppaas.maps.occupancy import from_message
from ppaas.messages import decode
from ppaas.messages.base.message import Message
from ppaas.messages.geometry_msgs import PoseWithCovarianceStamped
from ppaas.messages.nav_msgs import OccupancyGrid
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.nodes import topics
from ppaas.recording.parameters import NAME
from ppaas.recording.reader import McapDecoder
from ppaas.recording.reader import RecordedMessage as McapMessage
from ppaas.recording.writer import DIRECTION, DOWN, ROBOT_FILE
from robots.client.robot_file import RobotFile
from robots.recordings.bag import ROS_ENCODINGS, Bag
from robots.replay.outcomes import COMPARED, Outcomes

INPUTS = frozenset(
    topic.name
    for topic in (
        topics.SCAN, topics.ECHOES, topics.ODOM, topics.TF, topics.TF_STATIC, topics.INITIAL_POSE, topics.SIMPLE_GOAL,
        topics.GOAL_POSE, topics.MOVE_BASE_GOAL, topics.GOAL_UPDATE, topics.MOVE_BASE_GOAL_UPDATE,
        topics.MOVE_BASE_CANCEL, topics.WAYPOINTS_GOAL, topics.WAYPOINTS_CANCEL, topics.SPEED_LIMIT, topics.PEOPLE,
        topics.DETECTIONS, topics.DEPTH_IMAGE, topics.COMPRESSED_DEPTH_IMAGE, topics.DEPTH_CAMERA_INFO,
        topics.CLOUD_IN,
    )
)  # fmt: skip
"""Topics that are sent to the clone again."""

ENCODINGS = (*ROS_ENCODINGS, "json")
"""Encodings of messages that are read."""

MAPS = frozenset({"map"})
"""Parents of transforms that the clone of a replay publishes itself."""


class Input(NamedTuple):
    """Message to send, and its time since the begin of the recording [s]."""

    after: float
    topic: str
    message: Message


@dataclass(slots=True)
class Recorded:
    """A recording, read once.

    Parameters
    ----------
    path : Path
    renamed : mapping of str to str
        Names of topics in the file, and the clone's names in their place.

    Attributes
    ----------
    grid : GridMap or None
        The last map in the file.
    file : RobotFile or None
        The robot file of the recorded robot; its map is the recorded cloud's.
    outcomes : Outcomes
        What the recorded clone said.
    counts : Counter of str
        Number of messages to send, by topic.
    skipped : Counter of str
        Number of messages that cannot be read, by topic and reason.
    seconds : float
        Length of the recording [s].
    notes : list of str
        What of the file could not be read, as where it was cut off.
    """

    path: Path
    renamed: Mapping[str, str] = field(default_factory=dict)
    grid: GridMap | None = None
    file: RobotFile | None = None
    outcomes: Outcomes = field(default_factory=Outcomes)
    counts: Counter[str] = field(default_factory=Counter)
    skipped: Counter[str] = field(default_factory=Counter)
    seconds: float = 0.0
    notes: list[str] = field(default_factory=list)
    _start: int = 0
    _newest: int = 0
    _in_order: bool = True
    _heard: list[tuple[int, str, Message]] = field(default_factory=list)
    _first_pose: tuple[float, float, float] | None = None

    def read(self) -> "Recorded":
        """Read the file, and return this object; it blocks.

        Raises
        ------
        InvalidInput
            The file cannot be read, is damaged, or has nothing to send.
        """
        decoder, bag = McapDecoder(), Bag(self.path)
        for message in bag.messages():
            self._note(message, decoder)
        self.seconds = (self._newest - self._start) / 1e9
        for at, topic, found in sorted(self._heard, key=itemgetter(0)):
            self.outcomes.take(topic, found, (at - self._start) / 1e9)
        self.notes = bag.notes(ENCODINGS)
        self.skipped = decoder.skipped
        self.file = _robot_file(bag.attachments.get(ROBOT_FILE))
        if not self.counts:
            raise InvalidInput(
                f"{self.path} has nothing to send to a clone: none of its messages is on {', '.join(sorted(INPUTS))}, "
                f"or of their types; name other topics by --rename. Its topics are: {bag.contents()}"
            )
        return self

    def inputs(self) -> Iterator[Input]:
        """Yield what is to be sent, in the order of time; raises as ``read``.

        Chunks of MCAP may overlap in time: then all messages are in memory at once.
        """
        inputs = self._inputs()
        yield from inputs if self._in_order else sorted(inputs, key=itemgetter(0))

    def _inputs(self) -> Iterator[Input]:
        """Yield what is to be sent, in the order of the file."""
        decoder = McapDecoder()
        for message in Bag(self.path).messages():
            topic = self._topic(message)
            if topic in INPUTS and _is_input(message):
                found = _decoded(topic, message, decoder)
                if found is not None:
                    yield Input((message.log_time - self._start) / 1e9, topic, found)

    @property
    def initial_pose(self) -> tuple[float, float, float] | None:
        """First estimate of the pose in the file; None if it has none."""
        return self._first_pose

    def _note(self, message: McapMessage, decoder: McapDecoder) -> None:
        topic = self._topic(message)
        if not self._start or (topic != topics.TF_STATIC.name and message.log_time):
            self._start = min(self._start or message.log_time, message.log_time)
        self._in_order = self._in_order and message.log_time >= self._newest
        self._newest = max(self._newest, message.log_time)
        if topic in INPUTS and _is_input(message):
            if _decoded(topic, message, decoder) is not None:
                self.counts[topic] += 1
        elif topic in COMPARED or topic == topics.MAP.name:
            found = _decoded(topic, message, decoder)
            if isinstance(found, OccupancyGrid):
                self.grid = from_message(found)
            elif found is not None:
                self._heard.append((message.log_time, topic, found))
                if isinstance(found, PoseWithCovarianceStamped) and self._first_pose is None:
                    pose = found.pose.pose.planar()
                    self._first_pose = (pose.x, pose.y, pose.theta)

    def _topic(self, message: McapMessage) -> str:
        name = message.channel.topic.lstrip("/")
        return self.renamed.get(name, name)


def _is_input(message: McapMessage) -> bool:
    return message.channel.metadata.get(DIRECTION) != DOWN


def _decoded(topic: str, message: McapMessage, decoder: McapDecoder) -> Message | None:
    """Return a message as the clone's topic has it; None if it is none, or has nothing to say."""
    payload = decoder.json(message)
    if payload is None:
        return None
    try:
        found = decode(topics.TOPICS[topic].type, payload)
    except PPaaSError as error:
        decoder.skip(message, str(error))
        return None
    if isinstance(found, TFMessage) and topic == topics.TF.name:
        found.transforms = [each for each in found.transforms if each.header.frame_id.lstrip("/") not in MAPS]
        return found if found.transforms else None
    return found


def _robot_file(attachment: bytes | None) -> RobotFile | None:
    """Return the robot file of a recording, without the parameters of its recorder; None if there is none."""
    if attachment is None:
        return None
    try:
        file = from_json(attachment, RobotFile)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError, ValueError) as error:
        raise InvalidInput(f"the robot file in the recording is invalid: {error}") from error
    others = {name: values for name, values in file.parameters.items() if name != NAME}
    return msgspec.structs.replace(file, parameters=others, cores=1.0, labels={})
