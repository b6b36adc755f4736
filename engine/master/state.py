"""State of the master: machines, places, and the containers that fill these."""

import itertools
from collections.abc import Callable

from engine.master.adoption import may_adopt, request_of, take_up
from engine.master.balancer import Balancer
from engine.master.machine import Machine
from engine.master.orders import Adopt, End, Order, Start
from engine.master.places import Place, PlaceRequest
from engine.master.quotas import Quotas
from engine.protocols.control_link import RunningContainer
from engine.specs.containers import ContainerSpec


class MasterState:
    """Machines and places; fills places with containers and empties them.

    Parameters
    ----------
    balancer : Balancer
        Balancer that chooses machines.
    quotas : Quotas
        Quotas, where the usage of users is counted.
    new_id : callable, optional
        Returns the next container id.

    Attributes
    ----------
    machines, places : dict
        Machines and places by name.
    place_of : dict of str to str
        Place that each container fills or will fill, by container id.
    waiting : dict of str to None
        Places without a container, in the order in which they are filled.
    moving : set of str
        Places whose container leaves its machine, until the next container is ready.
    draining : set of str
        Machines that are being drained.
    returning : set of str
        Machines of an earlier cloud process, which may reconnect.
    """

    def __init__(self, balancer: Balancer, quotas: Quotas, new_id: Callable[[], str] | None = None) -> None:
        counter = itertools.count(1)
        self._balancer = balancer
        self.quotas = quotas
        self._new_id = new_id or (lambda: f"c{next(counter)}")
        self.machines: dict[str, Machine] = {}
        self.places: dict[str, Place] = {}
        self.place_of: dict[str, str] = {}
        self.waiting: dict[str, None] = {}
        self.moving: set[str] = set()
        self.draining: set[str] = set()
        self.returning: set[str] = set()

    def filled_by(self, container: str) -> Place | None:
        """Return the place that a container fills; None if it no longer fills one."""
        place = self.places.get(self.place_of.get(container, ""))
        return place if place is not None and place.spec is not None and place.spec.id == container else None

    def may_run(self, place: Place) -> bool:
        """Return whether the clone of a robot may still run on a machine that has not reconnected yet."""
        return bool(self.returning) and place.request.robot is not None and not place.session

    def adopt(self, machine: Machine, carried: RunningContainer) -> list[Order]:
        """Adopt a container that an earlier cloud process started, if its place may; return the orders."""
        request = request_of(carried.spec)
        place = self.places.get(request.key)
        if carried.spec.id in self.place_of or not may_adopt(place, machine, carried):
            return []
        spec = take_up(place or self.add(request), machine, carried)
        self.waiting.pop(request.key, None)
        self.place_of[spec.id] = request.key
        self.quotas.add(spec.user, 0, spec.cores - request.cores)
        self._balancer.placed(machine, spec)
        return [Adopt(request.key, machine.id, carried)]

    def add(self, request: PlaceRequest) -> Place:
        """Add a place, which waits to be filled."""
        place = self.places[request.key] = Place(request)
        self.waiting[request.key] = None
        self.quotas.add(request.user, 1, request.cores)
        return place

    def drop(self, key: str) -> Place | None:
        """Remove a place and release the room reserved for it; return it, or None if there is no such place."""
        place = self.places.pop(key, None)
        if place is not None:
            self.waiting.pop(key, None)
            self.moving.discard(key)
            if place.successor is not None:
                self._release(*place.successor)
            self.quotas.add(place.request.user, -1, -place.cores)
        return place

    def fill(self, key: str, place: Place, delay: float = 0.0) -> list[Order]:
        """Return the order to start the next container of a place; if no machine has room, the place keeps waiting."""
        reserved = place.successor or self.reserve(place)
        place.successor = None
        if reserved is None:
            self.moving.discard(key)
            return []
        self.waiting.pop(key, None)
        place.machine, place.spec = reserved
        place.state, place.pid, place.session = "starting", None, place.spec.session
        return [Start(key, place.machine, place.spec, delay)]

    def reserve(self, place: Place) -> tuple[str, ContainerSpec] | None:
        """Reserve room for the next container of a place; return its machine and spec, or None if there is no room."""
        if self.may_run(place):
            return None
        request, container = place.request, self._new_id()
        session = place.session or container
        spec = ContainerSpec(
            container, request.user, request.map, place.cores, request.robot, session=session, labels=request.labels
        )
        machine = self._balancer.choose(spec)
        if machine is None:
            return None
        machine.place(spec)
        self._balancer.placed(machine, spec)
        self.place_of[spec.id] = request.key
        return machine.id, spec

    def empty(self, place: Place) -> list[Order]:
        """Detach the container of a place; return the order to end it."""
        spec, machine_id = place.spec, place.machine
        place.spec, place.machine, place.state, place.pid, place.leaving = None, None, "waiting", None, False
        if place is self.places.get(place.request.key):
            self.waiting[place.request.key] = None
        if spec is None or machine_id is None:
            return []
        return self._release(machine_id, spec)

    def _release(self, machine_id: str, spec: ContainerSpec) -> list[Order]:
        self.place_of.pop(spec.id, None)
        machine = self.machines.get(machine_id)
        if machine is None:
            return []
        machine.remove(spec.id)
        self._balancer.removed(machine, spec)
        return [End(machine_id, spec.id)]
