"""Actions, as one client uses them: goals go to the topics of an action, and what these tell becomes frames."""

from collections.abc import Callable

from endpoints.rosbridge.outbox import Outbox
from engine.service.links.place_link import PlaceLink
from ppaas.clock import monotonic
from ppaas.errors import PPaaSError
from ppaas.nodes.base import DEFAULT_DEPTH
from ppaas.wire.actions import find_action
from ppaas.wire.goals import GoalFrame, GoalTracker, refusal
from ppaas.wire.names import normalise
from ppaas.wire.operations import CancelActionGoal, SendActionGoal
from ppaas.wire.rosbridge import RosbridgeSession

CANCEL_ALL = "/_action/cancel_goal"
"""A service of every action in ROS 2; ``roslib`` calls it, without arguments, to cancel all goals."""


class ClientGoals:
    """The goals of one client, and the topics that are heard for them.

    Parameters
    ----------
    place : PlaceLink
        Of the robot.
    client : int
        Number of the client there.
    wire : RosbridgeSession
        Knows what the client itself hears.
    outbox : Outbox
        Takes feedback.
    send : callable
        Takes a frame that must arrive.
    """

    def __init__(
        self, place: PlaceLink, client: int, wire: RosbridgeSession, outbox: Outbox, send: Callable[[bytes], None]
    ) -> None:
        self._place = place
        self._client = client
        self._wire = wire
        self._outbox = outbox
        self._send = send
        self._goals = GoalTracker(f"goal-{client}")
        self._topics: set[str] = set()

    def hears(self, topic: str) -> bool:
        """Tell whether a topic is heard because of a goal."""
        return topic in self._topics

    # -- from the client -----------------------------------------------------------------------------------------------

    def start(self, operation: SendActionGoal) -> None:
        """Send a goal; it ends with one result, whatever becomes of it."""
        try:
            action = find_action(normalise(operation.action), operation.action_type, self._place.topic_types())
            goal, message = self._goals.send(operation, action, monotonic())
        except PPaaSError as error:
            self._send(refusal(operation, error))
            return
        self._listen()
        try:
            self._goals.posted(goal, self._publish(f"{action.topics}/goal", message))
        except PPaaSError as error:
            self._tell(self._goals.give_up(goal, error))

    def cancel(self, operation: CancelActionGoal) -> None:
        """Cancel a goal.

        Raises
        ------
        NotFound
            The client has no such goal under way.
        QuotaExceeded
            Too much waits to reach the clone.
        """
        action, message = self._goals.cancel(operation)
        self._publish(f"{action}/cancel", message)

    def cancel_all(self, service: str) -> bytes | None:
        """Answer a call that cancels all goals of an action; None if this service does something else.

        Raises
        ------
        NotFound
            There is no such action.
        QuotaExceeded
            Too much waits to reach the clone.
        """
        if not service.endswith(CANCEL_ALL):
            return None
        self._publish(f"{service.removesuffix(CANCEL_ALL)}/cancel", b"{}")
        return b'{"return_code":0,"goals_canceling":[]}'

    def _publish(self, topic: str, message: bytes) -> int:
        return self._place.publish(topic, message, self._client, must_arrive=True)

    # -- from the place ------------------------------------------------------------------------------------------------

    def published(self, topic: str, payload: bytes) -> None:
        """Take a message of one of the topics that are heard because of a goal.

        Raises
        ------
        MalformedMessage
            It is not what an action says.
        """
        for told in self._goals.hear(topic, payload, monotonic()):
            self._tell(told, topic)

    def refused(self, sequence: int, error: PPaaSError) -> None:
        """Learn that the clone did not take a message: if it was a goal, that goal ends."""
        told = self._goals.refused(sequence, error)
        if told is not None:
            self._tell(told)

    def _tell(self, told: GoalFrame, topic: str = "") -> None:
        if told.final:
            self._send(told.frame)
            self._listen()
        else:
            self._outbox.put(topic, told.frame, DEFAULT_DEPTH)

    def _listen(self) -> None:
        """Hear what tells of the goals under way, and no more."""
        wanted = self._goals.topics()
        for topic in wanted - self._topics:
            self._place.subscribe(topic, self._client)
        for topic in self._topics - wanted:
            if not self._wire.hears(topic):
                self._place.unsubscribe(topic, self._client)
        self._topics = wanted
