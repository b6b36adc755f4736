"""The agent of a machine: ``python -m engine.agent`` with an ``AgentConfig`` as JSON on standard input.

It starts, in this order, the warm fork server, the router, its session on the fabric and the gate; then it registers
with the master and carries out orders until the master hangs up. Then it ends all it started, and itself.
"""

import asyncio
import contextlib
import logging
import os
import shutil
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
from engine.heartbeats import BEAT_PERIOD
from engine.hosting import Hosting
from engine.layer_building import LayerBuilder
from engine.mapcache import MapCache
from engine.router import RouterProcess
from engine.runtimes import store_kernels
from engine.runtimes.process import ProcessRuntime
from engine.runtimes.rest_compiler import compiling_the_rest
from ppaas.errors import PPaaSError, Unavailable
from storage.urls import open_map_store, open_store

logger = logging.getLogger(__name__)

HEARTBEAT_PERIOD = 1.0


class Agent:
    """What runs in the agent's process."""

    def __init__(self, config: AgentConfig, stream: FrameStream[control.ToAgent], hosting: Hosting) -> None:
        self._config = config
        self._stream = stream
        self._hosting = hosting
        self._cpu_seconds: dict[str, float] = {}
        self._measured = 0.0

    async def serve(self, cpus: int) -> None:
        """Register, then carry out orders until the master hangs up."""
        memory = psutil.virtual_memory().total
        self._stream.write(control.Register(self._config.machine, self._config.secret, os.getpid(), cpus, memory))
        telling = [asyncio.create_task(self._send_beats()), asyncio.create_task(self._send_heartbeats())]
        try:
            while (order := await self._stream.receive()) is not None:
                if isinstance(order, control.StartContainer):
                    self._hosting.start(order)
                else:
                    self._hosting.stop(order)
        finally:
            for task in telling:
                task.cancel()
            await asyncio.gather(*telling, return_exceptions=True)

    async def _send_beats(self) -> None:
        while True:
            self._stream.write(control.Beat())
            await asyncio.sleep(BEAT_PERIOD)

    async def _send_heartbeats(self) -> None:
        psutil.cpu_percent()
        while True:
            await asyncio.sleep(HEARTBEAT_PERIOD)
            loads = await asyncio.to_thread(self._hosting.loads)
            cpu = psutil.cpu_percent() / 100.0 * (psutil.cpu_count() or 1)
            used = psutil.virtual_memory().used
            self._stream.write(control.Heartbeat(cpu, used, self._as_rates(loads)))

    def _as_rates(self, loads: list[control.ContainerLoad]) -> list[control.ContainerLoad]:
        now = asyncio.get_running_loop().time()
        seconds, self._measured = now - self._measured, now
        before, self._cpu_seconds = self._cpu_seconds, {load.container: load.cpu for load in loads}
        return [
            control.ContainerLoad(load.container, (load.cpu - before.get(load.container, load.cpu)) / seconds, load.pss)
            for load in loads
        ]


async def _dial(config: AgentConfig) -> FrameStream[control.ToAgent]:
    try:
        reader, writer = await asyncio.open_unix_connection(config.control)
    except OSError as error:
        raise Unavailable(f"the master does not answer at {config.control}: {error}") from error
    return FrameStream(reader, writer, control.ToAgent)


async def run(config: AgentConfig) -> None:
    """Be the agent of a machine until the master hangs up, or SIGTERM."""
    hung_up = False
    async with contextlib.AsyncExitStack() as stack:
        with _until_told():
            cpus = tuple(sorted(os.sched_getaffinity(0)))[: config.cores]
            agent = await _start(config, cpus, stack)
            await agent.serve(len(cpus))
            hung_up = True
    if hung_up:  # if the master was killed, nobody else is left to remove the folder of its sockets
        shutil.rmtree(config.run_dir, ignore_errors=True)


async def _start(config: AgentConfig, cpus: tuple[int, ...], stack: contextlib.AsyncExitStack) -> Agent:
    run_dir = Path(config.run_dir)
    runtime = ProcessRuntime(rehearsed="engine.rehearsed")
    stack.push_async_callback(runtime.close)
    # Both compile at the first start on a computer, each what it needs, beside each other.
    await asyncio.gather(runtime.start(), asyncio.to_thread(store_kernels.prepare))
    router = RouterProcess(run_dir)
    stack.push_async_callback(router.close)
    await router.start()
    fabric = await Fabric.open(router.endpoint, router.credentials)
    stack.push_async_callback(fabric.close)
    store = open_store(config.store, outbox=Path(config.outbox) if config.outbox else None)
    stack.callback(store.close)
    cache = MapCache.of_instance(config.instance, LayerBuilder(open_map_store(config.map_store)))
    stack.callback(cache.remove_all)
    gate = Gate(run_dir / f"gate-{config.machine}.sock", store, fabric, config.instance, link=config.machine)
    stack.push_async_callback(gate.close)
    await gate.start()
    stream = await _dial(config)
    stack.push_async_callback(stream.close)
    hosting = Hosting(runtime=runtime, gate=gate, cache=cache, cpus=cpus, tell=stream.write)
    stack.push_async_callback(hosting.close)
    await stack.enter_async_context(compiling_the_rest())
    return Agent(config, stream, hosting)


@contextlib.contextmanager
def _until_told() -> Iterator[None]:
    """Give up what is inside on SIGTERM; whatever comes after it, as the end of what was started, is not disturbed."""
    loop, task = asyncio.get_running_loop(), asyncio.current_task()
    if task is None:
        raise RuntimeError("there is no task to give up")
    told = asyncio.Event()

    def tell() -> None:
        if not told.is_set():
            told.set()
            task.cancel()

    loop.add_signal_handler(signal.SIGTERM, tell)
    try:
        yield
    except asyncio.CancelledError:
        if not told.is_set():
            raise
        task.uncancel()
    finally:
        told.set()


def main() -> None:
    """Run until the master hangs up; signals from a terminal are the master's to handle."""
    logging.basicConfig(level=logging.INFO, format="%(levelname)s agent %(name)s: %(message)s")
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    config = msgspec.json.decode(sys.stdin.buffer.read(), type=AgentConfig)
    try:
        uvloop.run(run(config))
    except PPaaSError as error:
        logger.error("the machine cannot run: %s", error)
        sys.exit(1)


if __name__ == "__main__":
    main()
