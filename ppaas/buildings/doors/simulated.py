"""Simulated door: it takes time to open and close, and may be jammed."""

from typing import Literal

from ppaas.buildings.doors.states import DoorMode, DoorRequest, DoorState

HOLD = 10.0
"""Time without a request after which an open door closes by itself [s]."""


class SimulatedDoor:
    """Door.

    Parameters
    ----------
    floor, door : str
    now : float
        Time [s], as everywhere here.
    opens : float
        Time in which it opens or closes [s].

    Attributes
    ----------
    blocked : bool
        Whether its light curtain sees something in the doorway: it opens then.
    """

    def __init__(self, floor: str, door: str, now: float, opens: float = 3.0) -> None:
        self.floor, self.door = floor, door
        self._opens, self._now = opens, now
        self._opened = 0.0
        self.blocked = False
        self._held_until = now
        self._fault: Literal["", "jammed", "offline"] = ""

    def request(self, request: DoorRequest, now: float) -> None:
        """Obey a request."""
        self._advance(now)
        self._held_until = now + HOLD if request.mode == "open" else now

    def set_fault(self, fault: Literal["", "jammed", "offline"], now: float) -> None:
        """Jam the door where it is, take it out of order, or repair it."""
        self._advance(now)
        self._fault = fault

    def state(self, now: float) -> DoorState:
        """Return what the door reports."""
        self._advance(now)
        mode: DoorMode = "moving"
        if self._fault == "offline":
            mode = "offline"
        elif self._opened in (0.0, 1.0):
            mode = "open" if self._opened else "closed"
        return DoorState(floor=self.floor, door=self.door, mode=mode)

    def _advance(self, now: float) -> None:
        held_until = now if self.blocked else self._held_until
        opening = max(min(now, held_until) - self._now, 0.0)
        closing = max(now - max(held_until, self._now), 0.0)
        if not self._fault:
            self._opened = min(self._opened + opening / max(self._opens, 1e-3), 1.0)
            self._opened = max(self._opened - closing / max(self._opens, 1e-3), 0.0)
        self._now = max(now, self._now)
