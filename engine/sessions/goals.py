"""Action goals of one client: publishes them to the topics of an action, and turns status and result into frames."""

from collections.abc import Callable

from engine.sessions.namespaces import with_hint
from engine.sessions.outbox import FrameOutbox, Sent
from engine.sessions.place.place import Place
from engine.sessions.posting import Posting
from engine.sessions.sent_goals import SentGoals
from ppaas.clock import monotonic
from ppaas.errors import NotFound, PPaaSError
from ppaas.nodes.base import DEFAULT_DEPTH
from ppaas.nodes.nav2_actions import PATH_GOALS
from ppaas.wire.actions import (
    CANCEL_GOAL,
    UNKNOWN_GOAL_ID,
    Action,
    actions,
    cancel_message,
    cancel_response,
    cancelled_until,
    find_action,
    topics_of,
)
from ppaas.wire.goals import GoalFrame, GoalTracker, refusal
from ppaas.wire.operations import CancelActionGoal, RefusedOperation, SendActionGoal
from ppaas.wire.rosbridge import RosbridgeSession


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

    def _find(self, name: str, kind: str) -> Action:
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
        """Subscribe to the topics of the active goals, and unsubscribe from those no longer needed."""
        wanted = self._goals.topics()
        for topic in wanted - self._topics:
            self._place.subscribe(topic, self._client)
        for topic in self._topics - wanted:
            if not self._wire.hears(topic):
                self._place.unsubscribe(topic, self._client)
        self._topics = wanted
