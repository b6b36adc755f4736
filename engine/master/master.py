"""The master, as a pure state machine: events in, orders out.

It places containers, counts quotas, and replaces lost containers. It starts nothing itself, and no message of a robot
passes through it. ``engine.service.master_driver`` executes its orders.

A *place* is what a user holds: the clone of a robot, or planning on a map version. The containers that fill it are
replaced over time. Each has its own id, so that a late report about a dead container is never applied to its successor.

The master reads no clock and draws no random numbers, so the same events give the same state and the same orders. The
model is dask.distributed's ``worker_state_machine``.
"""

from collections import deque
from collections.abc import Mapping, Set

from engine.master.administrator_requests import handle_administrator_request
from engine.master.balancer import Balancer
from engine.master.container_reports import handle_container_report
from engine.master.events import (
    ContainerLaunched,
    ContainerReport,
    Event,
    MachineMeasured,
    MachineReport,
    RobotTimed,
    UserRequest,
)
from engine.master.machine import Machine
from engine.master.machine_reports import handle_machine_report
from engine.master.orders import Order
from engine.master.places import Place, PlaceRequest
from engine.master.quotas import Quotas
from engine.master.state import MasterState
from engine.master.user_requests import handle_user_request, serve_queue
from engine.specs.machine_settings import MachineSettings

LOG_SIZE = 2000
"""Number of events in the log."""

_MEASUREMENTS = (MachineMeasured, RobotTimed, ContainerLaunched)
"""Frequent events that never free room for a queued place."""


class Master:
    """Decides where containers run; turns events into orders.

    Parameters
    ----------
    balancer : Balancer
        Balancer that chooses machines.
    quotas : Quotas, optional
        Quotas of the users, where their usage is counted.
    id_suffix : str
        Suffix of all container ids, which distinguishes them from other cloud processes' ids.
    log_size : int, optional
        Number of events in the log; None for all.

    Attributes
    ----------
    quotas : Quotas
        Quotas of the users, and their usage; changed by events alone.
    log : deque of Event
        The last events, refused ones included. A new master that handles all events since the start of another, in
        order, has the same state.
    """

    def __init__(
        self,
        balancer: Balancer,
        quotas: Quotas | None = None,
        *,
        id_suffix: str = "",
        log_size: int | None = LOG_SIZE,
    ) -> None:
        self.quotas = quotas or Quotas()
        self._state = MasterState(balancer, self.quotas, id_suffix)
        self.log: deque[Event] = deque(maxlen=log_size)

    def handle(self, event: Event) -> list[Order]:
        """Handle an event and return the resulting orders in sequence.

        Raises
        ------
        PPaaSError
            The event is refused: see ``handle_user_request``, ``handle_administrator_request``,
            ``handle_machine_report`` and ``handle_container_report``.
        """
        self.log.append(event)
        orders = self._decide(event)
        return orders if isinstance(event, _MEASUREMENTS) else [*orders, *serve_queue(self._state)]

    def _decide(self, event: Event) -> list[Order]:
        if isinstance(event, ContainerReport):
            return handle_container_report(event, self._state)
        if isinstance(event, MachineReport):
            return handle_machine_report(event, self._state)
        if isinstance(event, UserRequest):
            return handle_user_request(event, self._state)
        return handle_administrator_request(event, self._state)

    # -- state ---------------------------------------------------------------------------------------------------------

    @property
    def machines(self) -> Mapping[str, Machine]:
        """Connected machines by name."""
        return self._state.machines

    @property
    def places(self) -> Mapping[str, Place]:
        """Open places by name."""
        return self._state.places

    @property
    def settings(self) -> Mapping[str, MachineSettings]:
        """Settings by administrators, by name of the machine."""
        return self._state.settings

    @property
    def removed(self) -> Set[str]:
        """Machines that administrators removed."""
        return self._state.removed

    @property
    def returning(self) -> Set[str]:
        """Machines of an earlier cloud process, which may reconnect."""
        return self._state.returning

    def machine(self, machine_id: str) -> Machine:
        """Return a machine; raises ``NotFound`` if there is no such machine."""
        return self._state.machine(machine_id)

    def machine_of(self, container: str) -> str:
        """Return the name of the machine of a container; raises ``NotFound`` if there is no such container."""
        return self._state.machine_of(container)

    def place_of(self, container: str) -> Place | None:
        """Return the place that a container fills; None if it no longer fills one."""
        return self._state.filled_by(container)

    def is_leaving(self, container: str) -> bool:
        """Return whether a container was ordered to leave its machine."""
        place = self._state.filled_by(container)
        return place is not None and place.leaving

    def request_of(self, key: str) -> PlaceRequest | None:
        """Return the request of an open or queued place, or None."""
        place = self._state.places.get(key)
        return place.request if place is not None else self._state.queue.get(key)

    def current(self, request: PlaceRequest) -> PlaceRequest:
        """Return a request with the current versions of its map and masks, as far as they are known."""
        return self._state.versions.of(request)

    def position(self, key: str) -> int | None:
        """Return the position of a place in the queue, from 1; None if it is not queued."""
        return self._state.queue.position(key)
