"""The master, as a pure state machine: events in, orders out.

It places containers, counts quotas, and replaces lost containers. It starts nothing itself, and no message of a robot
passes through it. ``engine.control.master_driver`` executes its orders.

A *place* is what a user holds: the clone of a robot, or planning on a map version. The containers that fill it are
replaced over time. Each has its own id, so that a late report about a dead container is never applied to its successor.

The master reads no clock and draws no random numbers, so the same events give the same state and the same orders. The
model is dask.distributed's ``worker_state_machine``.
"""

from collections import deque
from collections.abc import Mapping, Set
from functools import partial

import msgspec
from msgspec.structs import replace

from engine.master.balancer import Balancer
from engine.master.events import (
    AdministratorRequest,
    ContainerLaunched,
    ContainerLost,
    ContainerReady,
    ContainerReport,
    DefaultQuotaChanged,
    Event,
    LimitsChanged,
    MachineAdmitted,
    MachineJoined,
    MachineLeft,
    MachineMeasured,
    MachineReport,
    MachinesExpected,
    MapChanged,
    PlaceMoved,
    PlaceReleased,
    PlaceRequested,
    RemovalRequested,
    ResizeRequested,
    ReturnTimedOut,
    RobotTimed,
    SettingsChanged,
    SettingsLoaded,
    ShutdownBegan,
    UserRequest,
)
from engine.master.machine import DECIMALS, Machine
from engine.master.orders import Close, Leave, Order, Resize, UseMap
from engine.master.places import CRASH_WINDOW, PlaceAssignment, PlaceRequest, note_crash
from engine.master.queueing import FullMachines, check_fits, explain_no_machine
from engine.master.quotas import Quotas
from engine.master.report_validation import check_heartbeat
from engine.master.state import MasterState, with_version
from engine.specs.containers import ContainerSpec
from engine.specs.cores import check as check_size
from engine.specs.machine_settings import MachineSettings, check_settings
from ppaas.errors import Conflict, InvalidInput, NotFound, NotPermitted, PPaaSError, Unavailable

LOG_SIZE = 2000
"""Number of events in the log."""

_MEASUREMENTS = (MachineMeasured, RobotTimed, ContainerLaunched)
"""Frequent events that never free room for a queued place."""


class Master:
    """Decides where containers run; turns events into orders.

    Parameters
    ----------
    balancer : Balancer
        Balancer that chooses machines.
    quotas : Quotas, optional
        Quotas of the users, where their usage is counted.
    id_suffix : str
        Suffix of all container ids, which distinguishes them from other cloud processes' ids.
    log_size : int, optional
        Number of events in the log; None for all.

    Attributes
    ----------
    quotas : Quotas
        Quotas of the users, and their usage; changed by events alone.
    log : deque of Event
        The last events, refused ones included. A new master that handles all events since the start of another, in
        order, has the same state.
    """

    def __init__(
        self,
        balancer: Balancer,
        quotas: Quotas | None = None,
        *,
        id_suffix: str = "",
        log_size: int | None = LOG_SIZE,
    ) -> None:
        self.quotas = quotas or Quotas()
        self._state = MasterState(balancer, self.quotas, id_suffix)
        self.log: deque[Event] = deque(maxlen=log_size)

    def handle(self, event: Event) -> list[Order]:
        """Handle an event and return the resulting orders in sequence.

        Raises
        ------
        PPaaSError
            The event is refused: see ``handle_user_request``, ``handle_administrator_request``,
            ``handle_machine_report`` and ``handle_container_report``.
        """
        # Before the decision: a refused request uses a container number, so a replay needs it too.
        self.log.append(event)
        orders = self._decide(event)
        return orders if isinstance(event, _MEASUREMENTS) else [*orders, *serve_queue(self._state)]

    def _decide(self, event: Event) -> list[Order]:
        if isinstance(event, ContainerReport):
            return handle_container_report(event, self._state)
        if isinstance(event, MachineReport):
            return handle_machine_report(event, self._state)
        if isinstance(event, UserRequest):
            return handle_user_request(event, self._state)
        return handle_administrator_request(event, self._state)

    # -- state ---------------------------------------------------------------------------------------------------------

    @property
    def machines(self) -> Mapping[str, Machine]:
        """Connected machines by name."""
        return self._state.machines

    @property
    def places(self) -> Mapping[str, PlaceAssignment]:
        """Open places by name."""
        return self._state.places

    @property
    def settings(self) -> Mapping[str, MachineSettings]:
        """Settings by administrators, by name of the machine."""
        return self._state.settings

    @property
    def removed(self) -> Set[str]:
        """Machines that administrators removed."""
        return self._state.removed

    @property
    def returning(self) -> Set[str]:
        """Machines of an earlier cloud process, which may reconnect."""
        return self._state.returning

    def machine(self, machine_id: str) -> Machine:
        """Return a machine; raises ``NotFound`` if there is no such machine."""
        return self._state.machine(machine_id)

    def machine_of(self, container: str) -> str:
        """Return the name of the machine of a container; raises ``NotFound`` if there is no such container."""
        return self._state.machine_of(container)

    def place_of(self, container: str) -> PlaceAssignment | None:
        """Return the place that a container fills; None if it no longer fills one."""
        return self._state.filled_by(container)

    def is_leaving(self, container: str) -> bool:
        """Return whether a container was ordered to leave its machine."""
        place = self._state.filled_by(container)
        return place is not None and place.leaving

    def request_of(self, key: str) -> PlaceRequest | None:
        """Return the request of an open or queued place, or None."""
        place = self._state.places.get(key)
        return place.request if place is not None else self._state.queue.get(key)

    def current(self, request: PlaceRequest) -> PlaceRequest:
        """Return a request with the current versions of its map and masks, as far as they are known."""
        return self._state.versions.of(request)

    def position(self, key: str) -> int | None:
        """Return the position of a place in the queue, from 1; None if it is not queued."""
        return self._state.queue.position(key)


# -- requests of users -------------------------------------------------------------------------------------------------


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
        case PlaceRequested(request, queue):
            request = state.versions.of(request)
            fill = partial(open_place, state=state)
            return state.queue.open(request, fill) if queue else fill(request)
        case PlaceReleased(place):
            return _close_place(place, state)
        case PlaceMoved(request):
            return move_to_map(state.versions.of(request), state)
        case ResizeRequested():
            return _resize(event, state)
        case MapChanged():
            return follow(event, state)
        case LimitsChanged(user, limits):
            state.quotas.set_limits(user, limits)
        case DefaultQuotaChanged(quota):
            state.quotas.set_default(quota)
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


# -- reports of machines -----------------------------------------------------------------------------------------------


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
        event.machine,
        event.cores,
        event.memory,
        event.pid,
        labels=dict(event.labels),
        network=event.network,
        software=event.software,
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
            # It was room reserved here for a place that moves.
            state.places[state.place_of.pop(container)].successor = None
    return orders


# -- reports on containers ---------------------------------------------------------------------------------------------


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
    # To leave is no crash: it counts towards no limit, and causes no delay.
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


# -- requests of administrators ----------------------------------------------------------------------------------------


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


# -- free capacity -----------------------------------------------------------------------------------------------------

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
    # Sorted, so that a replay of the same events gives the same orders.
    for machine in sorted(state.draining):
        if len(state.moving) >= MOVES:
            break
        for place in _ready_on(state.machines[machine], state):
            if not full.refuse(place):
                orders += _move(place, full, state)
    return orders


def _ready_on(machine: Machine, state: MasterState) -> list[PlaceAssignment]:
    filled = (state.filled_by(container) for container in machine.containers)
    return [place for place in filled if place is not None and place.state == "ready" and not place.leaving]


def _move(place: PlaceAssignment, full: FullMachines, state: MasterState) -> list[Order]:
    if len(state.moving) >= MOVES or place.spec is None or place.machine is None:
        return []
    place.successor = state.reserve(place)
    if place.successor is None:
        full.note(place)
        return []
    place.leaving = True
    state.moving.add(place.request.key)
    return [Leave(place.request.key, place.machine, place.spec.id)]


# -- versions of maps --------------------------------------------------------------------------------------------------


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


def _follow(place: PlaceAssignment, event: MapChanged, state: MasterState) -> Order | None:
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


def move_to_map(request: PlaceRequest, state: MasterState) -> list[Order]:
    """Move the place of a robot to another map; return the order to its container.

    The container stores its state and ends; the next one, on the other map, takes its room. One that is starting gets
    its order when it is ready. A place that is in the queue, waits or moves to another machine goes on with the map.
    """
    state.queue.change(lambda queued: request if queued.key == request.key else queued)
    place = state.places.get(request.key)
    if place is None or place.request == request:
        return []
    state.replace_request(place, request)
    if place.successor is not None:
        machine, spec = place.successor
        place.successor = machine, _moved(machine, spec, request, state)
    place.follows, place.moves = False, place.spec is not None and not place.leaving
    return catch_up(place) if place.state == "ready" else []


def catch_up(place: PlaceAssignment) -> list[Order]:
    """Return the order for a ready container whose map changed, or whose robot moved to another, meanwhile."""
    if place.spec is None or place.machine is None:
        return []
    if place.moves:
        place.moves, place.follows, place.leaving = False, False, True
        return [Leave(place.request.key, place.machine, place.spec.id)]
    if not place.follows:
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
