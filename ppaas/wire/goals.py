"""Goals that one client has sent by ``send_action_goal``, each of which ends exactly once, and frames about goals.

Each goal gets an id that is unique among all clients, since clients count their own goals from one. Results and
feedback come from the topics of the action. As a result may be lost with a container, the statuses are watched too (see
`ppaas.navigation.goal_watch`).
"""

from collections.abc import Iterator
from dataclasses import dataclass

import msgspec

from ppaas.errors import Conflict, NotFound, PPaaSError, QuotaExceeded, Unavailable
from ppaas.messages.actionlib_msgs import GoalStatus, GoalStatusArray, Status
from ppaas.messages.base.message import Message
from ppaas.messages.base.spelling import to_ros2
from ppaas.messages.codec import decode
from ppaas.navigation.goal_watch import GoalWatch, status_of
from ppaas.wire.actions import UNKNOWN, ActionAdapter, SentGoal, ros2_status
from ppaas.wire.operations import CancelActionGoal, Id, SendActionGoal

_encoder = msgspec.json.Encoder()


# -- frames about goals of actions, as the cloud sends them to the client that executes a goal or that sent it ---------


class _SendActionGoal(msgspec.Struct, tag_field="op", tag="send_action_goal"):
    id: str
    action: str
    action_type: str
    args: msgspec.Raw
    feedback: bool = True


class _CancelActionGoal(msgspec.Struct, tag_field="op", tag="cancel_action_goal"):
    id: str
    action: str


class _ActionFeedback(msgspec.Struct, tag_field="op", tag="action_feedback"):
    action: str
    values: msgspec.Raw
    id: Id


class _ActionResult(msgspec.Struct, tag_field="op", tag="action_result"):
    action: str
    values: msgspec.Raw | str
    status: int
    result: bool
    id: Id


def goal_frame(action: str, action_type: str, goal: int, arguments: bytes) -> bytes:
    """Return the frame that asks a client to execute a goal; action and type are spelled as the client did."""
    return _encoder.encode(_SendActionGoal(str(goal), action, action_type, msgspec.Raw(arguments)))


def cancel_frame(action: str, goal: int) -> bytes:
    """Return the frame that asks a client to cancel a goal that it executes."""
    return _encoder.encode(_CancelActionGoal(str(goal), action))


def feedback_frame(action: str, goal: Id, values: bytes) -> bytes:
    """Return the frame with feedback for the client that sent a goal."""
    return _encoder.encode(_ActionFeedback(action, msgspec.Raw(values), goal))


def result_frame(action: str, goal: Id, status: int, result: bytes | PPaaSError) -> bytes:
    """Return the frame that ends a goal; the ``values`` of an error are the reason as text."""
    if isinstance(result, PPaaSError):
        return _encoder.encode(_ActionResult(action, result.public, status, False, goal))
    return _encoder.encode(_ActionResult(action, msgspec.Raw(result), status, True, goal))


# -- goals that one client has sent by ``send_action_goal``, each of which ends exactly once ---------------------------

MAX_GOALS = 32
"""Limit of active goals of one client."""

_EMPTY = msgspec.Raw(b"{}")


class _Feedback(Message, forbid_unknown_fields=False):
    status: GoalStatus
    feedback: msgspec.Raw


class _Result(Message, forbid_unknown_fields=False):
    status: GoalStatus
    result: msgspec.Raw = _EMPTY


class _GoalId(msgspec.Struct):
    id: str = ""


class _ActionGoal(msgspec.Struct):
    goal_id: _GoalId
    goal: msgspec.Raw


@dataclass(slots=True)
class _Goal:
    id: str
    operation: SendActionGoal
    action: ActionAdapter
    sent: SentGoal
    watch: GoalWatch
    sequence: int = 0


@dataclass(frozen=True, slots=True)
class GoalFrame:
    """Frame for the client about a goal; if ``final``, it is the goal's result and must arrive."""

    frame: bytes
    final: bool
    goal: str = ""


class GoalTracker:
    """Active goals of one client.

    Parameters
    ----------
    name : str
        Name of the client, unique among all clients of the actions.
    """

    def __init__(self, name: str) -> None:
        self._name = name
        self._count = 0
        self._goals: dict[str, _Goal] = {}

    def __len__(self) -> int:
        """Return the number of active goals."""
        return len(self._goals)

    def topics(self) -> set[str]:
        """Return the topics to subscribe to for the active goals."""
        found: set[str] = set()
        for goal in self._goals.values():
            name = goal.action.topics
            found |= {f"{name}/status", f"{name}/result"}
            if goal.operation.feedback:
                found |= {f"{name}/feedback", goal.action.progress_topic or f"{name}/feedback"}
        return found

    # -- requests of the client ----------------------------------------------------------------------------------------

    def send(self, operation: SendActionGoal, action: ActionAdapter, now: float, name: str = "") -> tuple[str, bytes]:
        """Start a goal; return its id and the message for the topic ``goal`` of the action.

        Parameters
        ----------
        operation : SendActionGoal
        action : ActionAdapter
        now : float
            Monotonic time [s].
        name : str
            Name that no other goal of the client has; empty to number the goals.

        Raises
        ------
        InvalidInput
            The arguments are not a goal of this action.
        Conflict
            The client has an active goal with that id.
        QuotaExceeded
            The client has ``MAX_GOALS`` active goals.
        """
        if len(self._goals) >= MAX_GOALS:
            raise QuotaExceeded(
                f"a client may have at most {MAX_GOALS} active goals: wait for one to end, or cancel it"
            )
        if operation.id is not None and any(goal.operation.id == operation.id for goal in self._goals.values()):
            raise Conflict(f"goal {str(operation.id)[:64]!r} is still active: use a new id for each goal")
        message = action.goal(bytes(operation.args))
        self._count += 1
        goal_id = f"{self._name}-{name or self._count}"
        self._goals[goal_id] = _Goal(goal_id, operation, action, SentGoal(message, now), GoalWatch(goal_id))
        return goal_id, _encoder.encode(_ActionGoal(_GoalId(goal_id), msgspec.Raw(message)))

    def cancel(self, operation: CancelActionGoal) -> tuple[str, bytes]:
        """Return the name of the goal's action and the message for its topic ``cancel``.

        The goal itself ends when the action reports its end.

        Raises
        ------
        NotFound
            The client has no active goal with that id.
        """
        for goal in self._goals.values():
            if goal.operation.id == operation.id:
                return goal.action.topics, _encoder.encode(_GoalId(goal.id))
        raise NotFound("goal", "" if operation.id is None else str(operation.id)[:64])

    # -- progress and end of goals -------------------------------------------------------------------------------------

    def posted(self, goal_id: str, sequence: int) -> None:
        """Record the sequence number under which a goal was sent to the clone; 0 if it has none."""
        self._goals[goal_id].sequence = sequence

    def refused(self, sequence: int, error: PPaaSError) -> GoalFrame | None:
        """End the goal that was sent under a sequence number, because the clone refused it; None if it was no goal."""
        for goal in self._goals.values():
            if sequence and goal.sequence == sequence:
                return self.give_up(goal.id, error)
        return None

    def give_up(self, goal_id: str, error: PPaaSError) -> GoalFrame:
        """End a goal that could not be delivered to its action."""
        return GoalFrame(refusal(self._goals.pop(goal_id).operation, error), final=True, goal=goal_id)

    def hear(self, topic: str, payload: bytes, now: float) -> Iterator[GoalFrame]:
        """Process a message of one of ``topics``, and yield the frames that it causes for the client.

        Parameters
        ----------
        topic : str
            Name of the topic, without a leading slash.
        payload : bytes
            The message as JSON.
        now : float
            Monotonic time [s].

        Raises
        ------
        MalformedMessage
            The message does not have the type of this topic.
        """
        name, _, what = topic.rpartition("/")
        if what == "result":
            result = decode(_Result, payload)
            goal = self._goals.get(result.status.goal_id.id)
            if goal is not None and goal.action.topics == name:
                yield self._end(goal, status_of(result.status), result.status.text, bytes(result.result))
        elif what == "status":
            yield from self._on_statuses(name, decode(GoalStatusArray, payload), now)
        elif what == "feedback":
            feedback = decode(_Feedback, payload)
            goal = self._goals.get(feedback.status.goal_id.id)
            if goal is not None and goal.action.progress_topic == topic:
                goal.action.learn(bytes(feedback.feedback))
            elif goal is not None and goal.action.topics == name and goal.operation.feedback:
                yield GoalFrame(_feedback(goal, bytes(feedback.feedback), now), final=False)

    def _on_statuses(self, name: str, statuses: GoalStatusArray, now: float) -> Iterator[GoalFrame]:
        """Watch an action's goals; yield the ends of those that have ended without a result."""
        for goal in [goal for goal in self._goals.values() if goal.action.topics == name]:
            end = goal.watch.see(statuses.status_list, now)
            if end is not None:
                yield self._end(goal, end, goal.watch.text, b"{}")

    def _end(self, goal: _Goal, status: Status, text: str, result: bytes) -> GoalFrame:
        del self._goals[goal.id]
        operation, number = goal.operation, ros2_status(status)
        if number == UNKNOWN:
            reason = f"the goal was lost: {text or 'its result is not known'}"
            lost = Unavailable(reason)
            return GoalFrame(result_frame(operation.action, operation.id, UNKNOWN, lost), final=True, goal=goal.id)
        values = _with_client_times(goal.action, goal.action.result(result, status, text))
        return GoalFrame(result_frame(operation.action, operation.id, number, values), final=True, goal=goal.id)


def _with_client_times(action: ActionAdapter, values: bytes) -> bytes:
    return to_ros2(values) if action.ros2 else values


def _feedback(goal: _Goal, feedback: bytes, now: float) -> bytes:
    values = _with_client_times(goal.action, goal.action.feedback(goal.sent, feedback, now))
    return feedback_frame(goal.operation.action, goal.operation.id, values)


def refusal(operation: SendActionGoal, error: PPaaSError) -> bytes:
    """Return the result frame of a refused goal; its ``values`` are the reason, as for a service."""
    return result_frame(operation.action, operation.id, UNKNOWN, error)
