"""Instant actions that an AGV has received, with their states."""

from ppaas.wire.vda5050.agv.action_book import action_state
from ppaas.wire.vda5050.orders import Action
from ppaas.wire.vda5050.states import ENDED, ActionState, ActionStatus

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
