"""Cancellation of an order by the instant action ``cancelOrder``."""

from ppaas.wire.vda5050.master.instant_actions import instant_action
from ppaas.wire.vda5050.master.instructions import SendActions
from ppaas.wire.vda5050.master.settings import TRIES
from ppaas.wire.vda5050.states import ENDED, State

SILENT = 3.0
"""Time after which an AGV without an order has cancelled it, although it says nothing of the action [s]."""


class Cancelling:
    """Cancellation in progress, if there is one.

    Attributes
    ----------
    since : float
        Time of the last message [s].
    """

    def __init__(self) -> None:
        self.since = 0.0
        self._action = ""
        self._tries = 0

    @property
    def active(self) -> bool:
        """True while an order is to be cancelled."""
        return bool(self._action)

    def begin(self, now: float) -> SendActions:
        """Return the message that cancels the order."""
        self._tries = 0
        return self._send(now)

    def again(self, now: float) -> SendActions | None:
        """Return the message once more; None if it was sent often enough, which ends the cancellation."""
        if self._tries >= TRIES:
            self._action = ""
            return None
        return self._send(now)

    def is_done(self, state: State, now: float, *, idle: bool) -> bool:
        """Return whether the AGV has cancelled its order, or has none; this ends the cancellation."""
        states = (*state.instant_action_states, *state.action_states)
        status = next((one.action_status for one in states if one.action_id == self._action), None)
        answered = status in ENDED or (status is None and now - self.since > SILENT)
        done = idle and not state.driving and answered
        if done:
            self._action = ""
        return done

    def _send(self, now: float) -> SendActions:
        self._tries += 1
        self.since = now
        message = instant_action("cancelOrder", now)
        self._action = message.actions[0].action_id
        return SendActions(message)
