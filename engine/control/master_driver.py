"""Drives the master: executes its orders and feeds it events; holds the place link that clients use for each place."""

import asyncio
import contextlib
import logging
import secrets
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Mapping
from pathlib import Path
from weakref import WeakKeyDictionary

from engine.control.administration import Administration, Containers
from engine.control.counts import ControlCounts
from engine.control.fleet_events import FleetEvents
from engine.control.start_times import StartTimes
from engine.leadership.leadership import Mandate
from engine.links.control_server import ControlServer
from engine.links.place_link import PlaceLink
from engine.links.presence import RobotPresence
from engine.links.robot_link_server import LinkServer
from engine.master.events import (
    ContainerLaunched,
    ContainerLost,
    ContainerReady,
    DefaultQuotaChanged,
    Event,
    LimitsChanged,
    MachineJoined,
    MachineLeft,
    MachineMeasured,
    MachinesExpected,
    MapChanged,
    PlaceMoved,
    PlaceReleased,
    PlaceRequested,
    RemovalRequested,
    ReturnTimedOut,
    RobotTimed,
    ShutdownBegan,
)
from engine.master.machine import Software
from engine.master.master import Master
from engine.master.orders import Adopt, Close, End, Leave, Order, Resize, Start, UseMap
from engine.master.places import PlaceRequest
from engine.master.quotas import Quota
from engine.master.report_validation import check_registration
from engine.processes.background import Background
from engine.processes.heartbeats import BEAT_PERIOD, MISSED, watch
from engine.protocols import control_link, robot_link
from engine.protocols.framing import FrameStream
from engine.protocols.refusals import error_of
from engine.specs.checkpoints import CheckpointSelection
from engine.specs.containers import ContainerSpec, MapVersion, base_frame
from engine.specs.start_state import KernelProgress, StartState
from ppaas.clock import Clock, monotonic
from ppaas.errors import Conflict, Idle, NotFound, PPaaSError, Starting, Unavailable
from storage.records import Limits

logger = logging.getLogger(__name__)


# -- notifications -----------------------------------------------------------------------------------------------------


class CloudListener:
    """Ignores all notifications; a subclass overrides those that it handles."""

    def machine_frozen(self, machine: str) -> None:
        """Handle a machine whose agent missed its heartbeats; its link is already closed. Kill it if possible."""

    def machine_removed(self, machine: str) -> None:
        """Handle a machine that an administrator removed: do not restart its agent."""

    def machines_changed(self, machines: Collection[str]) -> None:
        """Handle a change of the set of machines, given by name."""

    def place_opened(self, key: str) -> None:
        """Handle a place that was opened, or that waits in the queue."""

    def place_adopted(self, key: str) -> None:
        """Handle a place that adopted a container of an earlier cloud process."""


# -- driver ------------------------------------------------------------------------------------------------------------

START_TIMEOUT = 10.0
"""Time within which a container must dial the robot link [s]; after that it is ended and replaced."""

HANG_UP_GRACE = 0.5
"""Time after the end of a robot link within which the machine reports the exit of a container that has exited [s]."""


class MasterDriver:
    """Opens places and keeps them filled.

    Parameters
    ----------
    master : Master
        Master to drive.
    checkpoints : CheckpointSelection
        Selects the checkpoints that clones start from.
    run_dir : Path
        Folder for the sockets.
    secret : str
        Secret with which local agents register.
    listener : CloudListener, optional
        Notified of machines that join and leave, and of places that are adopted.
    start_timeout : float
        Time within which a container must dial the robot link [s].
    clock : callable
        Returns monotonic seconds.

    Attributes
    ----------
    of_machines : MachineEvents
        Handles the events of machines.
    administration : Administration
        Applies the decisions of administrators about machines.
    containers : Containers
        Containers, as operators see and change them.
    counts : ControlCounts
        What happened since this process started.
    events : FleetEvents
        Reports what happens to those who listen.
    """

    def __init__(
        self,
        master: Master,
        checkpoints: CheckpointSelection,
        run_dir: Path,
        secret: str,
        listener: CloudListener | None = None,
        *,
        start_timeout: float = START_TIMEOUT,
        clock: Clock = monotonic,
    ) -> None:
        listener = listener or CloudListener()
        self._master = master
        self._clock = clock
        self._checkpoints = checkpoints
        self._links = LinkServer(run_dir / "link.sock", self._welcome, self._failed, waits=self._waits_for_kernels)
        self._places: dict[str, PlaceLink] = {}
        self.presence = RobotPresence(self._places.get)
        self._timed: WeakKeyDictionary[PlaceLink, tuple[str | None, float | None]] = WeakKeyDictionary()
        self._opened = listener.place_opened
        self._times, self.counts, self.events = StartTimes(), ControlCounts(), FleetEvents()
        machines = self.of_machines = MachineEvents(
            master, checkpoints, self._links, self._times, self.counts,
            execute=self._execute, container_lost=self._report_lost, alive=self._compiles, listener=listener,
            machine_lost=self.events.machine_lost,
        )  # fmt: skip
        self._control = machines.listen(run_dir / "control.sock", secret)
        self.administration = Administration(
            master, self._execute, machines.cut_off, machines.check_started, machines.start_state
        )
        self.containers = Containers(
            master, self._places, self._control, self._times, execute=self._execute, is_here=self.presence.is_here
        )
        self._background = Background()
        self._watching = Background()
        self._closing = False
        self._orders = OrderExecution(
            self._places, self._control, self._links, self._times, checkpoints,
            start_timeout=start_timeout, not_come=self._not_come, adopted=listener.place_adopted,
        )  # fmt: skip

    @property
    def servers(self) -> tuple[ControlServer, LinkServer]:
        """Return the servers of control links and of robot links, for connections from other hosts."""
        return self._control, self._links

    @property
    def mandate(self) -> Mandate:
        """Mandate of this master to give orders."""
        return self._control.mandate

    async def start(self) -> None:
        """Listen for containers and machines."""
        await self._links.start()
        await self._control.start()
        machines = self.of_machines.beats, self.of_machines.give_up
        containers = self._beats, self._give_up_frozen
        self._watching.run(watch(machines, containers, meanwhile=self._note_round_trips))

    async def wait_for_machine(self, timeout: float) -> None:
        """Wait until a first machine has joined.

        Raises
        ------
        Unavailable
            No machine joined within ``timeout`` [s].
        """
        try:
            async with asyncio.timeout(timeout):
                await self.of_machines.joined.wait()
        except TimeoutError as error:
            raise Unavailable(f"no machine registered within {timeout:g} s; see the log of its agent") from error

    async def close(self) -> None:
        """Close all places and dismiss all machines."""
        self._closing = True
        self._handle(ShutdownBegan())
        await self._watching.cancel()
        await self.of_machines.close()
        for key in tuple(self._places):
            await self.close_place(key, Unavailable("the cloud is shutting down"))
        await self._control.close()
        await self._links.close()
        await self._orders.cancel()
        await self._background.cancel()

    # -- places --------------------------------------------------------------------------------------------------------

    def start_state(self) -> StartState:
        """Return whether containers can start, and the kernels that machines compile."""
        return self.of_machines.start_state()

    def place(self, key: str) -> PlaceLink | None:
        """Return the link of an open place, or None."""
        return self._places.get(key)

    def open_place(self, request: PlaceRequest, *, queue: bool = False) -> PlaceLink:
        """Open a place, or return it if it is open; with ``queue``, it may wait for its turn.

        Raises
        ------
        Conflict
            It is open for another request, such as another map version or size.
        QuotaExceeded, Unavailable, InvalidParameter
            As ``Master.handle`` raises them.
        """
        known = self._places.get(request.key)
        if known is not None:
            if self.request_of(request.key) != self._master.current(request):
                raise Conflict(
                    f"{request.key} runs with earlier settings; disconnect it and connect again to apply the changes"
                )
            return known
        orders = self._master.handle(PlaceRequested(request, queue))
        place = self._places[request.key] = PlaceLink(request.key, base_frame(request.robot))
        place.busy = queue  # a queued place must not count as idle
        self._execute(orders)
        self._opened(request.key)
        return place

    def move_place(self, request: PlaceRequest) -> None:
        """Let the open or queued place of a robot go on with another map, or at another pose, in the same session."""
        self._handle(PlaceMoved(request))
        self._opened(request.key)

    def request_of(self, key: str) -> PlaceRequest | None:
        """Return the request of an open or queued place, or None."""
        return self._master.request_of(key)

    def serves_group(self, key: str) -> bool:
        """Return whether an open place holds the node of a group."""
        request = self.request_of(key)
        return request is not None and request.group_node != ""

    def machine_of_place(self, key: str) -> str | None:
        """Return the machine of the container of a place; None while there is none."""
        place = self._master.places.get(key)
        return None if place is None else place.machine

    def position(self, key: str) -> int | None:
        """Return the position of a place in the queue, from 1; None if it is not queued."""
        return self._master.position(key)

    def queued(self) -> int:
        """Return the number of places in the queue."""
        return sum(key not in self._master.places for key in self._places)

    def set_limits(self, user: str, limits: Limits) -> None:
        """Apply a user's own limits, and open the queued places that they allow."""
        self._handle(LimitsChanged(user, limits))

    def set_default_quota(self, quota: Quota) -> None:
        """Apply another quota of users without own limits, and open the queued places that it allows."""
        self._handle(DefaultQuotaChanged(quota))

    async def close_place(self, key: str, reason: PPaaSError) -> None:
        """Close a place and notify its clients; an idle robot's next session continues from its last checkpoint."""
        open_now = self._master.places.get(key)
        if isinstance(reason, Idle) and open_now is not None and open_now.request.robot is not None:
            self._checkpoints.park(open_now.request.user, open_now.request.robot.id)
        place = self._places.pop(key, None)
        if place is not None:
            place.close(reason)
        self._handle(PlaceReleased(key))

    async def close_places(self, user: str, reason: PPaaSError) -> None:
        """Close all places of a user."""
        for key in tuple(self._places):
            request = self.request_of(key)
            if request is not None and request.user == user:
                await self.close_place(key, reason)

    def map_changed(self, version: MapVersion, number: int, *, in_space: bool | None) -> None:
        """Move robots that use a map, as map or mask, to another version of it, which must have a grid.

        ``number`` is the publication's number; if a later one is known, nothing changes. ``in_space`` is whether it has
        an octomap, None if that is not known.
        """
        self._handle(MapChanged(version, in_space, number))

    # -- orders --------------------------------------------------------------------------------------------------------

    def _handle(self, event: Event) -> None:
        self._execute(self._master.handle(event))

    def _execute(self, orders: list[Order]) -> None:
        for order in orders:
            self._orders.execute(order)

    def _not_come(self, machine: str, container: str, reason: PPaaSError) -> None:
        if self._times.is_awaited(container):
            self._execute([End(machine, container)])
            self._container_lost(container, reason)

    # -- events --------------------------------------------------------------------------------------------------------

    async def _welcome(self, hello: robot_link.Hello, stream: FrameStream[robot_link.FromContainer]) -> None:
        filled = self._master.place_of(hello.container)
        place = self._places.get(filled.request.key) if filled is not None else None
        if place is None:
            return
        took = self._times.answer(hello.container)
        if took is not None:
            self.counts.placements.add(took)
        self._handle(ContainerReady(hello.container, hello.pid))
        try:
            await place.serve(hello, stream)
        finally:
            if not self._closing:
                self._background.run(self._hung_up(hello.container))

    async def _hung_up(self, container: str) -> None:
        """Replace a container whose link was closed but that still runs: it waits for another cloud process."""
        await asyncio.sleep(HANG_UP_GRACE)
        if not self._master.is_leaving(container):
            await self._give_up(container)

    async def _give_up(self, container: str) -> None:
        with contextlib.suppress(NotFound, Unavailable):  # it has exited meanwhile
            await self.containers.give_up(container)

    def _waits_for_kernels(self, container: str) -> None:
        self._times.postpone(container)

    def _failed(self, failed: robot_link.ContainerFailed) -> None:
        self._container_lost(failed.container, error_of(failed.refusal))

    def _container_lost(self, container: str, reason: PPaaSError) -> None:
        self._report_lost("", container, reason)

    def _report_lost(self, machine: str, container: str, reason: PPaaSError) -> None:
        leaves, filled = self._master.is_leaving(container), self._master.place_of(container)
        orders = self._master.handle(ContainerLost(container, reason, self._clock(), machine))
        self._links.forget(container)
        self._times.forget(container)
        if orders:
            logger.log(logging.INFO if leaves else logging.WARNING, "container %s is lost: %s", container, reason)
            self.counts.containers_lost += not leaves
            if filled is not None and not leaves and not self._closing:
                self.events.container_lost(container, filled.request, str(reason))
        self._execute(orders)

    # -- frozen containers ---------------------------------------------------------------------------------------------

    def _beats(self) -> dict[str, int]:
        return {place.container: place.beats for place in self._places.values() if place.container is not None}

    def _compiles(self, machine: str, container: str) -> None:
        """Count a heartbeat of a container that compiles a kernel, for which its machine answers."""
        for place in self._places.values():
            if place.container == container and self.machine_of_place(place.key) == machine:
                place.beats += 1

    def _give_up_frozen(self, container: str) -> None:
        logger.error("container %s missed %d heartbeats: it is frozen, and replaced", container, MISSED)
        self._background.run(self._give_up(container))

    def _note_round_trips(self) -> None:
        for key, place in self._places.items():
            measured, before = (place.container, place.beat.round_trip), self._timed.get(place)
            if measured[1] is not None and measured != before:
                self._timed[place] = measured
                self._handle(RobotTimed(key, measured[1]))


# -- orders ------------------------------------------------------------------------------------------------------------

LEAVE_GRACE = 5.0
"""Time that a leaving container has to store its state [s]; after that, its machine kills it."""


class OrderExecution:
    """Executes the master's orders.

    Parameters
    ----------
    places : dict of str to PlaceLink
        The open places by name; adopted places are added, closed ones are removed.
    control : ControlServer
        Sends the orders to machines.
    links : LinkServer
        Admits the containers that were started.
    times : StartTimes
        Start times of the containers.
    checkpoints : CheckpointSelection
        Selects the checkpoints that clones start from.
    start_timeout : float
        Time within which a container must dial the robot link [s].
    not_come : callable
        Called with machine, container and reason if a start failed, and for every container after its start timeout.
    adopted : callable
        Called with the name of a place that adopted a container of an earlier cloud process.
    """

    def __init__(
        self,
        places: dict[str, PlaceLink],
        control: ControlServer,
        links: LinkServer,
        times: StartTimes,
        checkpoints: CheckpointSelection,
        *,
        start_timeout: float,
        not_come: Callable[[str, str, PPaaSError], None],
        adopted: Callable[[str], None],
    ) -> None:
        self._places = places
        self._control = control
        self._links = links
        self._times = times
        self._checkpoints = checkpoints
        self._start_timeout = start_timeout
        self._not_come = not_come
        self._notify_adopted = adopted
        self._background = Background()

    def execute(self, order: Order) -> None:
        """Execute an order; slow steps run in the background."""
        match order:
            case Start():
                self._times.order(order.spec.id)
                self._background.run(self._start(order))
            case Adopt():
                self._adopt(order)
            case End():
                self._end(order)
            case Leave():
                self._let_leave(order)
            case Resize():
                self._resize(order)
            case UseMap():
                self._use_map(order)
            case Close():
                place = self._places.pop(order.place, None)
                logger.error("%s is closed: %s", order.place, order.reason)
                if place is not None:
                    place.close(order.reason)

    async def cancel(self) -> None:
        """Cancel background tasks."""
        await self._background.cancel()

    async def _start(self, order: Start) -> None:
        container = order.spec.id
        try:
            await asyncio.sleep(order.delay)
            spec = await asyncio.to_thread(self._checkpoints.with_checkpoint, order.spec)
            if not self._times.is_awaited(container):
                return  # it was ended or replaced meanwhile
            self._send_start(order.machine, spec)
        except PPaaSError as error:
            self._not_come(order.machine, container, error)
        except Exception as error:
            logger.exception("container %s could not be started", container)
            self._not_come(order.machine, container, PPaaSError(f"internal error: {type(error).__name__}"))
        else:
            await self._answered(order.machine, container)

    async def _answered(self, machine: str, container: str) -> None:
        left = self._start_timeout
        while left > 0.0:
            await asyncio.sleep(left)
            left = self._times.patience(container, self._start_timeout)  # more than 0 if it waits for kernels
        self._not_come(machine, container, Unavailable(f"it did not answer within {self._start_timeout:g} s"))

    def _adopt(self, order: Adopt) -> None:
        container = order.carried.spec.id
        logger.info("container %s of machine %s is adopted", container, order.machine)
        if order.place not in self._places:
            self._places[order.place] = PlaceLink(order.place, base_frame(order.carried.spec.robot))
        self._times.order(container)
        self._links.expect(container, order.carried.secret, order.machine)
        self._background.run(self._answered(order.machine, container))
        self._notify_adopted(order.place)

    def _send_start(self, machine: str, spec: ContainerSpec) -> None:
        self._times.send(spec.id)
        secret = secrets.token_urlsafe(24)
        # Before the order is sent, since the container dials as soon as it runs.
        self._links.expect(spec.id, secret, machine)
        self._control.order(machine, control_link.StartContainer(spec, secret, str(self._links.path)))

    def _end(self, order: End) -> None:
        self._links.forget(order.container)
        self._times.forget(order.container)
        try:
            self._control.order(order.machine, control_link.StopContainer(order.container))
        except Unavailable:
            logger.info("container %s was lost with its machine", order.container)

    def _let_leave(self, order: Leave) -> None:
        logger.info("container %s leaves machine %s, or the map of its robot", order.container, order.machine)
        place = self._places.get(order.place)
        if place is not None:
            place.release()
        with contextlib.suppress(Unavailable):  # the machine has just left, which is reported on its own
            self._control.order(order.machine, control_link.StopContainer(order.container, grace=LEAVE_GRACE))

    def _resize(self, order: Resize) -> None:
        with contextlib.suppress(Unavailable):  # the machine has left; the next container has the new size
            self._control.order(order.machine, control_link.ResizeContainer(order.container, order.cores))

    def _use_map(self, order: UseMap) -> None:
        spec, robot = order.spec, order.spec.robot
        masks, in_space = ({}, False) if robot is None else (robot.masks, robot.in_space)
        logger.info("container %s goes on with version %s of map %r", spec.id, spec.map.version, spec.map.id)
        with contextlib.suppress(Unavailable):  # the machine has left; the next container has the new version
            self._control.order(order.machine, control_link.UseMapVersions(spec.id, spec.map, masks, in_space))


# -- machines ----------------------------------------------------------------------------------------------------------

RETURN_TIMEOUT = (MISSED + 1) * BEAT_PERIOD
"""Time for which robots wait for the machines of an earlier cloud process [s]. The containers of a machine that has not
reconnected by then no longer write checkpoints."""


class MachineEvents:
    """Passes the events of the control links to the master.

    Parameters
    ----------
    master : Master
        Master that gets the events.
    checkpoints : CheckpointSelection
        Decides which reported containers are still the clones of their robots.
    links : LinkServer
        Closes the links of containers that are lost with their machine.
    times : StartTimes
        Start times of the containers.
    counts : ControlCounts
        Counts the machines that are lost.
    execute : callable
        Executes the master's orders.
    container_lost : callable
        Called with the machine and the id of a container that ended, and the reason.
    alive : callable
        Called with the machine and the id of a container that compiles a kernel, once for each heartbeat of its agent.
    listener : CloudListener
        Notified of machines that join and leave.
    machine_lost : callable
        Called with each machine that is lost.

    Attributes
    ----------
    joined : Event
        Set once the first machine has joined.
    """

    def __init__(
        self,
        master: Master,
        checkpoints: CheckpointSelection,
        links: LinkServer,
        times: StartTimes,
        counts: ControlCounts,
        *,
        execute: Callable[[list[Order]], None],
        container_lost: Callable[[str, str, PPaaSError], None],
        alive: Callable[[str, str], None],
        listener: CloudListener,
        machine_lost: Callable[[str], None],
    ) -> None:
        self._master = master
        self._checkpoints = checkpoints
        self._links = links
        self._times = times
        self._counts = counts
        self._execute = execute
        self._container_lost = container_lost
        self._beats: Counter[str] = Counter()
        self._background = Background()
        self._closing = False
        self.joined = asyncio.Event()
        self._listener = listener
        self._machine_lost = machine_lost
        self._starting: dict[str, KernelProgress | None] = {}
        self._compiling: dict[str, KernelProgress] = {}
        self._alive = alive

    def listen(self, path: Path, secret: str) -> ControlServer:
        """Return the server of the control links, which reports its events to this object."""
        self._control = ControlServer(path, secret, self)
        return self._control

    async def close(self) -> None:
        """Stop waiting for machines; from now on, machines leave as expected."""
        self._closing = True
        await self._background.cancel()

    # -- machines of an earlier cloud process --------------------------------------------------------------------------

    def expect_back(self, machines: Iterable[str]) -> None:
        """Make robots wait up to `RETURN_TIMEOUT` for these machines, which may still run their clones."""
        self._execute(self._master.handle(MachinesExpected(tuple(machines))))
        if self._master.returning:
            self._background.run(self._wait())

    async def _wait(self) -> None:
        await asyncio.sleep(RETURN_TIMEOUT)
        if self._master.returning:
            logger.warning("machines did not reconnect: %s", ", ".join(sorted(self._master.returning)))
            self._execute(self._master.handle(ReturnTimedOut()))

    # -- machines that start, and kernels ------------------------------------------------------------------------------

    def await_machine(self, machine: str) -> None:
        """Count a machine as starting, until it has registered."""
        self._starting[machine] = None

    def machine_starting(self, machine: str, kernels: KernelProgress | None) -> None:
        """Note how far the kernels of a machine are that has not registered yet."""
        if machine not in self._master.machines:
            self._starting[machine] = kernels

    def machine_start_ended(self, machine: str) -> None:
        """Note that a machine is about to register, or has failed."""
        self._starting.pop(machine, None)

    def check_started(self, machine: str) -> None:
        """Raise ``Starting`` if a machine has not joined yet but is about to: it takes no settings until then."""
        if machine in self._starting and machine not in self._master.machines:
            raise Starting(f"machine {machine!r} is starting: wait until it has joined", retry_after=1.0)

    def start_state(self) -> StartState:
        """Return whether containers can start, and the kernels that machines compile."""
        is_ready = bool(self._master.machines) or not self._starting
        return StartState(is_ready, {**self._compiling, **self._starting})

    # -- reports -------------------------------------------------------------------------------------------------------

    async def machine_registered(self, register: control_link.Register) -> None:
        """Add a machine, and adopt its containers that are still the clones of their robots.

        Raises
        ------
        InvalidInput
            The registration is not valid.
        Conflict
            The machine speaks no protocol of the cloud.
        NotPermitted
            The machine was removed.
        Unavailable
            The store of checkpoints is unreachable.
        """
        protocol = check_registration(register)
        machine = register.machine
        clones = await asyncio.to_thread(self._clones, register.carries) if register.carries else ()
        orders = self._master.handle(
            MachineJoined(
                machine,
                register.cores,
                register.memory,
                register.pid,
                register.labels,
                register.network,
                clones,
                Software(register.release, protocol),
            )
        )
        adopted = tuple(order.carried.spec.id for order in orders if isinstance(order, Adopt))
        epoch = self._control.mandate.epoch
        # Before all other orders: until its welcome a machine stores no checkpoint for its containers.
        self._control.order(machine, control_link.Welcome(self._checkpoints.instance, adopted, epoch, protocol))
        self._beats[machine] = 0
        self._starting.pop(machine, None)
        logger.info("machine %s joined with %d cores and %d containers", machine, register.cores, len(adopted))
        self.joined.set()
        self._execute(orders)
        self._listener.machines_changed(self._master.machines)

    def _clones(self, carries: Iterable[control_link.RunningContainer]) -> tuple[control_link.RunningContainer, ...]:
        return tuple(carried for carried in carries if self._checkpoints.runs_on(carried.spec))

    def machine_said(self, machine: str, event: control_link.FromAgent) -> None:
        """Handle a report of a machine.

        Raises
        ------
        InvalidParameter, NotPermitted
            A value is not possible, or the container runs on another machine; the machine is disconnected.
        """
        match event:
            case control_link.AgentBeat():
                self._beats[machine] += 1
                self._note_kernels(machine, event)
            case control_link.Heartbeat():
                self._execute(self._master.handle(MachineMeasured(machine, event)))
                self._counts.machine_worked(machine, event.work)
            case control_link.Launched():
                self._execute(self._master.handle(ContainerLaunched(machine, event.container, event.pid)))
            case control_link.LaunchFailed():
                self._container_lost(machine, event.container, error_of(event.refusal))
            case control_link.Exited():
                self._container_lost(machine, event.container, Unavailable(f"it exited with status {event.status}"))

    def _note_kernels(self, machine: str, beat: control_link.AgentBeat) -> None:
        if beat.kernels is None:
            self._compiling.pop(machine, None)
        else:
            self._compiling[machine] = beat.kernels
        for container in beat.compiling:
            self._alive(machine, container)

    def machine_gone(self, machine: str) -> None:
        """Replace the containers of a machine that left."""
        self._beats.pop(machine, None)
        self._compiling.pop(machine, None)
        self._counts.machine_left(machine)
        if machine in self._master.machines and not self._closing:
            self._counts.machines_lost += 1
            self._machine_lost(machine)
        logger.log(logging.INFO if self._closing else logging.WARNING, "machine %s has left", machine)
        self._lose(MachineLeft(machine))
        self._listener.machines_changed(self._master.machines)

    # -- frozen and removed machines -----------------------------------------------------------------------------------

    def beats(self) -> Mapping[str, int]:
        """Return the number of heartbeats of each machine."""
        return self._beats

    def give_up(self, machine: str) -> None:
        """Disconnect a machine that missed its heartbeats."""
        logger.error(
            "machine %s missed %d heartbeats: its agent is frozen, and the machine is disconnected", machine, MISSED
        )
        self._control.hang_up(machine)
        self._listener.machine_frozen(machine)

    def cut_off(self, request: RemovalRequested) -> None:
        """Dismiss a machine that an administrator removes; its containers are replaced."""
        machine = request.machine
        self._lose(request)
        logger.warning("machine %s was removed", machine)
        self._listener.machine_removed(machine)
        self._background.run(self._control.dismiss(machine))

    def _lose(self, event: MachineLeft | RemovalRequested) -> None:
        machine = self._master.machines.get(event.machine)
        lost = tuple(machine.containers) if machine is not None else ()
        orders = self._master.handle(event)
        for container in lost:
            self._links.forget(container)
            # A machine that was cut off may still run it: nothing more of it is heard.
            self._links.hang_up(container)
            self._times.forget(container)
        self._execute(orders)
