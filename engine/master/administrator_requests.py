"""Handles requests of administrators: settings of machines, removal and admission."""

from engine.master.draining import use_room
from engine.master.events import (
    AdministratorRequest,
    MachineAdmitted,
    RemovalRequested,
    SettingsChanged,
    SettingsLoaded,
)
from engine.master.machine_reports import remove_machine
from engine.master.orders import Order
from engine.master.state import MasterState
from engine.specs.machine_settings import check_settings
from ppaas.errors import Conflict


def handle_administrator_request(event: AdministratorRequest, state: MasterState) -> list[Order]:
    """Handle a request of an administrator; return the resulting orders.

    Raises
    ------
    InvalidParameter
        A setting is not valid.
    NotFound
        There is no such machine.
    Conflict
        A machine to be removed runs containers, and its removal is not forced.
    """
    match event:
        case SettingsChanged():
            return _configure(event, state)
        case RemovalRequested():
            return _remove(event, state)
        case SettingsLoaded(settings, removed):
            state.settings.update(settings)
            state.removed.update(removed)
        case MachineAdmitted(machine):
            state.removed.discard(machine)
    return []


def _configure(event: SettingsChanged, state: MasterState) -> list[Order]:
    """Apply settings, now and whenever the machine reconnects; containers that it runs stay, even over a new limit."""
    machine = state.machine(event.machine)
    state.settings[machine.id] = check_settings(event.settings)
    state.apply_settings(machine, event.settings)
    state.balancer.measured(machine)
    return use_room(state)


def _remove(event: RemovalRequested, state: MasterState) -> list[Order]:
    """Remove a machine and refuse it from now on; its containers are replaced as if it had failed."""
    carries = len(state.machine(event.machine).containers)
    if carries and not event.force:
        raise Conflict(f"machine {event.machine!r} runs {carries} containers: drain it first, or force its removal")
    state.settings.pop(event.machine, None)
    state.removed.add(event.machine)
    return remove_machine(event.machine, state)
