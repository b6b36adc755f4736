"""State of the master: machines, places, and the containers that fill these."""

import math
from dataclasses import dataclass, field, replace

import msgspec

from engine.master.balancer import Balancer
from engine.master.events import MapChanged
from engine.master.machine import Machine
from engine.master.orders import Adopt, End, Order, Start
from engine.master.places import PlaceAssignment, PlaceRequest
from engine.master.queueing import PlaceQueue
from engine.master.quotas import Quotas
from engine.protocols.control_link import RunningContainer
from engine.specs.containers import ContainerSpec, MapVersion, RobotConfig
from engine.specs.machine_settings import MachineSettings
from ppaas.errors import NotFound
from ppaas.people.settings import PeopleSettings

# -- containers of an earlier cloud process ----------------------------------------------------------------------------


def request_of(spec: ContainerSpec) -> PlaceRequest:
    """Return the request for the place that a container was started to fill."""
    return PlaceRequest(spec.user, spec.map, spec.cores, spec.robot, labels=spec.labels, group_node=spec.group_node)


def may_adopt(place: PlaceAssignment | None, machine: Machine, carried: RunningContainer) -> bool:
    """Return whether a place may adopt a container that a machine reported.

    A place that is not open yet may. An open place must be for the same robot or group on the same map, and have
    neither another container nor a successor, since a robot has one clone. Containers that only plan are not adopted:
    the connections of the clients that waited for their paths ended with the earlier cloud process.

    Parameters
    ----------
    place : PlaceAssignment, optional
        Place that the container fills; None if it is not open.
    machine : Machine
        Machine that runs the container.
    carried : RunningContainer
        The container as its machine reported it.
    """
    spec, cores = carried.spec, carried.cores
    if spec.kind == "planning" or not (math.isfinite(cores) and 0.0 < cores <= machine.cores):
        return False
    if place is None:
        return True
    free = place.spec is None and place.successor is None
    return free and place.request == request_of(spec) and place.session in ("", spec.session)


def take_up(place: PlaceAssignment, machine: Machine, carried: RunningContainer) -> ContainerSpec:
    """Assign a running container to a place and count it on its machine; return its spec with its current size."""
    spec = msgspec.structs.replace(carried.spec, cores=carried.cores)
    machine.place(spec)
    place.spec, place.machine, place.state = spec, machine.id, "starting"
    place.pid, place.session = carried.pid, spec.session
    if carried.cores != carried.spec.cores:
        place.resized = carried.cores
    return spec


# -- versions of maps --------------------------------------------------------------------------------------------------

MOST_KNOWN = 4096
"""Largest number of maps whose current versions are remembered."""


@dataclass(slots=True)
class CurrentVersions:
    """Current versions of the maps that changed last, by the numbers of their publications.

    Clients read the current version of a map and report it later; meanwhile another one may be published.
    """

    _known: dict[str, MapChanged] = field(default_factory=dict)

    def note(self, event: MapChanged) -> bool:
        """Note a version; return False if a later one is known."""
        known = self._known.pop(event.map.id, None)
        if known is not None and _order(event) < _order(known):
            self._known[event.map.id] = known
            return False
        self._known[event.map.id] = event
        if len(self._known) > MOST_KNOWN:
            del self._known[next(iter(self._known))]
        return True

    def of(self, request: PlaceRequest) -> PlaceRequest:
        """Return a request with the current versions of its map and masks; those that are not known stay as given."""
        for name in request.map_ids:
            if name in self._known:
                request = with_version(request, self._known[name])
        return request


def _order(event: MapChanged) -> tuple[int, bool]:
    return event.number, event.in_space is not None


def with_version(request: PlaceRequest, event: MapChanged) -> PlaceRequest:
    """Return the request of a robot or a group's node with the version of a map, if it uses that map.

    Otherwise return an equal request.
    """
    robot = request.robot
    if robot is None:
        follows = request.group_node != "" and request.map.id == event.map.id
        return replace(request, map=event.map) if follows else request
    if robot.new_map:
        return request
    robot = _with_masks(robot, event.map)
    if request.map.id != event.map.id:
        return replace(request, robot=robot)
    if event.in_space is not None:
        robot = msgspec.structs.replace(robot, in_space=event.in_space)
    return replace(request, map=event.map, robot=robot)


def _with_masks(robot: RobotConfig, version: MapVersion) -> RobotConfig:
    masks = {name: version if mask.id == version.id else mask for name, mask in robot.masks.items()}
    return msgspec.structs.replace(robot, masks=masks)


# -- state -------------------------------------------------------------------------------------------------------------


class MasterState:
    """Machines and places; fills places with containers and empties them.

    Parameters
    ----------
    balancer : Balancer
        Balancer that chooses machines.
    quotas : Quotas
        Quotas, where the usage of users is counted.
    id_suffix : str
        Suffix of all container ids.

    Attributes
    ----------
    machines, places : dict
        Machines and places by name.
    users_of : dict of str to dict of str to PlaceAssignment
        Places whose containers use each map, as their map or as a mask: by id of the map, and by name.
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
    settings : dict of str to MachineSettings
        Settings by administrators, by name of the machine.
    removed : set of str
        Machines that administrators removed; they may not join.
    queue : PlaceQueue
        Requests for places that wait until they may be opened.
    versions : CurrentVersions
        Current versions of maps.
    closing : bool
        Whether the cloud is shutting down.
    """

    def __init__(self, balancer: Balancer, quotas: Quotas, id_suffix: str = "") -> None:
        self.balancer = balancer
        self.quotas = quotas
        self._last_number = 0
        self._id_suffix = id_suffix
        self.machines: dict[str, Machine] = {}
        self.places: dict[str, PlaceAssignment] = {}
        self.users_of: dict[str, dict[str, PlaceAssignment]] = {}
        self.place_of: dict[str, str] = {}
        self.waiting: dict[str, None] = {}
        self.moving: set[str] = set()
        self.draining: set[str] = set()
        self.returning: set[str] = set()
        self.settings: dict[str, MachineSettings] = {}
        self.removed: set[str] = set()
        self.queue = PlaceQueue(quotas)
        self.versions = CurrentVersions()
        self.closing = False

    def machine(self, machine_id: str) -> Machine:
        """Return a machine; raises ``NotFound`` if there is no such machine."""
        if machine_id not in self.machines:
            raise NotFound("machine", machine_id, list(self.machines))
        return self.machines[machine_id]

    def machine_of(self, container: str) -> str:
        """Return the name of the machine of a container; raises ``NotFound`` if there is no such container."""
        place = self.filled_by(container)
        if place is None or place.machine is None:
            raise NotFound("container", container)
        return place.machine

    def apply_settings(self, machine: Machine, settings: MachineSettings) -> None:
        """Give a machine its settings, and note whether it is drained."""
        machine.settings = settings
        if settings.draining:
            self.draining.add(machine.id)
        else:
            self.draining.discard(machine.id)

    def filled_by(self, container: str) -> PlaceAssignment | None:
        """Return the place that a container fills; None if it no longer fills one."""
        place = self.places.get(self.place_of.get(container, ""))
        return place if place is not None and place.spec is not None and place.spec.id == container else None

    def may_run(self, place: PlaceAssignment) -> bool:
        """Return whether a clone or the node of a group may still run on a machine that has not reconnected yet."""
        return bool(self.returning) and place.request.lasts and not place.session

    def adopt(self, machine: Machine, carried: RunningContainer) -> list[Order]:
        """Adopt a container that an earlier cloud process started, if its place may; return the orders."""
        request = request_of(carried.spec)
        place = self.places.get(request.key)
        if carried.spec.id in self.place_of or not may_adopt(place, machine, carried):
            return []
        place = place or self.add(request)
        cores = place.cores
        spec = take_up(place, machine, carried)
        self.waiting.pop(request.key, None)
        self.place_of[spec.id] = request.key
        self.quotas.add(spec.user, 0, spec.cores - cores)
        self.balancer.placed(machine, spec)
        return [Adopt(request.key, machine.id, carried)]

    def add(self, request: PlaceRequest) -> PlaceAssignment:
        """Add a place, which waits to be filled."""
        place = self.places[request.key] = PlaceAssignment(request)
        for map_id in request.map_ids:
            self.users_of.setdefault(map_id, {})[request.key] = place
        self.waiting[request.key] = None
        self.quotas.add(request.user, 1, request.cores)
        return place

    def drop(self, key: str) -> PlaceAssignment | None:
        """Remove a place and release the room reserved for it; return it, or None if there is no such place."""
        place = self.places.pop(key, None)
        if place is not None:
            self._forget_user(place)
            self.waiting.pop(key, None)
            self.moving.discard(key)
            if place.successor is not None:
                self._release(*place.successor)
            self.quotas.add(place.request.user, -1, -place.cores)
        return place

    def replace_request(self, place: PlaceAssignment, request: PlaceRequest) -> None:
        """Replace the request of an open place by one on other maps."""
        self._forget_user(place)
        place.request = request
        for map_id in request.map_ids:
            self.users_of.setdefault(map_id, {})[request.key] = place

    def _forget_user(self, place: PlaceAssignment) -> None:
        for map_id in place.request.map_ids:
            users = self.users_of[map_id]
            del users[place.request.key]
            if not users:
                del self.users_of[map_id]

    def fill(self, key: str, place: PlaceAssignment, delay: float = 0.0) -> list[Order]:
        """Return the order to start the next container of a place; if no machine has room, the place keeps waiting."""
        reserved = place.successor or self.reserve(place)
        place.successor = None
        if reserved is None:
            self.moving.discard(key)
            return []
        self.waiting.pop(key, None)
        place.machine, place.spec = reserved
        place.state, place.pid, place.session = "starting", None, place.spec.session
        place.follows = place.moves = False
        return [Start(key, place.machine, place.spec, delay)]

    def reserve(self, place: PlaceAssignment) -> tuple[str, ContainerSpec] | None:
        """Reserve room for the next container of a place; return its machine and spec, or None if there is no room."""
        # Two clones would act at once, and overwrite each other's checkpoints.
        if self.may_run(place):
            return None
        request, container = place.request, f"c{self._last_number + 1}{self._id_suffix}"
        # A replacement stays in the session, whose checkpoints it continues.
        session = place.session or container
        spec = ContainerSpec(
            container, request.user, request.map, place.cores, request.robot, session=session, labels=request.labels,
            people=PeopleSettings() if request.group_node == "people" else None,
            traffic=request.group_node == "traffic",
        )  # fmt: skip
        machine = self.balancer.choose(spec)
        if machine is None:
            return None
        self._last_number += 1
        machine.place(spec)
        self.balancer.placed(machine, spec)
        self.place_of[spec.id] = request.key
        return machine.id, spec

    def empty(self, place: PlaceAssignment) -> list[Order]:
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
        self.balancer.removed(machine, spec)
        return [End(machine_id, spec.id)]
