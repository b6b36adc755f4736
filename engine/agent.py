"""The agent of a machine: ``python -m engine.agent`` with an ``AgentConfig`` as JSON on standard input.

It starts, in this order, the warm fork server, the router, its session on the fabric and the gate; then it registers
with the master and carries out orders until the master hangs up. Then it ends all it started, and itself.

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
from pathlib import Path

import msgspec
import psutil
import uvloop

from engine import control
from engine.agent_config import AgentConfig
from engine.fabric import Fabric
from engine.framing import FrameStream
from engine.gate import Gate
from engine.heartbeats import BEAT_PERIOD, MISSED
from engine.host_load import HostLoad
from engine.hosting import Hosting
from engine.instances import folder_of, is_dead
from engine.layer_building import LayerBuilder
from engine.lease import Lease
from engine.links.address import parse_address
from engine.links.identity import Identity, Purpose
from engine.links.relay import Relay
from engine.links.sockets import Streams, dial
from engine.mapcache import MapCache
from engine.neighbours import Neighbours
from engine.network_load import NetworkLoad
from engine.router import RouterProcess
from engine.run_dir import keep_temporary_files_in, remove_folder
from engine.runtimes import store_kernels
from engine.runtimes.base import Premises
from engine.runtimes.registry import RUNTIMES
from engine.runtimes.rest_compiler import compiling_the_rest
from ppaas.errors import PPaaSError
from ppaas.plugins import permit_only
from storage.urls import open_map_store, open_store

logger = logging.getLogger(__name__)

HEARTBEAT_PERIOD = 1.0


class Agent:
    """What runs in the agent's process."""

    def __init__(
        self,
        config: AgentConfig,
        stream: FrameStream[control.ToAgent],
        hosting: Hosting,
        lease: Lease | None,
        host: HostLoad,
    ) -> None:
        self._config = config
        self._stream = stream
        self._hosting = hosting
        self._lease = lease
        self._host = host

    async def serve(self, cpus: int) -> None:
        """Register, then carry out orders until the master hangs up."""
        memory = psutil.virtual_memory().total
        own = self._config
        pid, network = os.getpid(), self._host.network
        self._stream.write(control.Register(own.machine, own.secret, pid, cpus, memory, own.labels, network))
        telling = [asyncio.create_task(self._send_beats()), asyncio.create_task(self._send_heartbeats())]
        try:
            while (order := await self._stream.receive()) is not None:
                self._carry_out(order)
        finally:
            for task in telling:
                task.cancel()
            await asyncio.gather(*telling, return_exceptions=True)

    def _carry_out(self, order: control.ToAgent) -> None:
        match order:
            case control.StartContainer():
                self._hosting.start(order)
            case control.StopContainer():
                self._hosting.stop(order)
            case control.ResizeContainer():
                self._hosting.resize(order)
            case control.Heard() if self._lease is not None:
                self._lease.answered()

    async def _send_beats(self) -> None:
        while True:
            if self._lease is not None and not self._lease.beat():
                logger.error("the master did not answer %d beats: it is gone, or the way to it", MISSED)
                self._stream.abort()
            self._stream.write(control.Beat())
            await asyncio.sleep(BEAT_PERIOD)

    async def _send_heartbeats(self) -> None:
        while True:
            await asyncio.sleep(HEARTBEAT_PERIOD)
            self._stream.write(await self._host.measure())


async def dial_cloud(config: AgentConfig, purpose: Purpose) -> Streams:
    """Dial the cloud, as the machine that we are where it is on another host."""
    identity = Identity.in_folder(Path(config.away.identity), "machine") if config.away is not None else None
    return await dial(parse_address(config.control), identity.client_context(purpose) if identity else None)


async def run(config: AgentConfig, told: asyncio.Event) -> bool:
    """Be the agent of a machine until the master hangs up, which is true then, or SIGTERM, which sets ``told``."""
    hung_up = False
    async with contextlib.AsyncExitStack() as stack:
        with until_told(told):
            cpus = tuple(sorted(os.sched_getaffinity(0)))[: config.cores]
            agent = await _start(config, cpus, stack)
            await agent.serve(len(cpus))
            hung_up = True
    if hung_up:  # if the master was killed, nobody else is left to remove the folder of its sockets
        remove_folder(Path(config.run_dir))
    return hung_up


async def _start(config: AgentConfig, cpus: tuple[int, ...], stack: contextlib.AsyncExitStack) -> Agent:
    run_dir = Path(config.run_dir)
    permit_only(config.allowed)
    premises = Premises(config.instance, run_dir, folder_of(config.instance), config.image)
    runtime = RUNTIMES.load(config.runtime).on(premises)
    stack.push_async_callback(runtime.close)
    # Both compile at the first start on a computer, each what it needs, beside each other.
    await asyncio.gather(runtime.start(), asyncio.to_thread(store_kernels.prepare))
    router = RouterProcess(run_dir, peering=config.peering)
    stack.push_async_callback(router.close)
    await router.start()
    fabric = await Fabric.open(router.endpoint, router.credentials)
    stack.push_async_callback(fabric.close)
    store = open_store(config.store, outbox=Path(config.outbox) if config.outbox else None)
    stack.callback(store.close)
    cache = MapCache.of_instance(config.instance, LayerBuilder(open_map_store(config.map_store)))
    stack.callback(cache.remove_all)
    lease = Lease() if config.away is not None else None
    gate = Gate(
        run_dir / "gate.sock",
        store,
        fabric,
        config.away.cloud if config.away is not None else config.instance,
        link=config.machine,
        may_save=lease.holds if lease is not None else lambda: True,
    )
    stack.push_async_callback(gate.close)
    await gate.start()
    relay = await _relay(config, run_dir, stack) if config.away is not None else None
    stream: FrameStream[control.ToAgent] = FrameStream(*await dial_cloud(config, "control"), control.ToAgent)
    stack.push_async_callback(stream.close)
    hosting = Hosting(
        runtime=runtime, gate=gate, cache=cache, cpus=cpus, tell=stream.write, allowed=config.allowed, link=relay
    )
    stack.push_async_callback(hosting.close)
    neighbours = Neighbours(fabric, config.machine)
    stack.push_async_callback(neighbours.close)
    await neighbours.start()
    await stack.enter_async_context(compiling_the_rest())
    return Agent(config, stream, hosting, lease, HostLoad(hosting.loads, NetworkLoad(), neighbours))


async def _relay(config: AgentConfig, run_dir: Path, stack: contextlib.AsyncExitStack) -> str:
    """Open the way of containers to an endpoint on another host; return its Unix socket."""
    relay = Relay(run_dir / "link.sock", lambda: dial_cloud(config, "robot"))
    stack.push_async_callback(relay.close)
    await relay.start()
    return str(relay.path)


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


def main() -> None:
    """Run until the master hangs up; signals from a terminal are the master's to handle."""
    logging.basicConfig(level=logging.INFO, format="%(levelname)s agent %(name)s: %(message)s")
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    config = msgspec.json.decode(sys.stdin.buffer.read(), type=AgentConfig)
    keep_temporary_files_in(Path(config.run_dir))  # it goes with the cloud, should this be killed
    try:
        uvloop.run(run(config, asyncio.Event()))
    except PPaaSError as error:
        logger.error("the machine cannot run: %s", error)
        sys.exit(1)
    finally:
        if is_dead(config.instance):  # it was killed before we reached it
            remove_folder(Path(config.run_dir))


if __name__ == "__main__":
    main()
