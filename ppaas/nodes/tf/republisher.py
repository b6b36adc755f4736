"""Node ``tf2_web_republisher``: transforms for web pages, by service and by action.

``roslibpy`` and ``roslib`` 1 call the service to get a separate topic; ``roslib`` 2 sends a goal and receives
feedback.
"""

from typing import ClassVar

import msgspec

from ppaas.decoding import from_json
from ppaas.errors import InvalidInput, QuotaExceeded
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
)
from ppaas.navigation.action_goals import cancels
from ppaas.navigation.events import CancelReceived
from ppaas.nodes import topics
from ppaas.nodes.base import Context, Node, Payload, Reply, Service, Topic
from ppaas.nodes.tf.stream import TfStream, check_wanted
from ppaas.transforms.spatial import LatestFrames

SERVICE = Service("republish_tfs", RepublishTFs)

MAX_STREAMS = 32
"""Largest number of topics and goals of one robot."""

MIN_PATIENCE, MAX_PATIENCE = 1.0, 60.0
"""Limits of the time for which a topic stays without subscribers (its ``timeout``) [s]; goals stay the longest."""


class _State(msgspec.Struct):
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
        self._state = msgspec.json.encode(_State(self._count, topics, goals)) if topics or goals else None

    def checkpoint(self) -> bytes | None:
        """Return the topics and goals as JSON, or None if there are none."""
        return self._state

    def restore(self, state: bytes) -> None:
        """Continue the topics and goals of a checkpoint under the same names."""
        known = from_json(state, _State)
        self._count = known.count
        for topic, request in known.topics.items():
            self._open(topic, request)
        for goal in known.goals:
            self._begin(goal)
        self._publish_status()
