"""Action goals of one client, at actions of the clone and of other clients, and the frames about them.

Goals for the clone are published on the topics of the action, whose status and result become frames.
"""

from collections.abc import Callable

from engine.sessions.namespaces import with_hint
from engine.sessions.outbox import FrameOutbox, Sent
from engine.sessions.place.client_actions import GoalEnd, GoalListener
from engine.sessions.place.place import Place
from engine.sessions.unsettled import Posting
from ppaas.clock import epoch, monotonic
from ppaas.errors import Conflict, InvalidInput, NotFound, PPaaSError, QuotaExceeded, UnknownType
from ppaas.messages.base.message import Message
from ppaas.messages.base.spelling import to_ros2
from ppaas.nodes.base import DEFAULT_DEPTH
from ppaas.nodes.nav2_actions import PATH_GOALS
from ppaas.wire.actions import (
    CANCEL_GOAL,
    UNKNOWN_GOAL_ID,
    ActionAdapter,
    actions,
    cancel_message,
    cancel_response,
    cancelled_until,
    find_action,
    part_of_action,
    topics_of,
)
from ppaas.wire.arguments import as_object
from ppaas.wire.goals import MAX_GOALS, GoalFrame, GoalTracker, feedback_frame, refusal, result_frame
from ppaas.wire.names import is_ros2_type, ros1_type
from ppaas.wire.operations import CancelActionGoal, RefusedOperation, SendActionGoal
from ppaas.wire.rosbridge import RosbridgeSession


class SentGoals:
    """Goals of one client at actions of other clients.

    Parameters
    ----------
    place : Place
        Place of the robot.
    client : int
        Number of the client at the place.
    outbox : FrameOutbox
        Receives feedback.
    send : callable
        Called with a frame that must not be dropped, the size of its fragments, and a function to call once it is sent.
    posting : Posting
        Knows the origin of the frame that is executed.
    """

    def __init__(
        self,
        place: Place,
        client: int,
        outbox: FrameOutbox,
        send: Callable[[bytes, int, Sent | None], None],
        posting: Posting,
    ) -> None:
        self._posting = posting
        self._place = place
        self._client = client
        self._outbox = outbox
        self._send = send
        self._active: dict[int, SendActionGoal] = {}

    def start(self, operation: SendActionGoal, action: str) -> None:
        """Send a goal; it ends with exactly one result.

        Parameters
        ----------
        operation : SendActionGoal
        action : str
            Name of the action, resolved.

        Raises
        ------
        PPaaSError
            The goal was not sent.
        """
        self._posting.check_new()
        if len(self._active) >= MAX_GOALS:
            raise QuotaExceeded(
                f"a client may have at most {MAX_GOALS} active goals: wait for one to end, or cancel it"
            )
        if operation.id is not None and any(goal.id == operation.id for goal in self._active.values()):
            raise Conflict(f"goal {str(operation.id)[:64]!r} is still active: use a new id for each goal")
        kind = self._place.client_actions.types()[action]
        _check_type(action, operation.action_type, kind)
        payload = as_object(bytes(operation.args), _goal_fields(kind))
        respelled = self._place.client_actions.completes(action) and is_ros2_type(operation.action_type)

        def feedback(values: bytes) -> None:
            if operation.feedback:
                values = to_ros2(values) if respelled else values
                frame = feedback_frame(operation.action, operation.id, values)
                self._outbox.put(f"{action}/feedback", frame, DEFAULT_DEPTH)

        def done(end: GoalEnd) -> None:
            self._active.pop(number, None)
            if respelled and isinstance(end.result, bytes):
                end = end._replace(result=to_ros2(end.result))
            self._send(result_frame(operation.action, operation.id, *end), 0, settle)

        number = self._place.client_actions.send(action, payload, epoch(), GoalListener(self._client, feedback, done))
        settle = self._posting.unsettled.until_released()
        self._active[number] = operation

    def cancel(self, operation: CancelActionGoal) -> bool:
        """Cancel a goal; return whether there is one with this id."""
        for number, goal in self._active.items():
            if goal.id == operation.id:
                self._place.client_actions.cancel(number)
                return True
        return False


def _check_type(action: str, wanted: str, has: str) -> None:
    name, own = ros1_type(wanted).partition("/")[2].removesuffix("Action"), has.partition("/")[2]
    if name != own:
        raise InvalidInput(f"action {action!r} has type {own}, not {name}")


def _goal_fields(kind: str) -> type[Message] | None:
    try:
        return part_of_action(kind, "Goal")
    except UnknownType:
        return None  # goals of an unknown type must be objects, since the order of fields is not known


class ClientGoals:
    """Goals of one client, and the topics that are subscribed for them.

    Parameters
    ----------
    place : Place
        Place of the robot.
    client : int
        Number of the client at the place.
    wire : RosbridgeSession
        Knows the subscriptions of the client itself.
    outbox : FrameOutbox
        Receives feedback.
    send : callable
        Called with a frame that must not be dropped, the size of its fragments, and a function to call once it is sent.
    posting : Posting
        Publishes the goals.
    identity : str
        Name of the session among all sessions of the robot.
    """

    def __init__(
        self, place: Place, client: int, wire: RosbridgeSession, outbox: FrameOutbox,
        send: Callable[[bytes, int, Sent | None], None], *, posting: Posting, identity: str,
    ) -> None:  # fmt: skip
        self._place = place
        self._client = client
        self._wire = wire
        self._outbox = outbox
        self._send = send
        self._posting = posting
        self._goals = GoalTracker(identity)
        self._settling: dict[str, Sent] = {}
        self._sent = SentGoals(place, client, outbox, send, posting)
        self._topics: set[str] = set()

    def hears(self, topic: str) -> bool:
        """Return whether a topic is subscribed for a goal."""
        return topic in self._topics

    # -- from the client -----------------------------------------------------------------------------------------------

    def start(self, operation: SendActionGoal) -> None:
        """Send a goal; it always ends with exactly one result."""
        try:
            name = self._wire.names.callee(operation.action)
            if name in self._place.client_actions:
                self._sent.start(operation, name)
                return
            action = self._find(name, operation.action_type)
            self._count(f"{action.topics}/goal")
            goal, message = self._goals.send(operation, action, monotonic(), self._posting.unsettled.next_name())
        except PPaaSError as error:
            self._send(refusal(operation, error), 0, None)
            return
        self._settling[goal] = self._posting.unsettled.until_released()
        self._update_subscriptions()
        try:
            self._goals.posted(goal, self._post(f"{action.topics}/goal", message))
        except PPaaSError as error:
            self._forward(self._goals.give_up(goal, error))

    def _find(self, name: str, kind: str) -> ActionAdapter:
        topics = self._place.topic_types()
        try:
            return find_action(name, kind, topics)
        except NotFound as error:
            raise with_hint(error, name, [*actions(topics), *self._place.client_actions.types()]) from error

    def cancel(self, operation: CancelActionGoal) -> None:
        """Cancel a goal.

        Raises
        ------
        NotFound
            The client has no such active goal.
        QuotaExceeded
            Too many messages to the clone are unacknowledged.
        """
        if self._sent.cancel(operation):
            return
        action, message = self._goals.cancel(operation)
        self._post(f"{action}/cancel", message)

    def cancel_all(self, service: str, arguments: bytes) -> bytes | None:
        """Cancel all goals of an action, or those up to a stamp, and return the response.

        Returns
        -------
        bytes or None
            None if this is not a cancel service.

        Raises
        ------
        MalformedMessage
            The arguments are not those of a cancel service.
        NotFound
            The action does not exist.
        QuotaExceeded
            Too many messages to the clone are unacknowledged.
        """
        if not service.endswith(CANCEL_GOAL):
            return None
        name, message = service.removesuffix(CANCEL_GOAL), cancel_message(arguments)
        offered = name in self._place.client_actions
        action = name if offered else topics_of(name, self._place.topic_types())
        if message is None:
            return cancel_response(UNKNOWN_GOAL_ID)
        if offered:
            self._place.client_actions.cancel_all(action, cancelled_until(message))
        else:
            self._post(f"{action}/cancel", message)
        return cancel_response(0)

    def refuse(self, refused: RefusedOperation) -> None:
        """Answer a goal whose frame could not be read."""
        self._send(refusal(SendActionGoal(refused.name, "", refused.id), refused.error), 0, None)

    def _count(self, topic: str) -> None:
        if topic in PATH_GOALS:
            self._posting.count_plan()

    def _post(self, topic: str, message: bytes) -> int:
        return self._posting.post(topic, message, must_arrive=True)

    # -- from the place ------------------------------------------------------------------------------------------------

    def published(self, topic: str, payload: bytes) -> None:
        """Handle a message of a topic that is subscribed for a goal.

        Raises
        ------
        MalformedMessage
            It is not a valid message of an action.
        """
        for goal_frame in self._goals.hear(topic, payload, monotonic()):
            self._forward(goal_frame, topic)

    def refused(self, sequence: int, error: PPaaSError) -> None:
        """Handle the refusal of a message by the clone; if it was a goal, that goal ends."""
        goal_frame = self._goals.refused(sequence, error)
        if goal_frame is not None:
            self._forward(goal_frame)

    def _forward(self, goal_frame: GoalFrame, topic: str = "") -> None:
        if goal_frame.final:
            self._send(goal_frame.frame, 0, self._settling.pop(goal_frame.goal, None))
            self._update_subscriptions()
        else:
            self._outbox.put(topic, goal_frame.frame, DEFAULT_DEPTH)

    def _update_subscriptions(self) -> None:
        wanted = self._goals.topics()
        for topic in wanted - self._topics:
            self._place.subscribe(topic, self._client)
        for topic in self._topics - wanted:
            if not self._wire.hears(topic):
                self._place.unsubscribe(topic, self._client)
        self._topics = wanted
