"""Actions of an order and instant actions: which run, which wait, and whether the AGV may drive meanwhile.

Source: VDA 5050, "Handling of multiple actions": NONE and SOFT run beside others, SINGLE and HARD alone; SOFT and HARD
forbid driving.
"""

from collections import deque
from collections.abc import Iterable, Iterator

from msgspec.structs import replace

from ppaas.wire.vda5050.orders import Action, Edge, Node
from ppaas.wire.vda5050.states import ENDED, ActionState, ActionStatus

# -- actions of an order -----------------------------------------------------------------------------------------------

ALONE = ("SINGLE", "HARD")
STANDING = ("SOFT", "HARD")


class ActionBook:
    """States of the actions of an order, and the queue of those that were triggered."""

    def __init__(self) -> None:
        self._states: dict[str, ActionState] = {}
        self._waiting: deque[Action] = deque()
        self._running: dict[str, Action] = {}

    def begin(self, steps: Iterable[Node | Edge]) -> None:
        """Replace the known actions by a new order's."""
        self._states.clear()
        self._waiting.clear()
        self.extend(steps)

    def extend(self, steps: Iterable[Node | Edge]) -> None:
        """Know the actions of an update."""
        for step in steps:
            for action in step.actions:
                self._states.setdefault(action.action_id, action_state(action, "WAITING"))

    def keep_only(self, steps: Iterable[Node | Edge]) -> None:
        """Forget waiting actions of a horizon that was replaced."""
        ahead = {action.action_id for step in steps for action in step.actions}
        triggered = {action.action_id for action in self._waiting}
        self._states = {
            key: state
            for key, state in self._states.items()
            if state.action_status != "WAITING" or key in ahead or key in triggered
        }

    def trigger(self, actions: Iterable[Action]) -> None:
        """Queue the actions of a node or an edge that was reached; those that were executed are left out."""
        waiting = [one for one in actions if self._states[one.action_id].action_status == "WAITING"]
        self._waiting.extend(waiting)

    def start(self) -> Iterator[Action]:
        """Yield the actions that start now."""
        while self._waiting:
            action = self._waiting[0]
            alone = any(one.blocking_type in ALONE for one in self._running.values())
            if alone or (self._running and action.blocking_type in ALONE):
                return
            self._waiting.popleft()
            self._running[action.action_id] = action
            self._states[action.action_id] = action_state(action, "RUNNING")
            yield action

    def end(self, action_id: str, *, ok: bool, result: str = "") -> bool:
        """Note the end of a running action; return whether it ran."""
        action = self._running.pop(action_id, None)
        if action is None:
            return False
        self._states[action_id] = action_state(action, "FINISHED" if ok else "FAILED", result)
        return True

    def cancel(self) -> None:
        """Fail the actions that have not begun; those that run go on."""
        self._waiting.clear()
        for key, state in self._states.items():
            if state.action_status == "WAITING":
                self._states[key] = replace(state, action_status="FAILED", action_result="the order was cancelled")

    @property
    def may_drive(self) -> bool:
        """True unless an action that runs or was triggered forbids driving."""
        return not any(one.blocking_type in STANDING for one in (*self._running.values(), *self._waiting))

    @property
    def busy(self) -> bool:
        """True while actions run, or wait after they were triggered."""
        return bool(self._running or self._waiting)

    @property
    def running(self) -> bool:
        """True while actions run."""
        return bool(self._running)

    def states(self) -> list[ActionState]:
        """Return the states of all actions of the order."""
        return list(self._states.values())


def action_state(action: Action, status: ActionStatus, result: str = "") -> ActionState:
    """Return the state of an action, with its result if there is one."""
    return ActionState(
        action_id=action.action_id,
        action_status=status,
        action_type=action.action_type,
        action_descriptor=action.action_descriptor,
        action_result=result or None,
    )


# -- instant actions that an AGV has received, with their states -------------------------------------------------------

START_PAUSE = "startPause"
STOP_PAUSE = "stopPause"
CANCEL_ORDER = "cancelOrder"
STATE_REQUEST = "stateRequest"
FACTSHEET_REQUEST = "factsheetRequest"
INIT_POSITION = "initPosition"
INITIALIZE_POSITION = "initializePosition"
CLEAR_INSTANT_ACTIONS = "clearInstantActions"
ENABLE_ZONE_SET = "enableZoneSet"
DELETE_ZONE_SET = "deleteZoneSet"

BOTH = (START_PAUSE, STOP_PAUSE, CANCEL_ORDER, STATE_REQUEST, FACTSHEET_REQUEST)
"""Instant actions of all versions."""

INSTANT_2 = (*BOTH, INIT_POSITION)
INSTANT_3 = (*BOTH, INITIALIZE_POSITION, CLEAR_INSTANT_ACTIONS, ENABLE_ZONE_SET, DELETE_ZONE_SET)

KEPT = 100
"""Number of ended instant actions that are kept."""


class InstantBook:
    """States of instant actions."""

    def __init__(self) -> None:
        self._states: dict[str, ActionState] = {}

    def knows(self, action_id: str) -> bool:
        """Return whether an action of that id was received."""
        return action_id in self._states

    def set(self, action: Action, status: ActionStatus, result: str = "") -> None:
        """Note the state of an action; the oldest that have ended are forgotten."""
        self._states[action.action_id] = action_state(action, status, result)
        ended = self._ended()
        for key in ended[: max(len(ended) - KEPT, 0)]:
            del self._states[key]

    def clear_ended(self) -> None:
        """Forget the actions that have ended."""
        for key in self._ended():
            del self._states[key]

    def _ended(self) -> list[str]:
        return [key for key, state in self._states.items() if state.action_status in ENDED]

    def states(self) -> list[ActionState]:
        """Return the states of all actions, oldest first."""
        return list(self._states.values())
