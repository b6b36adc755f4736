"""Drives the master: executes its orders and feeds it events; holds the place link that clients use for each place."""

import asyncio
import contextlib
import logging
from pathlib import Path
from weakref import WeakKeyDictionary

from engine.leadership.mandate import Mandate
from engine.master.events import (
    ContainerLost,
    ContainerReady,
    Event,
    LimitsChanged,
    MapChanged,
    PlaceReleased,
    PlaceRequested,
    RobotTimed,
    ShutdownBegan,
)
from engine.master.master import Master
from engine.master.orders import End, Order
from engine.master.places import PlaceRequest
from engine.processes.background import Background
from engine.processes.heartbeats import MISSED
from engine.processes.liveness import watch
from engine.protocols import robot_link
from engine.protocols.framing import FrameStream
from engine.protocols.refusals import error_of
from engine.service.administration import Administration
from engine.service.containers import Containers
from engine.service.links.control_server import ControlServer
from engine.service.links.place_link import PlaceLink
from engine.service.links.presence import RobotPresence
from engine.service.links.robot_link_server import LinkServer
from engine.service.listener import CloudListener
from engine.service.machine_events import MachineEvents
from engine.service.order_execution import OrderExecution
from engine.service.start_times import StartTimes
from engine.specs.checkpoints import CheckpointSelection
from engine.specs.containers import MapVersion
from engine.specs.robot_frames import base_frame
from engine.specs.start_state import StartState
from ppaas.clock import Clock, monotonic
from ppaas.errors import Conflict, Idle, NotFound, PPaaSError, Unavailable
from storage.records import Limits

logger = logging.getLogger(__name__)

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
        self._times = StartTimes()
        machines = self.of_machines = MachineEvents(
            master, checkpoints, self._links, self._times,
            execute=self._execute, container_lost=self._report_lost, alive=self._compiles, listener=listener,
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

    def set_limits(self, user: str, limits: Limits) -> None:
        """Apply a user's own limits, and open the queued places that they allow."""
        self._handle(LimitsChanged(user, limits))

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
        self._times.answer(hello.container)
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
        level = logging.INFO if self._master.is_leaving(container) else logging.WARNING
        orders = self._master.handle(ContainerLost(container, reason, self._clock(), machine))
        self._links.forget(container)
        self._times.forget(container)
        if orders:
            logger.log(level, "container %s is lost: %s", container, reason)
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
