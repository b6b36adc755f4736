"""Executes the master's orders: starts, ends, moves and resizes containers by messages to their machines."""

import asyncio
import contextlib
import logging
import secrets
from collections.abc import Callable

from engine.master.orders import Adopt, Close, End, Leave, Order, Resize, Start, UseMap
from engine.processes.background import Background
from engine.protocols import control_link
from engine.service.links.control_server import ControlServer
from engine.service.links.place_link import PlaceLink
from engine.service.links.robot_link_server import LinkServer
from engine.service.start_times import StartTimes
from engine.specs.checkpoints import CheckpointSelection
from engine.specs.containers import ContainerSpec
from engine.specs.robot_frames import base_frame
from ppaas.errors import PPaaSError, Unavailable

logger = logging.getLogger(__name__)

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
        logger.info("container %s leaves machine %s", order.container, order.machine)
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
            self._control.order(order.machine, control_link.UseMap(spec.id, spec.map, masks, in_space))
