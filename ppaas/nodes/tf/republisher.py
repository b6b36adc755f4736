"""Node ``tf2_web_republisher``: transforms for web pages, by service and by action.

``roslibpy`` and ``roslib`` 1 call the service to get a separate topic; ``roslib`` 2 sends a goal and receives
feedback.

A frame is published at first, and then whenever it has moved or turned by more than the threshold since it was last
published; with a threshold of zero, every time (``tf_pair.h`` of ``tf2_web_republisher``).
"""

import math
from collections.abc import Callable
from typing import ClassVar

import msgspec

from ppaas.decoding import from_json
from ppaas.errors import InvalidInput, QuotaExceeded, TransformError
from ppaas.messages.actionlib_msgs import GoalID, GoalStatus, GoalStatusArray, Status
from ppaas.messages.base.message import Message
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import TransformStamped
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.messages.tf2_web_republisher import (
    RepublishTFs,
    RepublishTFsRequest,
    RepublishTFsResponse,
    TFArray,
    TFSubscriptionActionFeedback,
    TFSubscriptionActionGoal,
    TFSubscriptionActionResult,
    TFSubscriptionFeedback,
    TFSubscriptionGoal,
)
from ppaas.navigation.action_goals import cancels
from ppaas.navigation.events import CancelReceived
from ppaas.nodes import topics
from ppaas.nodes.base import Context, Node, Payload, Reply, Service, Topic
from ppaas.transforms.spatial import LatestFrames, Rigid

# -- stream of transforms of some frames in another, which are published when they change ------------------------------

MAX_SOURCES = 100
"""Largest number of frames in a stream."""

MAX_FRAME_NAME = 255
"""Longest name of a frame [characters]."""

MIN_RATE, MAX_RATE = 0.1, 50.0
"""Limits of the rate of a stream [Hz]; higher rates are reduced to the highest."""


def check_wanted(goal: TFSubscriptionGoal) -> None:
    """Check that a request is valid.

    Raises
    ------
    InvalidInput
        There are too many frames, the name of one is empty or too long, or a threshold or rate is out of range.
    """
    if len(goal.source_frames) > MAX_SOURCES:
        raise InvalidInput(f"source_frames may have at most {MAX_SOURCES} frames, not {len(goal.source_frames)}")
    for frame in (*goal.source_frames, goal.target_frame):
        if not 0 < len(frame.lstrip("/")) <= MAX_FRAME_NAME:
            raise InvalidInput(f"the name of a frame must have 1 to {MAX_FRAME_NAME} characters, not {frame[:32]!r}")
    for name, value in (("angular_thres", goal.angular_thres), ("trans_thres", goal.trans_thres)):
        if not (math.isfinite(value) and value >= 0.0):
            raise InvalidInput(f"{name} must be finite and at least 0, not {value}")
    if not (math.isfinite(goal.rate) and goal.rate >= MIN_RATE):
        raise InvalidInput(f"rate must be at least {MIN_RATE:g} Hz, not {goal.rate}")


class TfStream:
    """Publishes transforms while its topic has subscribers.

    Parameters
    ----------
    context : Context
        The node's context.
    frames : LatestFrames
        Latest transforms of all frames.
    wanted : TFSubscriptionGoal
        Frames, thresholds and rate.
    topic : str
        Topic of the stream.
    patience : float
        Time for which the topic may have no subscribers [s].
    publish : callable
        Publishes transforms.
    abandoned : callable
        Called when that time has passed.

    Raises
    ------
    InvalidInput
        See ``check_wanted``.
    """

    def __init__(
        self, context: Context, frames: LatestFrames, wanted: TFSubscriptionGoal,
        *, topic: str, patience: float,
        publish: Callable[[list[TransformStamped]], None], abandoned: Callable[[], None],
    ) -> None:  # fmt: skip
        check_wanted(wanted)
        self._context = context
        self._frames = frames
        self._sources = [frame.lstrip("/") for frame in wanted.source_frames]
        self._target = wanted.target_frame.lstrip("/")
        self._turn, self._move = wanted.angular_thres, wanted.trans_thres
        self._topic = topic
        self._patience = patience
        self._publish = publish
        self._abandoned = abandoned
        self._last: dict[str, Rigid] = {}
        self._silence = 0.0
        self._period = 1.0 / min(wanted.rate, MAX_RATE)
        self._timer = context.every(self._period, self._look)

    def stop(self) -> None:
        """Stop the stream."""
        self._timer.stop()

    def _look(self) -> None:
        if not self._context.has_subscribers(self._topic):
            self._last.clear()  # the next subscriber receives all frames
            self._silence += self._period
            if self._silence >= self._patience:
                self._abandoned()
            return
        self._silence = 0.0
        moved = [transform for source in self._sources if (transform := self._moved(source)) is not None]
        if moved:
            self._publish(moved)

    def _moved(self, source: str) -> TransformStamped | None:
        try:
            pose = self._frames.lookup(self._target, source)
        except TransformError:
            return None  # it may appear later
        last = self._last.get(source)
        always = self._turn == 0.0 or self._move == 0.0
        if last is not None and not always and self._near(last, pose):
            return None
        self._last[source] = pose
        header = Header(stamp=Time.of(self._context.now()), frame_id=self._target)
        return TransformStamped(header, source, pose.to_message())

    def _near(self, last: Rigid, pose: Rigid) -> bool:
        return last.distance_to(pose) <= self._move and last.angle_to(pose) <= self._turn


# -- node ``tf2_web_republisher`` --------------------------------------------------------------------------------------

SERVICE = Service("republish_tfs", RepublishTFs)

MAX_STREAMS = 32
"""Largest number of topics and goals of one robot."""

MIN_PATIENCE, MAX_PATIENCE = 1.0, 60.0
"""Limits of the time for which a topic stays without subscribers (its ``timeout``) [s]; goals stay the longest."""


class TfRepublisherState(msgspec.Struct):
    """Checkpoint of the node."""

    count: int
    topics: dict[str, RepublishTFsRequest]
    goals: list[TFSubscriptionActionGoal]


class _Goal:
    """An active goal."""

    def __init__(self, message: TFSubscriptionActionGoal, stream: TfStream) -> None:
        self.message = message
        self.stream = stream
        self.id = message.goal_id.id
        self.stamp = message.goal_id.stamp.seconds()


class TfRepublisherNode(Node):
    """Publishes transforms at the requested rate, and only those that have changed. It is idle without requests.

    Parameters
    ----------
    context : Context
        The node's context.
    """

    name: ClassVar[str] = "tf2_web_republisher"
    subscribes: ClassVar[tuple[Topic, ...]] = (
        topics.TF, topics.TF_STATIC, topics.TF_REPUBLISHER_GOAL, topics.TF_REPUBLISHER_CANCEL,
    )  # fmt: skip
    publishes: ClassVar[tuple[Topic, ...]] = (
        topics.TF_REPUBLISHER_STATUS, topics.TF_REPUBLISHER_FEEDBACK, topics.TF_REPUBLISHER_RESULT,
    )  # fmt: skip
    services: ClassVar[tuple[Service, ...]] = (SERVICE,)

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._frames = LatestFrames()
        self._count = 0
        self._topics: dict[str, tuple[RepublishTFsRequest, TfStream]] = {}
        self._goals: dict[str, _Goal] = {}
        self._state: bytes | None = None

    def start(self) -> None:
        """Publish the status, which shows clients that the server is up."""
        self._publish_status()

    def on_message(self, topic: str, message: Payload) -> None:
        """Handle transforms, a goal or a cancel.

        Raises
        ------
        InvalidInput
            The goal is invalid.
        """
        match message:
            case TFMessage():
                self._frames.hear(message.transforms)
            case TFSubscriptionActionGoal():
                self._take_goal(message)
            case GoalID():
                self._cancel(CancelReceived(self.context.elapsed(), message.id, message.stamp.seconds()))

    def on_call(self, service: str, request: Message, reply: Reply) -> None:
        """Create a topic for the caller, and reply with its name.

        Raises
        ------
        InvalidInput
            The request is invalid.
        QuotaExceeded
            There are too many topics.
        """
        if not isinstance(request, RepublishTFsRequest):
            raise InvalidInput(f"service {service!r} does not accept {type(request).__name__}")
        check_wanted(request)
        self._make_room()
        topic = f"{self.name}/tf_repub_{self._count}"
        self._count += 1
        self._open(topic, request)
        reply(RepublishTFsResponse(f"/{topic}"))

    def _make_room(self) -> None:
        """End the oldest goal if there are too many streams, since clients do not cancel goals they no longer need."""
        if len(self._topics) + len(self._goals) < MAX_STREAMS:
            return
        if not self._goals:
            raise QuotaExceeded(f"a robot has at most {MAX_STREAMS} transform topics: unsubscribe from some first")
        self._end(next(iter(self._goals)), Status.ABORTED, "there are too many other goals and topics")

    # -- topics --------------------------------------------------------------------------------------------------------

    def _open(self, topic: str, request: RepublishTFsRequest) -> None:
        patience = min(max(request.timeout.seconds(), MIN_PATIENCE), MAX_PATIENCE)
        self.context.declare(self, Topic(topic, TFArray))
        stream = TfStream(
            self.context, self._frames, request, topic=topic, patience=patience,
            publish=lambda moved: self.context.publish(topic, TFArray(moved)), abandoned=lambda: self._close(topic),
        )  # fmt: skip
        self._topics[topic] = request, stream
        self._note()

    def _close(self, topic: str) -> None:
        _, stream = self._topics.pop(topic)
        stream.stop()
        self.context.undeclare(self, topic)
        self._note()

    # -- goals ---------------------------------------------------------------------------------------------------------

    def _take_goal(self, message: TFSubscriptionActionGoal) -> None:
        check_wanted(message.goal)
        if message.goal_id.id in self._goals:
            return  # sent again
        if not message.goal_id.id:
            message = msgspec.structs.replace(
                message, goal_id=GoalID(message.goal_id.stamp, f"{self.name}-{self._count}")
            )
            self._count += 1
        self._make_room()
        self._begin(message)
        self._publish_status()

    def _begin(self, message: TFSubscriptionActionGoal) -> None:
        status = GoalStatus(message.goal_id, Status.ACTIVE)
        stream = TfStream(
            self.context, self._frames, message.goal, topic=topics.TF_REPUBLISHER_FEEDBACK.name, patience=MAX_PATIENCE,
            publish=lambda moved: self._feedback(status, moved),
            abandoned=lambda: self._end(message.goal_id.id, Status.ABORTED, "no client subscribes to the feedback"),
        )  # fmt: skip
        self._goals[message.goal_id.id] = _Goal(message, stream)
        self._note()

    def _feedback(self, status: GoalStatus, moved: list[TransformStamped]) -> None:
        feedback = TFSubscriptionActionFeedback(self._header(), status, TFSubscriptionFeedback(moved))
        self.context.publish(topics.TF_REPUBLISHER_FEEDBACK.name, feedback)

    def _cancel(self, cancel: CancelReceived) -> None:
        for goal in [goal for goal in self._goals.values() if cancels(cancel, goal)]:
            self._end(goal.id, Status.PREEMPTED, "cancelled")

    def _end(self, goal_id: str, status: Status, text: str) -> None:
        goal = self._goals.pop(goal_id)
        goal.stream.stop()
        ended = GoalStatus(goal.message.goal_id, status, text)
        self.context.publish(topics.TF_REPUBLISHER_RESULT.name, TFSubscriptionActionResult(self._header(), ended))
        self._publish_status(ended)
        self._note()

    def _publish_status(self, *ended: GoalStatus) -> None:
        active = [GoalStatus(goal.message.goal_id, Status.ACTIVE) for goal in self._goals.values()]
        self.context.publish(topics.TF_REPUBLISHER_STATUS.name, GoalStatusArray(self._header(), [*ended, *active]))

    def _header(self) -> Header:
        return Header(stamp=Time.of(self.context.now()))

    # -- checkpoints ---------------------------------------------------------------------------------------------------

    def _note(self) -> None:
        topics = {topic: request for topic, (request, _) in self._topics.items()}
        goals = [goal.message for goal in self._goals.values()]
        self._state = msgspec.json.encode(TfRepublisherState(self._count, topics, goals)) if topics or goals else None

    def checkpoint(self) -> bytes | None:
        """Return the topics and goals as JSON, or None if there are none."""
        return self._state

    def restore(self, state: bytes) -> None:
        """Continue the topics and goals of a checkpoint under the same names."""
        known = from_json(state, TfRepublisherState)
        self._count = known.count
        for topic, request in known.topics.items():
            self._open(topic, request)
        for goal in known.goals:
            self._begin(goal)
        self._publish_status()
