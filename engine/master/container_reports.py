"""Handles reports on containers: they are launched, become ready, and are lost."""

from engine.master.draining import move_on, use_room
from engine.master.events import ContainerLaunched, ContainerLost, ContainerReady, ContainerReport, RobotTimed
from engine.master.map_versions import catch_up
from engine.master.orders import Close, Order
from engine.master.places import CRASH_WINDOW, note_crash
from engine.master.state import MasterState
from ppaas.errors import Conflict, InvalidInput, NotFound, NotPermitted, PPaaSError, Unavailable


def handle_container_report(event: ContainerReport, state: MasterState) -> list[Order]:
    """Handle a report on a container; a late report on a container that was replaced is dropped.

    Raises
    ------
    NotPermitted
        A machine reported on a container of another machine.
    """
    match event:
        case ContainerLaunched():
            _note_pid(event, state)
        case ContainerReady():
            return _note_ready(event, state)
        case ContainerLost():
            return _replace(event, state)
        case RobotTimed():
            _note_round_trip(event, state)
    return []


def _check_carries(machine: str, container: str, state: MasterState) -> None:
    """Check that a machine reports on its own containers only, present or former."""
    place = state.filled_by(container)
    if place is not None and place.machine != machine:
        raise NotPermitted(f"machine {machine!r} reported on container {container!r} of another machine")


def _note_pid(event: ContainerLaunched, state: MasterState) -> None:
    _check_carries(event.machine, event.container, state)
    place = state.filled_by(event.container)
    if place is not None:
        place.pid = event.pid


def _note_ready(event: ContainerReady, state: MasterState) -> list[Order]:
    place = state.filled_by(event.container)
    if place is None:
        return []
    place.state = "ready"
    place.pid = place.pid or event.pid  # the pid on the machine counts: inside a Docker container it may differ
    state.moving.discard(place.request.key)
    return [*catch_up(place), *move_on(state)]


def _replace(event: ContainerLost, state: MasterState) -> list[Order]:
    """Replace a container.

    The delay grows with each crash. The place is closed after too many crashes, or if the reason is the request
    itself, so that another attempt would fail the same way.
    """
    if event.machine:
        _check_carries(event.machine, event.container, state)
    place, reason = state.filled_by(event.container), event.reason
    if place is None:
        return []
    key, left = place.request.key, place.leaving
    state.empty(place)
    if left:
        return state.fill(key, place)
    if isinstance(reason, InvalidInput | NotFound | Conflict):
        return _give_up(key, reason, state)
    delay = note_crash(place, event.now)
    if delay is None:
        text = f"the container failed {len(place.crashes)} times in {CRASH_WINDOW:.0f} s; the last time: {reason}"
        return _give_up(key, Unavailable(text), state)
    return state.fill(key, place, delay)


def _give_up(key: str, reason: PPaaSError, state: MasterState) -> list[Order]:
    state.drop(key)
    return [Close(key, reason), *use_room(state)]


def _note_round_trip(event: RobotTimed, state: MasterState) -> None:
    place = state.places.get(event.place)
    machine = state.machines.get(place.machine or "") if place is not None else None
    if place is not None and place.spec is not None and machine is not None:
        machine.served[place.spec.id] = event.round_trip
        state.balancer.timed(place.spec.serves, machine.id, event.round_trip)
