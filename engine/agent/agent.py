"""Agent of a machine.

The agent starts its components, registers with the master and executes orders until the master dismisses it. Then it
stops everything that it started, and exits. If the connection ends without a dismissal, the master was killed or the
network is down: the agent keeps its containers for `AgentConfig.adopt_within` seconds, dials again, and reports them to
the master that answers. An agent without containers does the same, since starting a new agent takes longer than
starting the master, on the same cores.

On another host than the master's, the agent dials over TLS, relays the robot links of its containers to their endpoint,
and closes the connection when the master misses heartbeats: TCP may not notice that the network is down.
"""

import asyncio
import contextlib
import logging
import os
import signal
import sys
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import psutil
import uvloop

from engine.agent.components import AgentComponents, dial_master, open_components
from engine.agent.config import AgentConfig
from engine.agent.master_session import Dial, Master, MasterDirectory, MasterRedial, OneMaster
from engine.processes.heartbeats import BEAT_PERIOD, MISSED
from engine.processes.instances import is_dead
from engine.processes.run_dir import remove_unless_owned
from engine.protocols import control_link
from engine.protocols.versions import OWN
from engine.runtimes.fork_server import early_start
from engine.tracing.recording import MACHINE, begin_traces, end_traces
from ppaas import __version__
from ppaas.decoding import from_json
from ppaas.errors import Conflict, PPaaSError
from ppaas.log_lines import log_lines

logger = logging.getLogger(__name__)

HEARTBEAT_PERIOD = 1.0
"""Period of load reports to the master [s]."""


class Agent:
    """Agent of one machine: its sessions with one master after another."""

    def __init__(self, components: AgentComponents) -> None:
        self._components = components
        self._hosting = components.hosting
        self._session = components.session
        self._dismissed = False
        self._redial: MasterRedial | None = None
        self._looking: asyncio.Task[None] | None = None

    async def stay(self, dial: Dial) -> None:
        """Serve one master after another, until one dismisses this agent or none is reachable in time."""
        stream: Master | None = await dial()
        while stream is not None:
            await self.serve(stream)
            if self._dismissed:
                return
            if self._redial is None:
                within = self._components.config.adopt_within
                logger.warning(
                    "the master is unreachable: containers keep running for %g s, and the agent dials again",
                    within,
                )
                # The time limit counts from the first loss: a master that refuses this machine does not renew it.
                self._redial = MasterRedial(within)
            stream = await self._redial(dial)

    async def serve(self, stream: Master) -> None:
        """Register, then execute orders until the master dismisses this agent or the connection ends."""
        self._session.begin(stream)
        stream.write(self._register())
        reports = [asyncio.create_task(work(stream)) for work in (self._send_beats, self._send_heartbeats)]
        try:
            while not self._is_finished() and (order := await stream.receive()) is not None:
                self._carry_out(order)
        finally:
            # From here on this machine stores no checkpoint: its containers may be replaced elsewhere.
            self._session.lost()
            tasks = [*reports, *([self._looking] if self._looking is not None else [])]
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
            await stream.close()

    def _is_finished(self) -> bool:
        return self._dismissed or self._session.refused

    def _register(self) -> control_link.Register:
        own, memory = self._components.config, psutil.virtual_memory().total
        return control_link.Register(
            own.machine,
            own.secret,
            os.getpid(),
            cores=len(self._components.cpus),
            memory=memory,
            labels=own.labels,
            network=self._components.host.network,
            carries=self._hosting.carried(),
            release=__version__,
            epoch=self._session.epoch,
            protocols=OWN,
        )

    def _carry_out(self, order: control_link.ToAgent) -> None:
        match order:
            case control_link.Welcome():
                self._on_welcome(order)
            case control_link.StartContainer():
                self._hosting.start(order)
            case control_link.StopContainer():
                self._hosting.stop(order)
            case control_link.ResizeContainer():
                self._hosting.resize(order)
            case control_link.UseMapVersions():
                self._hosting.use_map(order)
            case control_link.BeatAcknowledged():
                self._session.lease.answered(leads=order.leads)
                if not order.leads:
                    self._look_for_another()
            case control_link.MastersChanged():
                routers = self._components.masters.note(order.masters)
                self._components.router.connect_to(routers)
            case control_link.Dismissed():
                self._dismissed = True

    def _on_welcome(self, welcome: control_link.Welcome) -> None:
        if not self._session.welcome(welcome.epoch):
            logger.error(
                "a master of epoch %d is refused: this machine follows one of epoch %d; if the store of the cloud was "
                "restored from a backup, start the machine again",
                welcome.epoch,
                self._session.epoch,
            )
            return
        if self._components.relay is not None:
            self._components.relay.leave_others()
        # The robots of all others are served elsewhere by now.
        self._hosting.keep_only(welcome.adopted)
        # Containers got no Stop, and dial again: at once, if they know that somebody listens.
        self._hosting.endpoint_came()
        self._components.gateway.cloud = welcome.cloud
        self._redial = None
        self._components.router.connect_to(self._components.masters.note(()))
        if welcome.adopted:
            logger.info("the agent is connected to a master again, which adopted %d containers", len(welcome.adopted))

    def _look_for_another(self) -> None:
        if self._looking is None or self._looking.done():
            self._looking = asyncio.create_task(self._leave_if_another_leads())

    async def _leave_if_another_leads(self) -> None:
        """Leave a master that does not lead now, since it is stopped or cut off from the store, for one that does."""
        if await self._components.masters.another_leads():
            logger.warning("another master leads: the agent leaves this one, which does not lead now")
            self._session.hang_up()

    async def _send_beats(self, stream: Master) -> None:
        lease = self._session.lease
        while True:
            if not lease.beat() and self._session.remote:
                logger.error("the master did not answer %d heartbeats: it or the network is down", MISSED)
                stream.abort()
            if lease.is_silent():  # the agent stays with this one if no other leads
                self._look_for_another()
            kernels = self._components.gateway.kernels
            stream.write(control_link.AgentBeat(kernels.compiling(), kernels.progress))
            await asyncio.sleep(BEAT_PERIOD)

    async def _send_heartbeats(self, stream: Master) -> None:
        while True:
            await asyncio.sleep(HEARTBEAT_PERIOD)
            stream.write(await self._components.host.measure())


async def run(
    config: AgentConfig, terminated: asyncio.Event, dial: Dial | None = None, masters: MasterDirectory | None = None
) -> bool:
    """Run the agent of a machine until no master needs it, or until SIGTERM.

    Parameters
    ----------
    config : AgentConfig
        Settings of the machine.
    terminated : asyncio.Event
        Set by SIGTERM.
    dial : callable, optional
        Connects to the master; `dial_master` by default.
    masters : MasterDirectory, optional
        Addresses of the masters; by default, the one in the settings.

    Returns
    -------
    bool
        True if the agent ended because no master needs it, false after SIGTERM.
    """
    hung_up, masters = False, masters or OneMaster(config.control)
    async with contextlib.AsyncExitStack() as stack:
        with until_terminated(terminated):
            agent = Agent(await open_components(config, stack, masters))
            try:
                await agent.stay(dial or partial(dial_master, config, masters))
            except Conflict as error:
                logger.warning("the agent stops, with its containers: %s", error)
            hung_up = True
    early_start.end()  # no process of this machine may outlive its agent
    if hung_up:  # if the master was killed, no other process removes the folder with its sockets
        remove_unless_owned(Path(config.run_dir))
    return hung_up


@contextlib.contextmanager
def until_terminated(terminated: asyncio.Event) -> Iterator[None]:
    """Cancel the body of the ``with`` statement on SIGTERM; code after it, such as clean-up, is not cancelled.

    Parameters
    ----------
    terminated : asyncio.Event
        Set by the signal, even if it arrives after the body has ended.

    Raises
    ------
    RuntimeError
        The caller does not run in an asyncio task.
    """
    loop, task = asyncio.get_running_loop(), asyncio.current_task()
    if task is None:
        raise RuntimeError("until_terminated needs a running asyncio task")
    inside = True

    def terminate() -> None:
        if inside and not terminated.is_set():
            task.cancel()
        terminated.set()

    loop.add_signal_handler(signal.SIGTERM, terminate)
    try:
        yield
    except asyncio.CancelledError:
        if not terminated.is_set():
            raise
        task.uncancel()
    finally:
        inside = False


def run_agent(config_json: bytes) -> None:
    """Run the agent that an ``AgentConfig`` as JSON describes; SIGINT is ignored, since the master handles Ctrl-C."""
    log_lines("%(levelname)s agent %(name)s: %(message)s", process="agent", level=logging.INFO)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    config = from_json(config_json, AgentConfig)
    try:
        begin_traces(MACHINE, config.machine)
        uvloop.run(run(config, asyncio.Event()))
    except PPaaSError as error:
        logger.error("the agent cannot start: %s", error)
        sys.exit(1)
    finally:
        end_traces()
        if is_dead(config.cloud):  # it was killed, perhaps before this agent connected
            remove_unless_owned(Path(config.run_dir))
