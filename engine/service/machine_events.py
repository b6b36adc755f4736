"""Machine events: machines join, report load and container exits, stop responding, and leave."""

import asyncio
import logging
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

from engine.master.events import (
    ContainerLaunched,
    MachineJoined,
    MachineLeft,
    MachineMeasured,
    MachinesExpected,
    RemovalRequested,
    ReturnTimedOut,
)
from engine.master.master import Master
from engine.master.orders import Adopt, Order
from engine.master.report_validation import check_registration
from engine.processes.background import Background
from engine.processes.heartbeats import BEAT_PERIOD, MISSED
from engine.protocols import control_link
from engine.protocols.refusals import error_of
from engine.service.links.control_server import ControlServer
from engine.service.links.robot_link_server import LinkServer
from engine.service.listener import CloudListener
from engine.service.start_times import StartTimes
from engine.specs.checkpoints import CheckpointSelection
from engine.specs.start_state import KernelProgress, StartState
from ppaas.errors import PPaaSError, Starting, Unavailable

logger = logging.getLogger(__name__)

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
    execute : callable
        Executes the master's orders.
    container_lost : callable
        Called with the machine and the id of a container that ended, and the reason.
    alive : callable
        Called with the machine and the id of a container that compiles a kernel, once for each heartbeat of its agent.
    listener : CloudListener
        Notified of machines that join and leave.

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
        *,
        execute: Callable[[list[Order]], None],
        container_lost: Callable[[str, str, PPaaSError], None],
        alive: Callable[[str, str], None],
        listener: CloudListener,
    ) -> None:
        self._master = master
        self._checkpoints = checkpoints
        self._links = links
        self._times = times
        self._execute = execute
        self._container_lost = container_lost
        self._beats: Counter[str] = Counter()
        self._background = Background()
        self._closing = False
        self.joined = asyncio.Event()
        self._listener = listener
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
        NotPermitted
            The machine was removed, or runs another release than the cloud.
        Unavailable
            The store of checkpoints is unreachable.
        """
        check_registration(register)
        machine = register.machine
        clones = await asyncio.to_thread(self._clones, register.carries) if register.carries else ()
        orders = self._master.handle(
            MachineJoined(
                machine, register.cores, register.memory, register.pid, register.labels, register.network, clones
            )
        )
        adopted = tuple(order.carried.spec.id for order in orders if isinstance(order, Adopt))
        epoch = self._control.mandate.epoch
        self._control.order(machine, control_link.Welcome(self._checkpoints.instance, adopted, epoch))
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
            self._links.hang_up(container)
            self._times.forget(container)
        self._execute(orders)
