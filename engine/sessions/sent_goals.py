"""Goals that a client sent to actions of other clients."""

from collections.abc import Callable

from engine.sessions.outbox import FrameOutbox, Sent
from engine.sessions.place.client_actions import GoalEnd, GoalListener
from engine.sessions.place.place import Place
from engine.sessions.posting import Posting
from ppaas.clock import epoch
from ppaas.errors import Conflict, InvalidInput, QuotaExceeded, UnknownType
from ppaas.messages.base.message import Message
from ppaas.messages.base.spelling import to_ros2
from ppaas.nodes.base import DEFAULT_DEPTH
from ppaas.wire.actions import part_of_action
from ppaas.wire.arguments import as_object
from ppaas.wire.goals import MAX_GOALS, feedback_frame, result_frame
from ppaas.wire.names import is_ros2_type, ros1_type
from ppaas.wire.operations import CancelActionGoal, SendActionGoal


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
