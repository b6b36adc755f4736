"""What machines do and tell: they come, say how they are and what became of containers, freeze, and go."""

import asyncio
import logging
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

from engine.master.master import Master
from engine.master.orders import Adopt, Order
from engine.master.report_validation import machine_of, note_load
from engine.processes.background import Background
from engine.processes.heartbeats import BEAT_PERIOD, MISSED
from engine.protocols import control_link
from engine.service.administration import Losing
from engine.service.links.control_server import ControlServer
from engine.service.links.robot_link_server import LinkServer
from engine.service.listener import CloudListener
from engine.service.start_times import StartTimes
from engine.specs.checkpoints import CheckpointSelection
from ppaas.errors import PPaaSError, Unavailable, rebuild

logger = logging.getLogger(__name__)

RETURN_TIMEOUT = (MISSED + 1) * BEAT_PERIOD
"""Seconds for which robots wait for the machines of a cloud process before this one. A machine that is not back by then
keeps no checkpoint any more, whatever runs there."""


class MachineEvents:
    """Hands to the master what comes over the control links.

    Parameters
    ----------
    master : Master
        Decides.
    checkpoints : CheckpointSelection
        Tell what containers are the clones of their robots still.
    links : LinkServer
        Hangs up on containers that are lost with their machine.
    times : StartTimes
        Of the containers.
    execute : callable
        Carries out what the master orders.
    container_lost : callable
        Told of a container that is no more, and why.
    listener : CloudListener
        Told of machines that come and go.

    Attributes
    ----------
    joined : Event
        Set once a first machine is here.
    """

    def __init__(
        self,
        master: Master,
        checkpoints: CheckpointSelection,
        links: LinkServer,
        times: StartTimes,
        *,
        execute: Callable[[list[Order]], None],
        container_lost: Callable[[str, PPaaSError], None],
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

    def listen(self, path: Path, secret: str) -> ControlServer:
        """Return the server of the control links, which tells what happens here."""
        self._control = ControlServer(path, secret, self)
        return self._control

    async def close(self) -> None:
        """Wait for no machine any more; those that go now go in order."""
        self._closing = True
        await self._background.cancel()

    # -- machines of a cloud process before this one -------------------------------------------------------------------

    def expect_back(self, machines: Iterable[str]) -> None:
        """Let robots wait some seconds for these machines, on which their clones may run."""
        self._master.returning.update(machines)
        if self._master.returning:
            self._background.run(self._wait())

    async def _wait(self) -> None:
        await asyncio.sleep(RETURN_TIMEOUT)
        if self._master.returning:
            logger.warning("machines did not return: %s", ", ".join(sorted(self._master.returning)))
            self._execute(self._master.wait_no_more())

    # -- what happens --------------------------------------------------------------------------------------------------

    async def machine_registered(self, register: control_link.Register) -> None:
        """Take a machine in, with those containers that are still the clones of their robots.

        Raises
        ------
        InvalidInput
            It is none.
        NotPermitted
            It was removed, or runs another release of this program.
        Unavailable
            The store that knows whose clones they are is away.
        """
        machine = machine_of(register)
        clones = await asyncio.to_thread(self._clones, register.carries) if register.carries else ()
        orders = self._master.machine_joined(machine, clones)
        adopted = tuple(order.carried.spec.id for order in orders if isinstance(order, Adopt))
        self._control.order(machine.id, control_link.Welcome(self._checkpoints.instance, adopted))
        self._beats[machine.id] = 0
        logger.info("machine %s joined with %d cores and %d containers", machine.id, machine.cores, len(adopted))
        self.joined.set()
        self._execute(orders)
        self._listener.machines_changed(self._master.machines)

    def _clones(self, carries: Iterable[control_link.RunningContainer]) -> list[control_link.RunningContainer]:
        return [carried for carried in carries if self._checkpoints.runs_on(carried.spec)]

    def machine_said(self, machine: str, event: control_link.FromAgent) -> None:
        """Take news of a machine, which says nothing of the containers of others.

        Raises
        ------
        InvalidParameter, NotPermitted
            It says what cannot be: it is cut off.
        """
        if isinstance(event, control_link.Launched | control_link.LaunchFailed | control_link.Exited):
            self._master.check_carries(machine, event.container)
        match event:
            case control_link.AgentBeat():
                self._beats[machine] += 1
            case control_link.Heartbeat():
                self._note_load(machine, event)
            case control_link.Launched():
                self._master.container_launched(event.container, event.pid)
            case control_link.LaunchFailed():
                self._container_lost(event.container, rebuild(event.refusal.slug, event.refusal.text))
            case control_link.Exited():
                self._container_lost(event.container, Unavailable(f"it ended with status {event.status}"))

    def _note_load(self, machine_id: str, heartbeat: control_link.Heartbeat) -> None:
        machine = self._master.machines.get(machine_id)
        if machine is not None:
            note_load(machine, heartbeat)
            self._master.machine_measured(machine_id)

    def machine_gone(self, machine: str) -> None:
        """Place anew what a machine carried."""
        self._beats.pop(machine, None)
        logger.log(logging.INFO if self._closing else logging.WARNING, "machine %s is gone", machine)
        self._lost_with(machine, self._master.machine_left)
        self._listener.machines_changed(self._master.machines)

    # -- what is frozen, and who must go -------------------------------------------------------------------------------

    def beats(self) -> Mapping[str, int]:
        """Return how often each machine has beaten."""
        return self._beats

    def give_up(self, machine: str) -> None:
        """Hang up on a machine that shows no sign of life."""
        logger.error("machine %s missed %d beats: its agent is frozen, and given up", machine, MISSED)
        self._control.hang_up(machine)
        self._listener.machine_frozen(machine)

    def cut_off(self, machine: str, lose: Losing) -> None:
        """Let a machine go that an administrator removed; what it carried is lost with it."""
        self._lost_with(machine, lose)
        logger.warning("machine %s was removed", machine)
        self._listener.machine_removed(machine)
        self._background.run(self._control.dismiss(machine))

    def _lost_with(self, machine_id: str, lose: Losing) -> None:
        machine = self._master.machines.get(machine_id)
        lost = tuple(machine.containers) if machine is not None else ()
        orders = lose(machine_id)
        for container in lost:
            self._links.forget(container)
            self._links.hang_up(container)
            self._times.forget(container)
        self._execute(orders)
