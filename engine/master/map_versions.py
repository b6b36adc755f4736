"""Versions of maps: places follow the current versions of their maps and masks."""

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import msgspec

from engine.master.events import MapChanged
from engine.master.orders import Order, UseMap
from engine.master.places import Place, PlaceRequest

if TYPE_CHECKING:
    from engine.master.state import MasterState
from engine.specs.containers import ContainerSpec, MapVersion, RobotConfig

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
        masks = () if request.robot is None else request.robot.masks.values()
        for name in dict.fromkeys((request.map.id, *(mask.id for mask in masks))):
            if name in self._known:
                request = with_version(request, self._known[name])
        return request


def _order(event: MapChanged) -> tuple[int, bool]:
    return event.number, event.in_space is not None


def follow(event: MapChanged, state: "MasterState") -> list[Order]:
    """Let the places of robots follow a map; return the orders to their containers.

    A container that is starting uses the version that it was started with, and gets its order when it is ready.
    Requests in the queue follow too. Places that only plan belong to one version. An event that is out of date changes
    nothing.
    """
    if not state.versions.note(event):
        return []
    state.queue.change(lambda request: with_version(request, event))
    orders = (_follow(place, event, state) for place in state.places.values())
    return [order for order in orders if order is not None]


def _follow(place: Place, event: MapChanged, state: "MasterState") -> Order | None:
    request = with_version(place.request, event)
    if request == place.request:
        return None
    place.request = request
    if place.successor is not None:
        machine, spec = place.successor
        place.successor = machine, _moved(machine, spec, request, state)
    if place.spec is None or place.machine is None:
        return None
    place.spec = _moved(place.machine, place.spec, request, state)
    place.follows = place.state != "ready"
    return None if place.follows or place.leaving else UseMap(place.machine, place.spec)


def catch_up(place: Place) -> list[Order]:
    """Return the order for a container that has become ready, if a map of it changed while it started."""
    if not place.follows or place.spec is None or place.machine is None:
        return []
    place.follows = False
    return [UseMap(place.machine, place.spec)]


def _moved(machine_id: str, spec: ContainerSpec, request: PlaceRequest, state: "MasterState") -> ContainerSpec:
    """Return the spec of a container on the maps of a request, counted so on its machine and by the balancer."""
    after = msgspec.structs.replace(spec, map=request.map, robot=request.robot)
    machine = state.machines.get(machine_id)
    if machine is not None and spec.id in machine.containers:
        round_trip = machine.served.get(spec.id)
        machine.remove(spec.id)
        state.balancer.removed(machine, spec)
        machine.place(after)
        state.balancer.placed(machine, after)
        if round_trip is not None:
            machine.served[spec.id] = round_trip
    return after


def with_version(request: PlaceRequest, event: MapChanged) -> PlaceRequest:
    """Return the request of a robot with the version of a map, if it uses that map; otherwise an equal request."""
    robot = request.robot
    if robot is None or robot.new_map:
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
