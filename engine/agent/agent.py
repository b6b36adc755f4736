"""The agent of a machine.

It starts its parts, registers with the master and carries out orders until the master dismisses it. Then it ends all it
started, and itself. A master that hangs up without a word was killed, or the way to it is cut: the agent keeps what it
carries for some time, dials again, and tells whoever answers of it. So does one that carries nothing: to start another
takes longer than to start the master, on the same cores.

On another host than the master's it dials over TLS, relays what its containers say to their endpoint, and hangs up by
itself when the master is silent: the connection may not tell that somebody cut the way.
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

import msgspec
import psutil
import uvloop

from engine.agent.components import Parts, dial_master, open_parts
from engine.agent.config import AgentConfig
from engine.agent.master_redial import Dial, Master, Redial
from engine.processes.heartbeats import BEAT_PERIOD, MISSED
from engine.processes.instances import is_dead
from engine.processes.run_dir import remove_unless_owned
from engine.protocols import control_link
from ppaas import __version__
from ppaas.errors import Conflict, PPaaSError

logger = logging.getLogger(__name__)

HEARTBEAT_PERIOD = 1.0


class Agent:
    """What runs in the agent's process."""

    def __init__(self, parts: Parts) -> None:
        self._parts = parts
        self._hosting = parts.hosting
        self._standing = parts.standing
        self._dismissed = False
        self._redial: Redial | None = None

    async def stay(self, dial: Dial) -> None:
        """Serve one master after the other, until one dismisses us or none comes in time."""
        stream: Master | None = await dial()
        while stream is not None:
            await self.serve(stream)
            if self._dismissed:
                return
            if self._redial is None:
                within = self._parts.config.adopt_within
                logger.warning("the master is gone: what runs here waits for %g s for it, or another", within)
                self._redial = Redial(within)
            stream = await self._redial(dial)

    async def serve(self, stream: Master) -> None:
        """Register, then carry out orders until the master hangs up."""
        self._standing.begin(stream)
        stream.write(self._register())
        telling = [asyncio.create_task(work(stream)) for work in (self._send_beats, self._send_heartbeats)]
        try:
            while not self._dismissed and (order := await stream.receive()) is not None:
                self._carry_out(order)
        finally:
            self._standing.lost()
            for task in telling:
                task.cancel()
            await asyncio.gather(*telling, return_exceptions=True)
            await stream.close()

    def _register(self) -> control_link.Register:
        own, memory = self._parts.config, psutil.virtual_memory().total
        return control_link.Register(
            own.machine,
            own.secret,
            os.getpid(),
            cores=len(self._parts.cpus),
            memory=memory,
            labels=own.labels,
            network=self._parts.host.network,
            carries=self._hosting.carried(),
            release=__version__,
        )

    def _carry_out(self, order: control_link.ToAgent) -> None:
        match order:
            case control_link.Welcome():
                self._go_on(order)
            case control_link.StartContainer():
                self._hosting.start(order)
            case control_link.StopContainer():
                self._hosting.stop(order)
            case control_link.ResizeContainer():
                self._hosting.resize(order)
            case control_link.BeatAcknowledged() if self._standing.lease is not None:
                self._standing.lease.answered()
            case control_link.Dismissed():
                self._dismissed = True

    def _go_on(self, welcome: control_link.Welcome) -> None:
        self._hosting.keep_only(welcome.adopted)
        self._hosting.endpoint_came()
        self._parts.gate.cloud = welcome.cloud
        self._standing.welcome()
        self._redial = None
        if welcome.adopted:
            logger.info("the master is back and has adopted %d containers", len(welcome.adopted))

    async def _send_beats(self, stream: Master) -> None:
        lease = self._standing.lease
        while True:
            if lease is not None and not lease.beat():
                logger.error("the master did not answer %d beats: it is gone, or the way to it", MISSED)
                stream.abort()
            stream.write(control_link.AgentBeat())
            await asyncio.sleep(BEAT_PERIOD)

    async def _send_heartbeats(self, stream: Master) -> None:
        while True:
            await asyncio.sleep(HEARTBEAT_PERIOD)
            stream.write(await self._parts.host.measure())


async def run(config: AgentConfig, told: asyncio.Event, dial: Dial | None = None) -> bool:
    """Be the agent of a machine until no master wants it, which is true then, or SIGTERM, which sets ``told``.

    ``dial`` connects to the master, where more is to be done for that than to dial.
    """
    hung_up = False
    async with contextlib.AsyncExitStack() as stack:
        with until_told(told):
            agent = Agent(await open_parts(config, stack))
            try:
                await agent.stay(dial or partial(dial_master, config))
            except Conflict as error:
                logger.warning("what runs here ends: %s", error)
            hung_up = True
    if hung_up:  # if the master was killed, nobody else is left to remove the folder of its sockets
        remove_unless_owned(Path(config.run_dir))
    return hung_up


@contextlib.contextmanager
def until_told(told: asyncio.Event) -> Iterator[None]:
    """Give up what is inside on SIGTERM; whatever comes after it, as the end of what was started, is not disturbed.

    Parameters
    ----------
    told : asyncio.Event
        Set by the signal, also where it comes after what is inside.
    """
    loop, task = asyncio.get_running_loop(), asyncio.current_task()
    if task is None:
        raise RuntimeError("there is no task to give up")
    inside = True

    def tell() -> None:
        if inside and not told.is_set():
            task.cancel()
        told.set()

    loop.add_signal_handler(signal.SIGTERM, tell)
    try:
        yield
    except asyncio.CancelledError:
        if not told.is_set():
            raise
        task.uncancel()
    finally:
        inside = False


def be_told(told: bytes) -> None:
    """Be what an ``AgentConfig`` as JSON says until the master hangs up; signals from a terminal are the master's."""
    logging.basicConfig(level=logging.INFO, format="%(levelname)s agent %(name)s: %(message)s")
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    config = msgspec.json.decode(told, type=AgentConfig)
    try:
        uvloop.run(run(config, asyncio.Event()))
    except PPaaSError as error:
        logger.error("the machine cannot run: %s", error)
        sys.exit(1)
    finally:
        if is_dead(config.cloud):  # it was killed, perhaps before we reached it
            remove_unless_owned(Path(config.run_dir))
