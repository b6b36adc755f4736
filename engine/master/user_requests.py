"""Handles requests of users: opens, closes and resizes places."""

from functools import partial

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
from engine.master.map_versions import follow
from engine.master.orders import Order
from engine.master.placement_diagnostics import check_fits, explain_no_machine
from engine.master.places import PlaceRequest
from engine.master.resizing import resize
from engine.master.state import MasterState
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
    machine = state.machine(state.machine_of(event.container))
    place = state.places[state.place_of[event.container]]
    return [resize(place, machine, event.cores, state.balancer, state.quotas), *use_room(state)]
