"""Handles requests of users: opens, closes and resizes places."""

from functools import partial

from msgspec.structs import replace

from engine.master.draining import use_room
from engine.master.events import (
    LimitsChanged,
    MapChanged,
    PlaceReleased,
    PlaceRequested,
    ResizeRequested,
    ShutdownBegan,
    UserRequest,
)
from engine.master.machine import DECIMALS
from engine.master.map_versions import follow
from engine.master.orders import Order, Resize
from engine.master.placement_diagnostics import check_fits, explain_no_machine
from engine.master.places import PlaceRequest
from engine.master.state import MasterState
from engine.specs.cores import check as check_size
from ppaas.errors import Unavailable


def handle_user_request(event: UserRequest, state: MasterState) -> list[Order]:
    """Handle a request of a user; return the resulting orders.

    Raises
    ------
    NotFound
        There is no such container.
    InvalidParameter
        A size is not positive.
    QuotaExceeded
        The size exceeds the CPUs of every machine or the user's quota of containers or cores, or the queue is full.
    Unavailable
        No machine has room, or a container to be resized is not ready.
    """
    match event:
        case PlaceRequested(request, queue=True):
            return state.queue.open(state.versions.of(request), partial(open_place, state=state))
        case PlaceRequested(request):
            return open_place(state.versions.of(request), state)
        case PlaceReleased(place):
            return _close_place(place, state)
        case ResizeRequested():
            return _resize(event, state)
        case MapChanged():
            return follow(event, state)
        case LimitsChanged(user, limits):
            state.quotas.set_limits(user, limits)
        case ShutdownBegan():
            state.closing = True
    return []


def serve_queue(state: MasterState) -> list[Order]:
    """Open the queued places that fit now; return the orders."""
    if state.closing or not state.queue:
        return []
    return state.queue.serve(partial(open_place, state=state))


def open_place(request: PlaceRequest, state: MasterState) -> list[Order]:
    """Open a place and fill it; a place that is open already is left unchanged. Raises as `handle_user_request`."""
    if request.key in state.places:
        return []
    check_fits(request, state.machines.values(), state.quotas)
    place = state.add(request)
    orders = state.fill(request.key, place)
    if not orders and state.machines and not state.may_run(place):
        state.drop(request.key)
        raise Unavailable(explain_no_machine(request, state.machines))
    return orders


def _close_place(key: str, state: MasterState) -> list[Order]:
    """Close a place, if it is open; waiting places get its room."""
    state.queue.remove(key)
    place = state.drop(key)
    return [*state.empty(place), *use_room(state)] if place is not None else []


def _resize(event: ResizeRequested, state: MasterState) -> list[Order]:
    """Change the size of a place's container and of its later containers; waiting places get room that it leaves."""
    machine = state.machine(state.machine_of(event.container))
    place = state.places[state.place_of[event.container]]
    before = place.spec
    if before is None or place.state != "ready" or place.leaving:
        raise Unavailable("the container is starting or moving: try again when it is ready")
    check_size(event.cores, machine.cores)
    more = round(event.cores - before.cores, DECIMALS)
    if more > 0.0:
        state.quotas.check_cores(before.user, more)
    if more > max(machine.free, 0.0):
        raise Unavailable(
            f"machine {machine.id!r} has {max(machine.free, 0.0):g} free cores, but {more:g} more are needed"
        )
    after = replace(before, cores=event.cores)
    machine.remove(before.id)
    state.balancer.removed(machine, before)
    machine.place(after)
    state.balancer.placed(machine, after)
    state.quotas.add(before.user, 0, more)
    place.spec, place.resized = after, event.cores
    return [Resize(machine.id, after.id, event.cores), *use_room(state)]
