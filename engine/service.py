"""The cloud as the endpoints know it: the master with hands and ears.

It carries out what the master orders, tells the master what happened, and keeps for each place the end of the robot
link that clients talk to.
"""

import asyncio
import contextlib
import logging
import secrets
from collections import Counter
from collections.abc import Callable
from pathlib import Path

from engine import control, link
from engine.administration import Administration, Losing
from engine.background import Background
from engine.checkpoints import Checkpoints
from engine.claims import check_heartbeat, machine_of
from engine.control_server import ControlServer
from engine.framing import FrameStream
from engine.heartbeats import BEAT_PERIOD, MISSED, Heartbeats
from engine.link_server import LinkServer
from engine.master import Master
from engine.model import ContainerSpec
from engine.orders import Close, End, Leave, Order, Resize, Start
from engine.place_link import PlaceLink
from engine.places import Place, PlaceRequest
from engine.queueing import Queue
from engine.start_times import StartTimes
from engine.viewing import container_view, machine_view
from engine.views import ContainerView, MachineView
from ppaas.errors import Conflict, Idle, NotFound, PPaaSError, Unavailable, rebuild

logger = logging.getLogger(__name__)

START_TIMEOUT = 10.0
"""A container that has not dialled the robot link within these seconds is given up and replaced."""

LOOKS = 2
"""Looks in each period of beats: what is frozen is given up 4 to 4.5 s after its last beat, and a robot is served again
within five."""

LEAVE_GRACE = 5.0
"""Seconds that a container has to keep its state before it is moved as if it had died."""


class CloudService:
    """Opens places and keeps them filled.

    Parameters
    ----------
    master : Master
        Decides.
    checkpoints : Checkpoints
        Of the clones.
    run_dir : Path
        Folder for the sockets.
    secret : str
        With which agents register.
    start_timeout : float
        Seconds that a container has to dial the robot link.
    machine_frozen : callable
        Told of a machine whose agent shows no sign of life, for whoever can end it; it was hung up on.
    machine_removed : callable
        Told of a machine that an administrator removed, for whoever would start its agent again.
    """

    def __init__(
        self,
        master: Master,
        checkpoints: Checkpoints,
        run_dir: Path,
        secret: str,
        *,
        start_timeout: float = START_TIMEOUT,
        machine_frozen: Callable[[str], None] = lambda _: None,
        machine_removed: Callable[[str], None] = lambda _: None,
    ) -> None:
        self._master = master
        self._start_timeout = start_timeout
        self._machine_frozen = machine_frozen
        self._machine_removed = machine_removed
        self._checkpoints = checkpoints
        self.administration = Administration(master, self._execute, self._cut_off)
        self._links = LinkServer(run_dir / "link.sock", self._welcome, self._failed)
        self._control = ControlServer(run_dir / "control.sock", secret, self)
        self._places: dict[str, PlaceLink] = {}
        self._times = StartTimes()
        self._queue = Queue(master.quotas)
        self._machine_beats: Counter[str] = Counter()
        self._background = Background()
        self._watching = Background()
        self._machine_joined = asyncio.Event()
        self._closing = False

    @property
    def servers(self) -> tuple[ControlServer, LinkServer]:
        """Return what serves control links and what serves robot links, for those that come from other hosts."""
        return self._control, self._links

    async def start(self) -> None:
        """Listen for containers and machines."""
        await self._links.start()
        await self._control.start()
        self._watching.run(self._watch())

    async def wait_for_machine(self, timeout: float) -> None:
        """Wait until a first machine is here.

        Raises
        ------
        Unavailable
            None came in time.
        """
        try:
            async with asyncio.timeout(timeout):
                await self._machine_joined.wait()
        except TimeoutError as error:
            raise Unavailable(f"no machine registered within {timeout:g} s; see what its agent logged") from error

    async def close(self) -> None:
        """Close all places and let all machines go."""
        self._closing = True
        await self._watching.cancel()
        for key in tuple(self._places):
            await self.close_place(key, Unavailable("the cloud is shutting down"))
        await self._control.close()
        await self._links.close()
        await self._background.cancel()

    # -- places --------------------------------------------------------------------------------------------------------

    def place(self, key: str) -> PlaceLink | None:
        """Return an open place."""
        return self._places.get(key)

    def open_place(self, request: PlaceRequest, *, queue: bool = False) -> PlaceLink:
        """Open a place, or return it if it is open; with ``queue`` it may have to wait for its turn.

        Raises
        ------
        Conflict
            It is open for another version of the map or another size.
        QuotaExceeded, Unavailable, InvalidParameter
            As the master says.
        """
        known = self._places.get(request.key)
        if known is not None:
            if self._request_of(request.key) != request:
                raise Conflict(f"{request.key} is running; disconnect it to run it anew with what was changed")
            return known
        orders = self._queue.open(request, self._master.open) if queue else self._master.open(request)
        place = self._places[request.key] = PlaceLink(request.key)
        place.busy = queue  # who waits is not idle
        self._execute(orders)
        return place

    def _request_of(self, key: str) -> PlaceRequest | None:
        place = self._master.places.get(key)
        return place.request if place is not None else self._queue.get(key)

    def position(self, key: str) -> int | None:
        """Return the position of a place in the queue, the first being 1; None if it does not wait there."""
        return self._queue.position(key)

    def quotas_changed(self) -> None:
        """Serve whoever waits for what users may have now."""
        self._execute([])

    async def close_place(self, key: str, reason: PPaaSError) -> None:
        """Give a place up and tell its clients; one that was idle goes on when somebody comes again."""
        open_now = self._master.places.get(key)
        if isinstance(reason, Idle) and open_now is not None and open_now.request.robot is not None:
            self._checkpoints.park(open_now.request.user, open_now.request.robot.id)
        place = self._places.pop(key, None)
        if place is not None:
            place.close(reason)
        self._queue.remove(key)
        self._execute(self._master.close(key))

    def give_up_container(self, container: str) -> None:
        """Have a container ended as if it had died: its place gets another, and clients notice a pause.

        Raises
        ------
        NotFound
            There is no such container, or no longer.
        Unavailable
            Its machine is away.
        """
        self._control.order(self._master.carrier(container), control.StopContainer(container, grace=0.0))

    def resize_container(self, container: str, cores: float) -> None:
        """Give a container another size while it runs; raises as ``Master.resize`` does."""
        self._execute(self._master.resize(container, cores))

    # -- orders --------------------------------------------------------------------------------------------------------

    def _execute(self, orders: list[Order]) -> None:
        for order in [*orders, *([] if self._closing else self._queue.serve(self._master.open))]:
            match order:
                case Start():
                    self._times.order(order.spec.id)
                    self._background.run(self._start(order))
                case End():
                    self._end(order)
                case Leave():
                    self._let_leave(order)
                case Resize():
                    self._resize(order)
                case Close():
                    place = self._places.pop(order.place, None)
                    logger.error("%s is closed: %s", order.place, order.reason)
                    if place is not None:
                        place.close(order.reason)

    async def _start(self, order: Start) -> None:
        container = order.spec.id
        try:
            await asyncio.sleep(order.delay)
            spec = await asyncio.to_thread(self._checkpoints.give, order.spec)
            if not self._times.is_awaited(container):
                return  # it was given up meanwhile
            self._send_start(order.machine, spec)
            await asyncio.sleep(self._start_timeout)
            reason: PPaaSError = Unavailable(f"it did not answer within {self._start_timeout:g} s")
        except PPaaSError as error:
            reason = error
        except Exception as error:
            logger.exception("container %s could not be started", container)
            reason = PPaaSError(f"internal error: {type(error).__name__}")
        if self._times.is_awaited(container):
            self._execute([End(order.machine, container)])
            self._container_lost(container, reason)

    def _send_start(self, machine: str, spec: ContainerSpec) -> None:
        self._times.send(spec.id)
        secret = secrets.token_urlsafe(24)
        self._links.expect(spec.id, secret, machine)
        self._control.order(machine, control.StartContainer(spec, secret, str(self._links.path)))

    def _end(self, order: End) -> None:
        self._links.forget(order.container)
        self._times.forget(order.container)
        try:
            self._control.order(order.machine, control.StopContainer(order.container))
        except Unavailable:
            logger.info("container %s went with its machine", order.container)

    def _let_leave(self, order: Leave) -> None:
        logger.info("container %s leaves machine %s", order.container, order.machine)
        place = self._places.get(order.place)
        if place is not None:
            place.release()
        with contextlib.suppress(Unavailable):  # its machine went just now, which is told
            self._control.order(order.machine, control.StopContainer(order.container, grace=LEAVE_GRACE))

    def _resize(self, order: Resize) -> None:
        with contextlib.suppress(Unavailable):  # its machine is away, and what replaces it has the new size
            self._control.order(order.machine, control.ResizeContainer(order.container, order.cores))

    # -- what happens --------------------------------------------------------------------------------------------------

    async def _welcome(self, hello: link.Hello, stream: FrameStream[link.FromContainer]) -> None:
        key = self._master.container_ready(hello.container, hello.pid)
        place = self._places.get(key) if key is not None else None
        if place is None:
            return
        self._times.answer(hello.container)
        self._execute(self._master.move_on())
        await place.serve(hello, stream)

    def _failed(self, failed: link.Failed) -> None:
        self._container_lost(failed.container, rebuild(failed.refusal.slug, failed.refusal.text))

    def machine_registered(self, register: control.Register) -> None:
        """Take a machine in.

        Raises
        ------
        InvalidInput
            It is none.
        NotPermitted
            It was removed.
        """
        machine = machine_of(register)
        orders = self._master.machine_joined(machine)
        self._machine_beats[machine.id] = 0
        logger.info("machine %s joined with %d cores", machine.id, machine.cores)
        self._machine_joined.set()
        self._execute(orders)

    def machine_said(self, machine: str, event: control.FromAgent) -> None:
        """Take news of a machine, which says nothing of the containers of others.

        Raises
        ------
        InvalidParameter, NotPermitted
            It says what cannot be: it is cut off.
        """
        if isinstance(event, control.Launched | control.LaunchFailed | control.Exited):
            self._master.check_carries(machine, event.container)
        match event:
            case control.Beat():
                self._machine_beats[machine] += 1
            case control.Heartbeat():
                self._note_load(machine, event)
            case control.Launched():
                self._master.container_launched(event.container, event.pid)
            case control.LaunchFailed():
                self._container_lost(event.container, rebuild(event.refusal.slug, event.refusal.text))
            case control.Exited():
                self._container_lost(event.container, Unavailable(f"it ended with status {event.status}"))

    def machine_gone(self, machine: str) -> None:
        """Place anew what a machine carried."""
        self._machine_beats.pop(machine, None)
        logger.log(logging.INFO if self._closing else logging.WARNING, "machine %s is gone", machine)
        self._lost_with(machine, self._master.machine_left)

    def _cut_off(self, machine: str, lose: Losing) -> None:
        self._lost_with(machine, lose)
        logger.warning("machine %s was removed", machine)
        self._machine_removed(machine)
        self._control.hang_up(machine)

    def _lost_with(self, machine_id: str, lose: Losing) -> None:
        machine = self._master.machines.get(machine_id)
        lost = tuple(machine.containers) if machine is not None else ()
        orders = lose(machine_id)
        for container in lost:
            self._links.forget(container)
            self._links.hang_up(container)
            self._times.forget(container)
        self._execute(orders)

    def _container_lost(self, container: str, reason: PPaaSError) -> None:
        self._links.forget(container)
        self._times.forget(container)
        level = logging.INFO if self._master.is_leaving(container) else logging.WARNING
        orders = self._master.container_lost(container, reason)
        if orders:
            logger.log(level, "container %s is lost: %s", container, reason)
        self._execute(orders)

    # -- what is frozen ------------------------------------------------------------------------------------------------

    async def _watch(self) -> None:
        """End what is connected and shows no sign of life, so that it is replaced as if it had died."""
        containers, machines = Heartbeats(looks=LOOKS), Heartbeats(looks=LOOKS)
        while True:
            await asyncio.sleep(BEAT_PERIOD / LOOKS)
            frozen = machines.look(self._machine_beats)
            beats = {place.container: place.beats for place in self._places.values() if place.container is not None}
            for key, place in self._places.items():
                if place.round_trip is not None:
                    self._master.robot_timed(key, place.round_trip)
            for machine in frozen:
                logger.error("machine %s missed %d beats: its agent is frozen, and given up", machine, MISSED)
                self._control.hang_up(machine)
                self._machine_frozen(machine)
            for container in containers.look(beats):
                logger.error("container %s missed %d beats: it is frozen, and replaced", container, MISSED)
                with contextlib.suppress(NotFound, Unavailable):  # it went just now
                    self.give_up_container(container)

    def _note_load(self, machine_id: str, heartbeat: control.Heartbeat) -> None:
        machine = self._master.machines.get(machine_id)
        if machine is not None:
            check_heartbeat(machine, heartbeat)
            machine.cpu, machine.memory_used = heartbeat.cpu, heartbeat.memory_used
            machine.network_used, machine.neighbours = heartbeat.network_used, heartbeat.round_trips
            machine.average_round_trips()
            machine.loads = {load.container: load for load in heartbeat.containers}
            self._master.machine_measured(machine_id)

    # -- what may be looked at -----------------------------------------------------------------------------------------

    def machines(self) -> list[MachineView]:
        """Return all machines."""
        return [machine_view(machine) for machine in self._master.machines.values()]

    def containers(self, user: str | None) -> list[ContainerView]:
        """Return the containers of a user, or all."""
        places = (place for place in self._master.places.values() if user in (None, place.request.user))
        return [view for place in places if (view := self._view(place)) is not None]

    def _view(self, place: Place) -> ContainerView | None:
        container = place.spec.id if place.spec is not None else ""
        machine = self._master.machines.get(place.machine or "")
        link = self._places.get(place.request.key)
        return container_view(place, machine, link, self._times.age(container), self._times.took(container))
