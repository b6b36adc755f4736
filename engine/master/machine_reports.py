"""Handles reports of machines: they join, report their load, and leave."""

from engine.master.draining import use_room
from engine.master.events import (
    MachineJoined,
    MachineLeft,
    MachineMeasured,
    MachineReport,
    MachinesExpected,
    ReturnTimedOut,
)
from engine.master.machine import Machine
from engine.master.orders import Order
from engine.master.report_validation import check_heartbeat
from engine.master.state import MasterState
from ppaas.errors import NotPermitted


def handle_machine_report(event: MachineReport, state: MasterState) -> list[Order]:
    """Handle a report of a machine; return the resulting orders.

    Raises
    ------
    NotPermitted
        An administrator removed the machine.
    InvalidParameter
        A reported load is not possible.
    """
    match event:
        case MachineJoined():
            return _add_machine(event, state)
        case MachineMeasured():
            _note_load(event, state)
        case MachineLeft(machine):
            return remove_machine(machine, state)
        case MachinesExpected(machines):
            state.returning.update(machines)
        case ReturnTimedOut():
            state.returning.clear()
            return use_room(state)
    return []


def _add_machine(event: MachineJoined, state: MasterState) -> list[Order]:
    """Add a machine with its settings, adopt its containers, and fill waiting places."""
    if event.machine in state.removed:
        raise NotPermitted(f"machine {event.machine!r} was removed: an administrator must admit it first")
    orders = remove_machine(event.machine, state)
    machine = Machine(
        event.machine, event.cores, event.memory, event.pid, labels=dict(event.labels), network=event.network
    )
    state.apply_settings(machine, state.settings.get(machine.id, machine.settings))
    state.machines[machine.id] = machine
    state.balancer.joined(machine)
    state.returning.discard(machine.id)
    orders += [order for carried in event.carries for order in state.adopt(machine, carried)]
    return orders + use_room(state)


def _note_load(event: MachineMeasured, state: MasterState) -> None:
    """Take over the load of a machine; the load of a machine that has just left is dropped."""
    machine, load = state.machines.get(event.machine), event.load
    if machine is None:
        return
    check_heartbeat(machine, load)
    machine.cpu, machine.memory_used = load.cpu, load.memory_used
    machine.network_used, machine.neighbours = load.network_used, load.round_trips
    machine.average_round_trips()
    machine.loads = {container.container: container for container in load.containers}
    state.balancer.measured(machine)


def remove_machine(machine_id: str, state: MasterState) -> list[Order]:
    """Remove a machine and place its containers on others; places without room wait for the next machine."""
    machine = state.machines.pop(machine_id, None)
    if machine is None:
        return []
    state.balancer.left(machine)
    state.draining.discard(machine_id)
    orders: list[Order] = []
    for container in tuple(machine.containers):
        place = state.filled_by(container)
        if place is not None:
            state.empty(place)
            orders += state.fill(place.request.key, place)
        else:
            state.places[state.place_of.pop(container)].successor = None
    return orders
