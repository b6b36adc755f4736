"""The master, as a pure state machine: events in, orders out.

It places, counts and decides what happens to what is lost. It starts nothing itself, and no message of a robot passes
through it. ``engine.service`` carries its orders out.

A *place* is what a user has, for as long as the user wants it: the clone of a robot, or planning on a map. The
containers that fill it come and go; each has an id of its own, so that news of a dead one is never taken for news of
the one that replaced it.
"""

import itertools
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Literal

from engine.balancers.base import Balancer
from engine.cores import check as check_size
from engine.machine import Machine
from engine.model import ContainerSpec, MapVersion, RobotConfig
from engine.quotas import Quotas
from ppaas.clock import Clock, monotonic
from ppaas.errors import Conflict, InvalidInput, NotFound, PPaaSError, Unavailable

CRASH_LIMIT = 5
CRASH_WINDOW = 30.0
"""More crashes than the limit within the window [s] are a crash loop, and the place is closed."""

RESTART_DELAYS = (0.0, 0.25, 1.0, 2.0, 4.0)
"""Seconds before what replaces a container starts, after its first, second … crash within the window: what is away for
a moment, as a store, is back before the place is given up."""


@dataclass(frozen=True, slots=True)
class PlaceRequest:
    """What a place is for."""

    user: str
    map: MapVersion
    cores: float
    robot: RobotConfig | None = None

    @property
    def key(self) -> str:
        """Name of the place: one a robot, and one a user and map version for planning."""
        if self.robot is not None:
            return f"robot:{self.user}/{self.robot.id}"
        return f"planning:{self.user}/{self.map.id}@{self.map.version}"


@dataclass(slots=True)
class Place:
    """A place and the container that fills it now, if one does."""

    request: PlaceRequest
    spec: ContainerSpec | None = None
    machine: str | None = None
    state: Literal["waiting", "starting", "ready"] = "waiting"
    pid: int | None = None
    crashes: list[float] = field(default_factory=list)
    session: str = ""


@dataclass(frozen=True, slots=True)
class Start:
    """Order: start this container on this machine after some seconds, from the last checkpoint of its session."""

    place: str
    machine: str
    spec: ContainerSpec
    delay: float = 0.0


@dataclass(frozen=True, slots=True)
class End:
    """Order: end this container."""

    machine: str
    container: str


@dataclass(frozen=True, slots=True)
class Close:
    """Order: tell whoever uses the place that it is no more, and why."""

    place: str
    reason: PPaaSError


Order = Start | End | Close


class Master:
    """Machines, places and containers.

    Parameters
    ----------
    balancer : Balancer
        Chooses machines.
    quotas : Quotas
        Of the users; what they have is counted there.
    clock : callable
        Monotonic seconds.
    new_id : callable
        Gives the next container id.
    """

    def __init__(
        self,
        balancer: Balancer,
        quotas: Quotas | None = None,
        clock: Clock = monotonic,
        new_id: Callable[[], str] | None = None,
    ) -> None:
        counter = itertools.count(1)
        self._balancer = balancer
        self._quotas = quotas or Quotas()
        self._clock = clock
        self._new_id = new_id or (lambda: f"c{next(counter)}")
        self.machines: dict[str, Machine] = {}
        self.places: dict[str, Place] = {}
        self._place_of: dict[str, str] = {}
        self._waiting: dict[str, None] = {}

    # -- what users want -----------------------------------------------------------------------------------------------

    def open(self, request: PlaceRequest) -> list[Order]:
        """Make a place and fill it; a place that is there already is left as it is.

        Raises
        ------
        InvalidParameter
            A size that is not positive.
        QuotaExceeded
            The user has too many containers or cores.
        Unavailable
            No machine has room.
        """
        if request.key in self.places:
            return []
        self._check(request)
        place = self._add(request)
        orders = self._fill(request.key, place)
        if not orders and self.machines:
            self._drop(request.key)
            raise Unavailable(f"no machine has room for a container of {request.cores} cores: try again later")
        return orders

    def close(self, key: str) -> list[Order]:
        """Give a place up, if it is there; what it had is room for places that wait."""
        place = self._drop(key)
        return [*self._empty(place), *self._fill_waiting()] if place is not None else []

    def _check(self, request: PlaceRequest) -> None:
        if self.machines:
            check_size(request.cores, max(machine.cores for machine in self.machines.values()))
        self._quotas.check_container(request.user, request.cores)

    # -- what happens to machines --------------------------------------------------------------------------------------

    def machine_joined(self, machine: Machine) -> list[Order]:
        """Take a machine in, and fill the places that wait for one."""
        orders = self.machine_left(machine.id)
        self.machines[machine.id] = machine
        self._balancer.joined(machine)
        return orders + self._fill_waiting()

    def machine_left(self, machine_id: str) -> list[Order]:
        """Place what a vanished machine carried anew; what finds no room waits for the next machine."""
        machine = self.machines.pop(machine_id, None)
        if machine is None:
            return []
        self._balancer.left(machine)
        orders: list[Order] = []
        for key in [self._place_of[container] for container in machine.containers]:
            self._empty(self.places[key])
            orders += self._fill(key, self.places[key])
        return orders

    def machine_measured(self, machine_id: str) -> None:
        """Note that what is known of the load of a machine is new."""
        if machine_id in self.machines:
            self._balancer.measured(self.machines[machine_id])

    # -- what happens to containers ------------------------------------------------------------------------------------

    def container_launched(self, container: str, pid: int) -> None:
        """Note the process of a container."""
        place = self._filled_by(container)
        if place is not None:
            place.pid = pid

    def container_ready(self, container: str, pid: int) -> str | None:
        """Note that a container answers; return the place it fills, or None if it is not awaited."""
        place = self._filled_by(container)
        if place is None:
            return None
        place.state, place.pid = "ready", pid
        return place.request.key

    def container_lost(self, container: str, reason: PPaaSError) -> list[Order]:
        """Replace a container that exited or could not be started.

        Later each time it crashes again, and not where it does so too often, nor where the reason is what it was
        asked for: another try would end the same way.
        """
        place = self._filled_by(container)
        if place is None:
            return []
        key = place.request.key
        self._empty(place)
        if isinstance(reason, InvalidInput | NotFound | Conflict):
            return self._give_up(key, reason)
        now = self._clock()
        place.crashes = [t for t in place.crashes if now - t < CRASH_WINDOW] + [now]
        crashes = len(place.crashes)
        if crashes > CRASH_LIMIT:
            text = f"the container failed {crashes} times in {CRASH_WINDOW:.0f} s; the last time: {reason}"
            return self._give_up(key, Unavailable(text))
        return self._fill(key, place, RESTART_DELAYS[crashes - 1])

    # -- inside --------------------------------------------------------------------------------------------------------

    def _filled_by(self, container: str) -> Place | None:
        key = self._place_of.get(container)
        return self.places.get(key) if key is not None else None

    def _give_up(self, key: str, reason: PPaaSError) -> list[Order]:
        self._drop(key)
        return [Close(key, reason), *self._fill_waiting()]

    def _fill_waiting(self) -> list[Order]:
        return [order for key in tuple(self._waiting) for order in self._fill(key, self.places[key])]

    def _add(self, request: PlaceRequest) -> Place:
        place = self.places[request.key] = Place(request)
        self._waiting[request.key] = None
        self._quotas.add(request.user, 1, request.cores)
        return place

    def _drop(self, key: str) -> Place | None:
        place = self.places.pop(key, None)
        if place is not None:
            self._waiting.pop(key, None)
            self._quotas.add(place.request.user, -1, -place.request.cores)
        return place

    def _fill(self, key: str, place: Place, delay: float = 0.0) -> list[Order]:
        request, container = place.request, self._new_id()
        session = place.session or container
        spec = ContainerSpec(container, request.user, request.map, request.cores, request.robot, session=session)
        machine = self._balancer.choose(spec)
        if machine is None:
            return []
        machine.place(spec)
        self._balancer.placed(machine, spec)
        self._place_of[spec.id] = key
        self._waiting.pop(key, None)
        place.spec, place.machine, place.state, place.pid = spec, machine.id, "starting", None
        place.session = session
        return [Start(key, machine.id, spec, delay)]

    def _empty(self, place: Place) -> list[Order]:
        spec, machine_id = place.spec, place.machine
        place.spec, place.machine, place.state, place.pid = None, None, "waiting", None
        if place is self.places.get(place.request.key):
            self._waiting[place.request.key] = None
        if spec is None or machine_id is None:
            return []
        self._place_of.pop(spec.id, None)
        machine = self.machines.get(machine_id)
        if machine is None:
            return []
        machine.remove(spec.id)
        self._balancer.removed(machine, spec)
        return [End(machine_id, spec.id)]
