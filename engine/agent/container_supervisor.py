"""Container supervisor: starts, watches, resizes and stops the containers of one machine."""

import asyncio
import logging
from collections.abc import AsyncIterator, Callable, Collection
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from pathlib import Path

import msgspec
import psutil

from engine.agent.container_gateway import ContainerGateway
from engine.agent.map_cache import MapCache
from engine.processes.background import Background
from engine.protocols import control_link
from engine.protocols.refusals import refusal_of
from engine.runtimes.base import ContainerProcess, Runtime
from engine.specs import cores
from engine.specs.containers import ContainerSpec, Launch, LayerSpec
from engine.specs.robot_layers import layers_of
from ppaas.errors import PPaaSError, Unavailable
from ppaas.tracing.spans import own_sampling

logger = logging.getLogger(__name__)

RETRY = 2.0
"""Time after which layers that could not be made, or a container that did not answer, are tried again [s]."""


class FollowedMap:
    """Map of one container that runs on this machine: its current layers, and the versions that it is to follow.

    Parameters
    ----------
    spec : ContainerSpec
        Spec of the container.
    layers : Path
        Folder of its layers, in use for it (``MapCache.ensure``).
    used : callable
        Called with spec and layers once the container uses others.

    Attributes
    ----------
    spec, layers
        Those that it uses now.
    """

    def __init__(self, spec: ContainerSpec, layers: Path, used: Callable[[ContainerSpec, Path], None]) -> None:
        self.spec, self.layers = spec, layers
        self._used = used
        self._wanted: control_link.UseMapVersions | None = None
        self._closed = False
        self._task: asyncio.Task[None] | None = None

    def follow(self, order: control_link.UseMapVersions, cache: MapCache, gateway: ContainerGateway) -> None:
        """Follow the versions of an order; of several orders, the last counts. Do nothing after ``close``."""
        if self._closed:
            return
        self._wanted = order
        if self._task is None or self._task.done():
            self._task = asyncio.create_task(self._run(cache, gateway))

    async def close(self, cache: MapCache) -> None:
        """Follow no more versions, because the container has exited, and release its layers."""
        self._closed = True  # an order may arrive while the task ends
        if self._task is not None:
            self._task.cancel()
            await asyncio.gather(self._task, return_exceptions=True)
        cache.release(self.layers)

    async def _run(self, cache: MapCache, gateway: ContainerGateway) -> None:
        while (order := self._wanted) is not None:
            self._wanted = None
            try:
                await self._follow(order, cache, gateway)
            except Unavailable as error:
                logger.warning("container %s does not follow its map yet: %s", self.spec.id, error)
                self._wanted = self._wanted or order
                await asyncio.sleep(RETRY)
            except PPaaSError as error:
                logger.error("container %s goes on with the map before: %s", self.spec.id, error)
            except Exception:
                logger.exception("container %s goes on with the map before after an internal error", self.spec.id)

    async def _follow(self, order: control_link.UseMapVersions, cache: MapCache, gateway: ContainerGateway) -> None:
        spec = self.spec.on_maps(order.map, order.masks, in_space=order.in_space)
        if spec == self.spec:
            return
        layers = await cache.ensure(layers_of(spec))
        try:
            await gateway.until_attached(spec.id)
            await gateway.use_layers(spec, layers, await cache.changes(self.layers, layers))
        except BaseException:
            cache.release(layers)
            raise
        before, self.spec, self.layers = self.layers, spec, layers
        cache.release(before)
        self._used(spec, layers)


@dataclass(slots=True)
class _Supervised:
    """A container, from the order to start it until it has exited."""

    order: control_link.StartContainer
    launch: Launch | None = None
    process: ContainerProcess | None = None
    stopped: asyncio.Event = field(default_factory=asyncio.Event)
    followed: FollowedMap | None = None
    posegraph: Path | None = None

    def uses(self, spec: ContainerSpec, layers: Path) -> None:
        """Note the map versions and the layers that it uses now."""
        self.order = msgspec.structs.replace(self.order, spec=spec)
        if self.launch is not None:
            running = msgspec.structs.replace(spec, cores=self.launch.spec.cores)
            self.launch = msgspec.structs.replace(self.launch, spec=running, layers=str(layers))
        if self.process is not None:
            self.process.layers_grew()


class ContainerSupervisor:
    """Executes the master's orders that concern containers.

    Parameters
    ----------
    runtime : Runtime
        Starts the containers' processes.
    gateway : ContainerGateway
        Container gateway, to which they connect.
    cache : MapCache
        Makes the layers of their maps, and shares them.
    cpus : tuple of int
        Indices of the CPUs that they may use.
    tell : callable
        Sends a report to the master.
    allowed : tuple of str
        Third-party plug-ins that may run in them, each as ``group:name``.
    link : str, optional
        Path of the relay's Unix socket, if the endpoint is on another host.
    machine : str
        Name of the machine.
    """

    def __init__(
        self,
        *,
        runtime: Runtime,
        gateway: ContainerGateway,
        cache: MapCache,
        cpus: tuple[int, ...],
        tell: Callable[[msgspec.Struct], None],
        allowed: tuple[str, ...] = (),
        link: str | None = None,
        machine: str = "",
    ) -> None:
        self._runtime = runtime
        self._gateway = gateway
        self._cache = cache
        self._cpus = cpus
        self._tell = tell
        self._allowed = allowed
        self._link = link
        self._machine = machine
        self._hosted: dict[str, _Supervised] = {}
        self._background = Background()

    def start(self, order: control_link.StartContainer) -> None:
        """Start a container and watch it; report to the master that its launch failed, or its exit status."""
        hosted = self._hosted[order.spec.id] = _Supervised(order)
        self._background.run(self._host(order, hosted))

    async def _host(self, order: control_link.StartContainer, hosted: _Supervised) -> None:
        container = order.spec.id
        try:
            async with self._layers(hosted):
                status = await self._run(order, hosted)
        except PPaaSError as error:
            self._tell_failed(container, error)
        except Exception as error:
            logger.exception("starting or watching container %s failed with an internal error", container)
            self._tell_failed(container, PPaaSError(f"internal error: {type(error).__name__}"))
        else:
            self._tell(control_link.Exited(container, status))
        finally:
            del self._hosted[container]

    def _tell_failed(self, container: str, error: PPaaSError) -> None:
        logger.warning("container %s could not be started: %s", container, error)
        self._tell(control_link.LaunchFailed(container, refusal_of(error)))

    async def _run(self, order: control_link.StartContainer, hosted: _Supervised) -> int:
        container = order.spec.id
        if hosted.stopped.is_set():
            raise Unavailable(f"container {container} was stopped before it was started")
        hosted.launch = self._launch_of(order, hosted.posegraph if hosted.followed is None else hosted.followed.layers)
        self._gateway.expect(order.spec, order.secret, lambda planner: self._prepare(hosted, planner))
        try:
            process = hosted.process = await self._runtime.launch(hosted.launch)
            self._tell(control_link.Launched(container, process.pid))
            if hosted.stopped.is_set():
                # It was stopped while it was started.
                process.kill()
            return await process.wait()
        finally:
            self._gateway.forget(container)

    async def _prepare(self, hosted: _Supervised, planner: str) -> None:
        if hosted.followed is None:
            raise Unavailable(f"a map that changes has no index for planner {planner!r}")
        await self._cache.prepare(hosted.followed.layers, planner)
        if hosted.process is not None:
            hosted.process.layers_grew()

    def _launch_of(self, order: control_link.StartContainer, layers: Path | None) -> Launch:
        return Launch(
            spec=order.spec,
            layers="" if layers is None else str(layers),
            link=self._link or order.link,
            machine=str(self._gateway.path),
            secret=order.secret,
            cpus=self._cpus_for(order.spec),
            threads=cores.threads(order.spec.cores),
            allowed=self._allowed,
            on=self._machine,
            compiled=self._runtime.isolates or self._gateway.kernels.is_complete,
            traces=own_sampling(),
        )

    def _cpus_for(self, spec: ContainerSpec) -> tuple[int, ...]:
        launches = [hosted.launch for hosted in self._hosted.values() if hosted.launch is not None]
        others = [launch for launch in launches if launch.spec.id != spec.id]
        return cores.pick(spec.cores, self._cpus, cores.used((other.spec.cores, other.cpus) for other in others))

    @asynccontextmanager
    async def _layers(self, hosted: _Supervised) -> AsyncIterator[None]:
        """Hold the layers of a container's map, which may be replaced meanwhile; none if its robot makes a new map."""
        spec = hosted.order.spec
        if spec.maps:
            async with self._continued(hosted):
                yield
            return
        followed = hosted.followed = FollowedMap(spec, await self._cache.ensure(layers_of(spec)), hosted.uses)
        try:
            yield
        finally:
            await followed.close(self._cache)

    @asynccontextmanager
    async def _continued(self, hosted: _Supervised) -> AsyncIterator[None]:
        """Hold the pose graph that a robot without a map continues, if there is one."""
        robot = hosted.order.spec.robot
        if robot is None or robot.continued is None:
            yield
            return
        folder = hosted.posegraph = await self._cache.ensure(LayerSpec(robot.continued, 0.0, posegraph=True))
        try:
            yield
        finally:
            self._cache.release(folder)

    def use_map(self, order: control_link.UseMapVersions) -> None:
        """Move the clone in a container to other versions of its map; do nothing if it does not run."""
        hosted = self._hosted.get(order.container)
        if hosted is not None and hosted.followed is not None:
            hosted.followed.follow(order, self._cache, self._gateway)

    def stop(self, order: control_link.StopContainer) -> None:
        """Kill a container that still runs after the grace period; its endpoint has requested its exit already."""
        hosted = self._hosted.get(order.container)
        if hosted is None:
            return
        hosted.stopped.set()
        if hosted.process is not None:
            asyncio.get_running_loop().call_later(order.grace, hosted.process.kill)

    def carried(self) -> tuple[control_link.RunningContainer, ...]:
        """Return the running clones and coordinators, for a master that did not start them.

        Planning containers are not adopted.
        """
        return tuple(
            control_link.RunningContainer(
                # The store decides whether it is still the clone of its robot, and has a later checkpoint.
                msgspec.structs.replace(hosted.order.spec, checkpoint={}),
                hosted.launch.spec.cores,
                hosted.order.secret,
                hosted.process.pid,
            )
            for hosted in self._hosted.values()
            if hosted.order.spec.kind != "planning"
            and hosted.launch is not None
            and hosted.process is not None
            and not hosted.stopped.is_set()
        )

    def keep_only(self, containers: Collection[str]) -> None:
        """Kill all other containers at once, and execute no more requests of theirs."""
        for container in self._hosted.keys() - set(containers):
            self._gateway.shut_out(container)
            # Their robots are served elsewhere, so nothing that they could still store counts.
            self.stop(control_link.StopContainer(container, grace=0.0))

    def endpoint_came(self) -> None:
        """Notify all containers that the endpoint of the new master listens, on the same socket path as before."""
        for hosted in self._hosted.values():
            if hosted.process is not None:
                hosted.process.endpoint_came()
        self._gateway.endpoint_came()

    def resize(self, order: control_link.ResizeContainer) -> None:
        """Resize a container and notify it; do nothing if it has exited."""
        hosted = self._hosted.get(order.container)
        if hosted is None or hosted.launch is None or hosted.process is None:
            return
        spec = msgspec.structs.replace(hosted.launch.spec, cores=order.cores)
        hosted.launch = msgspec.structs.replace(
            hosted.launch, spec=spec, cpus=self._cpus_for(spec), threads=cores.threads(spec.cores)
        )
        hosted.process.resize(hosted.launch)
        self._gateway.resized(spec.id, hosted.launch.threads)
        logger.info("container %s was resized to %g cores, on CPUs %s", spec.id, spec.cores, hosted.launch.cpus)

    def loads(self) -> list[control_link.ContainerLoad]:
        """Return the CPU time and memory of each container; reading them may block for milliseconds."""
        loads = []
        for container, hosted in tuple(self._hosted.items()):
            if hosted.process is None:
                continue
            try:
                observed = psutil.Process(hosted.process.pid)
                with observed.oneshot():
                    cpu = sum(observed.cpu_times()[:2])
                    pss = observed.memory_full_info().pss
            except psutil.Error:
                continue  # it has just exited; the task that watches it reports that
            loads.append(control_link.ContainerLoad(container, cpu, pss))
        return loads

    async def close(self) -> None:
        """Start no more containers, stop all and wait until they have exited."""
        await self._background.cancel()
        await self._runtime.close()
