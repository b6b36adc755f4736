"""Versions of maps: places follow the current versions of their maps and masks."""

import msgspec

from engine.master.current_versions import with_version
from engine.master.events import MapChanged
from engine.master.orders import Order, UseMap
from engine.master.places import Place, PlaceRequest
from engine.master.state import MasterState
from engine.specs.containers import ContainerSpec


def follow(event: MapChanged, state: MasterState) -> list[Order]:
    """Move the places of robots and of group nodes to a map's version; return the orders to their containers.

    A container that is starting uses the version that it was started with, and gets its order when it is ready.
    Requests in the queue follow too. Places that only plan belong to one version. An event that is out of date changes
    nothing.
    """
    if not state.versions.note(event):
        return []
    state.queue.change(lambda request: with_version(request, event))
    orders = (_follow(place, event, state) for place in state.users_of.get(event.map.id, {}).values())
    return [order for order in orders if order is not None]


def _follow(place: Place, event: MapChanged, state: MasterState) -> Order | None:
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


def _moved(machine_id: str, spec: ContainerSpec, request: PlaceRequest, state: MasterState) -> ContainerSpec:
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
