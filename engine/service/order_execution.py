"""Executes the orders of the master: containers are started, ended, moved and resized by messages to their machines."""

import asyncio
import contextlib
import logging
import secrets
from collections.abc import Callable

from engine.master.orders import Adopt, Close, End, Leave, Order, Resize, Start
from engine.processes.background import Background
from engine.protocols import control_link
from engine.service.links.control_server import ControlServer
from engine.service.links.place_link import PlaceLink
from engine.service.links.robot_link_server import LinkServer
from engine.service.start_times import StartTimes
from engine.specs.checkpoints import CheckpointSelection
from engine.specs.containers import ContainerSpec
from ppaas.errors import PPaaSError, Unavailable

logger = logging.getLogger(__name__)

LEAVE_GRACE = 5.0
"""Seconds that a container has to keep its state before it is moved as if it had died."""


class OrderExecution:
    """Executes orders.

    Parameters
    ----------
    places : dict of str to PlaceLink
        The open places; one that is adopted is added, one that is closed removed.
    control : ControlServer
        Reaches the machines.
    links : LinkServer
        Awaits the containers.
    times : StartTimes
        Of the containers.
    checkpoints : CheckpointSelection
        Of the clones.
    start_timeout : float
        Seconds that a container has to dial the robot link.
    not_come : callable
        Told machine, container and reason of a container that was started and did not come, or had come by then.
    adopted : callable
        Told of a place that goes on with a container that ran since another cloud process.
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
        self._tell_adopted = adopted
        self._background = Background()

    def execute(self, order: Order) -> None:
        """Execute an order; what it takes time for goes on by itself."""
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
            case Close():
                place = self._places.pop(order.place, None)
                logger.error("%s is closed: %s", order.place, order.reason)
                if place is not None:
                    place.close(order.reason)

    async def cancel(self) -> None:
        """Give up what goes on by itself."""
        await self._background.cancel()

    async def _start(self, order: Start) -> None:
        container = order.spec.id
        try:
            await asyncio.sleep(order.delay)
            spec = await asyncio.to_thread(self._checkpoints.with_checkpoint, order.spec)
            if not self._times.is_awaited(container):
                return  # it was given up meanwhile
            self._send_start(order.machine, spec)
        except PPaaSError as error:
            self._not_come(order.machine, container, error)
        except Exception as error:
            logger.exception("container %s could not be started", container)
            self._not_come(order.machine, container, PPaaSError(f"internal error: {type(error).__name__}"))
        else:
            await self._answered(order.machine, container)

    async def _answered(self, machine: str, container: str) -> None:
        await asyncio.sleep(self._start_timeout)
        self._not_come(machine, container, Unavailable(f"it did not answer within {self._start_timeout:g} s"))

    def _adopt(self, order: Adopt) -> None:
        container = order.carried.spec.id
        logger.info("container %s of machine %s is adopted", container, order.machine)
        if order.place not in self._places:
            self._places[order.place] = PlaceLink(order.place)
        self._times.order(container)
        self._links.expect(container, order.carried.secret, order.machine)
        self._background.run(self._answered(order.machine, container))
        self._tell_adopted(order.place)

    def _send_start(self, machine: str, spec: ContainerSpec) -> None:
        self._times.send(spec.id)
        secret = secrets.token_urlsafe(24)
        self._links.expect(spec.id, secret, machine)
        self._control.order(machine, control_link.StartContainer(spec, secret, str(self._links.path)))

    def _end(self, order: End) -> None:
        self._links.forget(order.container)
        self._times.forget(order.container)
        try:
            self._control.order(order.machine, control_link.StopContainer(order.container))
        except Unavailable:
            logger.info("container %s went with its machine", order.container)

    def _let_leave(self, order: Leave) -> None:
        logger.info("container %s leaves machine %s", order.container, order.machine)
        place = self._places.get(order.place)
        if place is not None:
            place.release()
        with contextlib.suppress(Unavailable):  # its machine went just now, which is told
            self._control.order(order.machine, control_link.StopContainer(order.container, grace=LEAVE_GRACE))

    def _resize(self, order: Resize) -> None:
        with contextlib.suppress(Unavailable):  # its machine is away, and what replaces it has the new size
            self._control.order(order.machine, control_link.ResizeContainer(order.container, order.cores))
