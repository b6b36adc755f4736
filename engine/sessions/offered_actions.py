"""Actions that a client offers, and the goals that it executes."""

from collections.abc import Callable

import msgspec

from engine.sessions.place.client_actions import GoalEnd
from engine.sessions.place.place import Place
from ppaas.errors import InvalidInput, MalformedMessage, NotFound
from ppaas.wire.actions import ABORTED, CANCELED, SUCCEEDED
from ppaas.wire.goals import cancel_frame, goal_frame
from ppaas.wire.names import is_ros2_type, ros1_type
from ppaas.wire.operations import ActionFeedback, ActionResult, AdvertiseAction, Id, UnadvertiseAction
from ppaas.wire.refusals import error_of_text
from ppaas.wire.rosbridge import RosbridgeSession

ENDS = (SUCCEEDED, CANCELED, ABORTED)
"""Statuses with which a goal may end."""


class OfferedActions:
    """Actions of one client. A goal comes to it as ``send_action_goal``, and it answers with feedback and a result.

    Parameters
    ----------
    place : Place
        Place of the robot.
    client : int
        Number of the client at the place.
    wire : RosbridgeSession
        Reads the names that the client spells.
    send : callable
        Called with a frame that must not be dropped; raises ``Unavailable`` if the client reads too slowly.
    """

    def __init__(self, place: Place, client: int, wire: RosbridgeSession, send: Callable[[bytes], None]) -> None:
        self._place = place
        self._client = client
        self._wire = wire
        self._send = send
        self._spellings: dict[str, AdvertiseAction] = {}

    # -- from the client -----------------------------------------------------------------------------------------------

    def advertise(self, operation: AdvertiseAction) -> None:
        """Register an action that the client offers.

        Raises
        ------
        PPaaSError
            The name or type is invalid, there is an action of this name, or the client offers too many.
        """
        action = self._wire.names.resolve(operation.action)
        kind = ros1_type(operation.type).removesuffix("Action")
        self._place.advertise_action(action, kind, self._client, self, ros2=is_ros2_type(operation.type))
        self._spellings[action] = operation

    def unadvertise(self, operation: UnadvertiseAction) -> None:
        """Remove an action that the client offers; its goals are aborted.

        Raises
        ------
        NotFound
            The client does not offer it.
        """
        action = self._wire.names.resolve(operation.action)
        self._place.client_actions.unadvertise(action, self._client)
        self._spellings.pop(action, None)

    def feedback(self, operation: ActionFeedback) -> None:
        """Pass feedback to the client that sent the goal.

        Raises
        ------
        NotFound, NotPermitted
            The client executes no goal with this id.
        MalformedMessage
            The feedback is not an object.
        """
        values = _object(bytes(operation.values), "feedback")
        self._place.client_actions.feedback(_number(operation.id), self._client, values)

    def result(self, operation: ActionResult) -> None:
        """Pass a result to the client that sent the goal.

        Raises
        ------
        NotFound, NotPermitted
            The client executes no goal with this id.
        InvalidInput
            The status is not that of a goal that ended, or the result is not an object.
        """
        self._place.client_actions.end(_number(operation.id), self._client, _end_of(operation))

    # -- to the client -------------------------------------------------------------------------------------------------

    def goal_requested(self, goal: int, action: str, payload: bytes) -> None:
        """Send a goal to the client; raises ``Unavailable`` if it reads too slowly."""
        spelled = self._spellings[action]
        self._send(goal_frame(spelled.action, spelled.type, goal, payload))

    def goal_cancelled(self, goal: int, action: str) -> None:
        """Tell the client to cancel a goal; raises ``Unavailable`` if it reads too slowly."""
        self._send(cancel_frame(self._spellings[action].action, goal))


def _number(goal: Id) -> int:
    text = "" if goal is None else str(goal)
    if not (text.isascii() and text.isdigit() and len(text) < 16):
        raise NotFound("active goal", text[:64])
    return int(text)


def _object(values: bytes, what: str) -> bytes:
    if values == b"null":
        return b"{}"
    if not values.startswith(b"{"):
        raise MalformedMessage(f"the {what} of a goal must be an object")
    return values


def _end_of(operation: ActionResult) -> GoalEnd:
    """Return the end that a client reports; ``result`` that is not true means aborted, as in rosbridge_suite."""
    values = bytes(operation.values)
    if not operation.result:
        reason = msgspec.json.decode(values)
        known = reason if isinstance(reason, str) and reason else f"action {operation.action!r}: the client failed"
        return GoalEnd(ABORTED, error_of_text(known))
    if operation.status not in ENDS:
        raise InvalidInput(f"the status of a goal that ended is one of 4, 5 and 6, not {operation.status}")
    return GoalEnd(operation.status, _object(values, "result"))
