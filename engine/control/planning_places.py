"""Places of planning containers: one for each user, map version and set of labels, while used."""

import asyncio

from engine.control.master_driver import MasterDriver
from engine.links.place_link import PlaceLink
from engine.master.places import PlaceRequest
from engine.processes.background import Background
from engine.specs.containers import MapVersion
from ppaas.errors import Unavailable

IDLE = 120.0
"""Time after its last request for which a planning container is kept [s]."""

CORES = 1.0
"""Size of a planning container [cores]."""

PATIENCE = 10.0
"""Time after which a queued request that is not repeated leaves the queue [s]."""


class PlanningPlaces:
    """Opens places for requests, and closes those that are not used any more.

    Parameters
    ----------
    service : MasterDriver
        Opens the places.
    idle : float
        Time after its last request for which a planning container is kept [s].
    """

    def __init__(self, service: MasterDriver, idle: float = IDLE) -> None:
        self._service = service
        self._idle = idle
        self._used: dict[str, float] = {}
        self._closing: dict[str, asyncio.TimerHandle] = {}
        self._leaving: dict[str, asyncio.TimerHandle] = {}
        self._background = Background()

    def use(self, user: str, version: MapVersion, labels: dict[str, str], *, queue: bool) -> PlaceLink:
        """Open the place of a planning container, or use it for another request.

        Raises
        ------
        QuotaExceeded
            The user's quota allows no other container.
        Unavailable
            No machine has room.
        """
        place = self._service.open_place(PlaceRequest(user, version, CORES, labels=labels), queue=queue)
        self._note_use(place.key)
        if queue and self._service.position(place.key) is not None:
            self._keep_in_queue(place.key)
        return place

    def _keep_in_queue(self, key: str) -> None:
        loop = asyncio.get_running_loop()
        if key in self._leaving:
            self._leaving[key].cancel()
        self._leaving[key] = loop.call_later(PATIENCE, self._leave_queue, key)

    def _leave_queue(self, key: str) -> None:
        del self._leaving[key]
        if self._service.position(key) is not None:
            self._background.run(self._service.close_place(key, Unavailable("its request was not repeated in time")))

    def _note_use(self, key: str) -> None:
        now = self._used[key] = asyncio.get_running_loop().time()
        if key not in self._closing:
            self._close_later(key, now + self._idle)

    def _close_later(self, key: str, at: float) -> None:
        self._closing[key] = asyncio.get_running_loop().call_at(at, self._close, key)

    def _close(self, key: str) -> None:
        del self._closing[key]
        unused_at = self._used[key] + self._idle
        if unused_at > asyncio.get_running_loop().time():
            self._close_later(key, unused_at)
            return
        del self._used[key]
        self._background.run(self._service.close_place(key, Unavailable("the planning container was idle")))

    def close(self) -> None:
        """Cancel all timers."""
        for handle in (*self._closing.values(), *self._leaving.values()):
            handle.cancel()
