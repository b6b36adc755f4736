"""Use of free capacity: fills waiting places, and moves containers from machines that are drained, a few at once."""

from engine.master.machine import Machine
from engine.master.orders import Leave, Order
from engine.master.placement_diagnostics import FullMachines
from engine.master.places import Place
from engine.master.state import MasterState

MOVES = 4
"""Largest number of places that move at once: each has no container for a moment."""


def use_room(state: MasterState) -> list[Order]:
    """Return orders that fill waiting places and continue draining, after capacity has become free."""
    full, filled = FullMachines(), list[Order]()
    for key in tuple(state.waiting):
        place = state.places[key]
        if not full.refuse(place):
            orders = state.fill(key, place)
            filled += orders
            if not orders and not state.may_run(place):
                full.note(place)
    return [*filled, *move_on(state)]


def move_on(state: MasterState) -> list[Order]:
    """Return orders that make ready containers leave machines being drained, if another machine has room for them."""
    full, orders = FullMachines(), list[Order]()
    for machine in sorted(state.draining):
        if len(state.moving) >= MOVES:
            break
        for place in _ready_on(state.machines[machine], state):
            if not full.refuse(place):
                orders += _move(place, full, state)
    return orders


def _ready_on(machine: Machine, state: MasterState) -> list[Place]:
    filled = (state.filled_by(container) for container in machine.containers)
    return [place for place in filled if place is not None and place.state == "ready" and not place.leaving]


def _move(place: Place, full: FullMachines, state: MasterState) -> list[Order]:
    if len(state.moving) >= MOVES or place.spec is None or place.machine is None:
        return []
    place.successor = state.reserve(place)
    if place.successor is None:
        full.note(place)
        return []
    place.leaving = True
    state.moving.add(place.request.key)
    return [Leave(place.request.key, place.machine, place.spec.id)]
