"""Components of an agent: started before it registers, and kept over all its sessions with masters."""

import asyncio
import contextlib
import os
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from engine.agent.config import AgentConfig
from engine.agent.container_gateway import ContainerGateway
from engine.agent.container_supervisor import ContainerSupervisor
from engine.agent.entries import ENTRIES
from engine.agent.host_load import HostLoad, NetworkLoad, RoundTripProbe
from engine.agent.kernel_service import KernelService
from engine.agent.layer_builder import LayerBuilder
from engine.agent.map_cache import MapCache
from engine.agent.master_session import Master, MasterDirectory, MasterSession, report_start
from engine.agent.relays import EndpointRelay, RobotLinkRelay
from engine.fabric.router import RouterProcess
from engine.fabric.session import Fabric
from engine.processes.background import cancel_all
from engine.processes.instances import folder_of, instance_name
from engine.protocols import control_link
from engine.protocols.address import RELAY, EndpointAddress, TlsAddress, parse_address, reached_as
from engine.protocols.framing import FrameStream
from engine.protocols.sockets import Streams, dial, dial_pinned
from engine.protocols.tls_identity import Purpose, TlsIdentity
from engine.recorder.recorder_process import NO_RECORDER, RecorderProcess, Recordings
from engine.runtimes.base import Premises, Runtime
from engine.runtimes.compilation import kernel_compiler
from engine.runtimes.compilation.kernel_compiler import KernelCompiler
from engine.runtimes.registry import RUNTIMES
from ppaas.errors import Unavailable
from ppaas.plugins import permit_only
from storage.ports import Store
from storage.urls.opening import open_map_store, open_store


@dataclass(frozen=True, slots=True)
class AgentComponents:
    """Components of an agent; ``cpus`` are the indices of the CPUs that its containers may use."""

    config: AgentConfig
    cpus: tuple[int, ...]
    hosting: ContainerSupervisor
    gateway: ContainerGateway
    session: MasterSession
    host: HostLoad
    router: RouterProcess
    masters: MasterDirectory
    relay: RobotLinkRelay | None


async def dial_cloud(config: AgentConfig, purpose: Purpose, address: str) -> Streams:
    """Dial the cloud, with the machine's certificate if the cloud is on another host; ``Unavailable`` if that fails."""
    identity = TlsIdentity.in_folder(Path(config.identity), "machine") if config.identity is not None else None
    return await dial(parse_address(address), identity.client_context(purpose) if identity else None)


async def dial_master(config: AgentConfig, masters: MasterDirectory) -> Master:
    """Dial the current master; ``Unavailable`` if it does not answer."""
    return FrameStream(*await dial_cloud(config, "control", masters.current), control_link.ToAgent)


async def open_components(
    config: AgentConfig, stack: contextlib.AsyncExitStack, masters: MasterDirectory
) -> AgentComponents:
    """Start the fork server and the router concurrently; then the fabric session, the container gateway and the rest.

    Parameters
    ----------
    config : AgentConfig
        Settings of the machine.
    stack : AsyncExitStack
        Stops all components when it is closed.
    masters : MasterDirectory
        Addresses of the masters.
    """
    run_dir, cpus = Path(config.run_dir), tuple(sorted(os.sched_getaffinity(0)))[: config.cores]
    permit_only(config.allowed)
    compiler, starting = _compiler(config, stack, masters)
    listening = _router(config, stack)
    runtime = await _runtime(config, stack, compiler)  # before the session on the fabric, which a fork would end
    router = await listening
    fabric = await _fabric(router, stack)
    session = MasterSession(remote=config.identity is not None)
    store = _store(config, stack)
    cache = MapCache.of_instance(instance_name(), LayerBuilder(open_map_store(config.map_store)))
    stack.callback(cache.remove_all)
    gateway = ContainerGateway(
        run_dir / "gate.sock", store, fabric, link=config.machine, acts=session.acts,
        may_be_replaced=session.may_be_replaced, recordings=_recordings(config, stack),
        kernels=KernelService(compiler),
    )  # fmt: skip
    stack.push_async_callback(gateway.close)
    await gateway.start()
    relay = await _relay(config, stack, masters) if config.identity is not None else None
    await _endpoint_relay(config, stack, masters)
    hosting = ContainerSupervisor(
        runtime=runtime,
        gateway=gateway,
        cache=cache,
        cpus=cpus,
        tell=session.tell,
        allowed=config.allowed,
        link=str(relay.path) if relay is not None else None,
        machine=config.machine,
    )
    stack.push_async_callback(hosting.close)
    neighbours = RoundTripProbe(fabric, config.machine)
    stack.push_async_callback(neighbours.close)
    await neighbours.start()
    await cancel_all((starting,))
    host = HostLoad(hosting.loads, NetworkLoad(), neighbours, gateway.work)
    return AgentComponents(config, cpus, hosting, gateway, session, host, router, masters, relay)


def _compiler(
    config: AgentConfig, stack: contextlib.AsyncExitStack, masters: MasterDirectory
) -> tuple[KernelCompiler, asyncio.Task[None]]:
    """Return the kernel compiler, not yet begun, and the task that reports to the master that the machine starts."""
    compiler = KernelCompiler()
    stack.push_async_callback(compiler.close)
    starting = asyncio.create_task(report_start(config, compiler, partial(dial_master, config, masters)))
    stack.push_async_callback(cancel_all, (starting,))
    return compiler, starting


def _store(config: AgentConfig, stack: contextlib.AsyncExitStack) -> Store:
    outbox, reserve = (Path(path) if path else None for path in (config.outbox, config.reserve))
    store = open_store(config.store, outbox=outbox, reserve=reserve)
    stack.callback(store.close)
    return store


def _recordings(config: AgentConfig, stack: contextlib.AsyncExitStack) -> Recordings:
    """Return the recorder of the machine, whose process starts when a robot is recorded."""
    if config.recordings is None:
        return NO_RECORDER
    recorder = RecorderProcess(Path(config.recordings), Path(config.reserve) if config.reserve else None)
    stack.push_async_callback(recorder.close)
    return recorder


async def _runtime(config: AgentConfig, stack: contextlib.AsyncExitStack, compiler: KernelCompiler) -> Runtime:
    """Return the runtime, once it has started; the compiler goes on with kernels that not every container uses."""
    instance = instance_name()
    premises = Premises(instance, Path(config.run_dir), folder_of(instance), config.image, ENTRIES)
    runtime: Runtime = RUNTIMES.load(config.runtime).on(premises)
    stack.push_async_callback(runtime.close)
    # Both compile kernels at the first start on a host, each its own: do it concurrently.
    await asyncio.gather(runtime.start(), asyncio.to_thread(kernel_compiler.prepare))
    compiler.begin()
    return runtime


def _router(config: AgentConfig, stack: contextlib.AsyncExitStack) -> asyncio.Task[RouterProcess]:
    """Start the router in a task: it starts while the runtime does, which takes longer."""
    router = RouterProcess(Path(config.run_dir), peering=config.peering)
    stack.push_async_callback(router.close)

    async def start() -> RouterProcess:
        await router.start()
        return router

    starting = asyncio.create_task(start())
    stack.push_async_callback(cancel_all, (starting,))
    return starting


async def _fabric(router: RouterProcess, stack: contextlib.AsyncExitStack) -> Fabric:
    fabric = await Fabric.open(router.endpoint, router.credentials)
    stack.push_async_callback(fabric.close)
    return fabric


async def _endpoint_relay(config: AgentConfig, stack: contextlib.AsyncExitStack, masters: MasterDirectory) -> None:
    """Start the relay to endpoints, if there may be some that the containers of this machine cannot dial."""
    peering, run_dir = config.peering, Path(config.run_dir)
    if peering is None and not RUNTIMES.load(config.runtime).isolates:
        return

    async def dial_far(at: EndpointAddress) -> Streams:
        address = parse_address(reached_as(at.far, masters.current))
        if peering is None or not isinstance(address, TlsAddress):
            raise Unavailable(f"this machine reaches no endpoints of other hosts, such as {at.far}")
        identity = TlsIdentity(Path(peering.key), Path(peering.certificate), Path(peering.authority))
        return await dial_pinned(address, identity.pinning_context("robot"), at.fingerprint)

    sockets = run_dir if config.endpoints is None else Path(config.endpoints)
    relay = EndpointRelay(run_dir / RELAY, config.machine, sockets, dial_far)
    stack.push_async_callback(relay.close)
    await relay.start()


async def _relay(config: AgentConfig, stack: contextlib.AsyncExitStack, masters: MasterDirectory) -> RobotLinkRelay:
    path = Path(config.run_dir) / "link.sock"
    relay = RobotLinkRelay(path, lambda address: dial_cloud(config, "robot", address), lambda: masters.current)
    stack.push_async_callback(relay.close)
    await relay.start()
    return relay
