"""The runtime of a machine that is a Ray node, as its cloud has it: by orders to its agent, and by what that tells.

All between is real: the watcher, the actor on the node, its agent, which joins by a ticket over mutual TLS, and the
relay by which containers report. The cloud itself is nothing but its desk for machines and the near end of the control
link.
"""

import asyncio
from pathlib import Path
from typing import Any

import msgspec

from engine.fabric.router import RouterProcess
from engine.links.control_server import ControlServer
from engine.protocols import control_link
from engine.protocols.address import TlsAddress
from engine.remote.cluster_settings import ContainerSettings
from engine.remote.machines import RemoteMachines
from engine.remote.ray.config import WatchConfig
from engine.remote.ray.watcher_process import RayMachines, WatcherProcess
from engine.runtimes.base import Premises, Runtime
from engine.runtimes.fork_server.server import UNKNOWN_STATUS
from engine.specs.containers import Launch, MapVersion
from engine.specs.start_state import KernelProgress
from ppaas.errors import PPaaSError, Unavailable, rebuild
from storage.urls.opening import open_map_store, open_store
from tests.ray.ray_cluster import RayCluster
from tests.support.cloud.cloud import shared_memory
from tests.support.engine.launches import Reports
from tests.support.storage.records import house, put_map
from tests.support.waiting import patience

PLUGIN = Path(__file__).parent / "runtime_plugin"
"""Folder on the path of the nodes with the runtime of their agents."""

JOINS = 120.0
"""Time limit until the node becomes a machine [s]."""


class RayContainer:
    """A container on the node, as reported by its agent."""

    def __init__(self, launch: Launch, orders: "RayRuntime") -> None:
        self.id = launch.spec.id
        self._orders = orders
        loop = asyncio.get_running_loop()
        self.launched: asyncio.Future[int] = loop.create_future()
        self._status: asyncio.Future[int] = loop.create_future()

    @property
    def pid(self) -> int:
        return self.launched.result()

    def kill(self) -> None:
        self._orders.give(control_link.StopContainer(self.id, grace=0.0))

    def layers_grew(self) -> None:
        """Do nothing: its agent adds the files."""

    def endpoint_came(self) -> None:
        """Do nothing: the endpoint knows its agent."""

    def resize(self, launch: Launch) -> None:
        self._orders.give(control_link.ResizeContainer(self.id, launch.spec.cores))

    async def wait(self) -> int:
        return await asyncio.shield(self._status)

    def end(self, status: int) -> None:
        if not self._status.done():
            self._status.set_result(status)

    def refuse(self, error: PPaaSError) -> None:
        if not self.launched.done():
            self.launched.set_exception(error)
        self.end(UNKNOWN_STATUS)


class RayRuntime(Runtime):
    """Starts containers on the one node of a cluster.

    Parameters
    ----------
    entry : str
        ``"module:function"`` that they run.
    premises : Premises
        Of the cloud.
    cluster : RayCluster
        Whose node has ``PLUGIN`` on its path.
    reports : Reports
        What containers dial.
    """

    def __init__(self, entry: str, premises: Premises, cluster: RayCluster, reports: Reports) -> None:
        folder = premises.run_dir / "cloud"
        folder.mkdir()
        open_store(f"sqlite:///{folder / 'store.sqlite'}").close()
        (folder / "maps").mkdir()
        maps = f"file://{folder / 'maps'}"
        self._map = put_map(open_map_store(maps), house())
        self._far = RemoteMachines(
            folder / "machines", TlsAddress("127.0.0.1", 0), cloud=premises.instance, own="local",
            store=f"sqlite:///{folder / 'store.sqlite'}", map_store=maps,
            runs=ContainerSettings("contract", entry, ("ppaas.runtimes:contract",)),
        )  # fmt: skip
        self._control = ControlServer(premises.run_dir / "control.sock", "", self)
        router = RouterProcess(premises.run_dir, peering=self._far.peering)
        watched = WatchConfig(cluster.address, str(folder / "machines"), "127.0.0.1")
        self._machines = RayMachines(WatcherProcess(watched), router)
        self._reports = reports
        self._containers: dict[str, RayContainer] = {}
        self._joined: asyncio.Future[control_link.Register] = asyncio.get_running_loop().create_future()

    @classmethod
    def on(cls, premises: Premises) -> "RayRuntime":
        raise Unavailable("only tests create this runtime")

    async def start(self) -> None:
        robots: Any = self._reports
        await self._far.start(self._control, robots, robots)
        await self._machines.start()
        async with patience(JOINS):
            await asyncio.shield(self._joined)

    async def launch(self, launch: Launch) -> RayContainer:
        container = self._containers[launch.spec.id] = RayContainer(launch, self)
        spec = msgspec.structs.replace(launch.spec, map=MapVersion(self._map.id, self._map.version))
        self._control.order(self._machine, control_link.StartContainer(spec, launch.secret, launch.link))
        try:
            await container.launched
        except asyncio.CancelledError:
            container.kill()
            raise
        return container

    def give(self, order: control_link.ToAgent) -> None:
        """Send an order; it is dropped if the machine has left."""
        try:
            self._control.order(self._machine, order)
        except Unavailable:
            return

    def layers(self) -> Path:
        """Return the folder of the map's layers in the shared memory of the machine."""
        [memory] = shared_memory(self._joined.result().pid)
        [info] = memory.rglob("info.json")
        return info.parent

    async def close(self) -> None:
        await self._machines.stop()
        await self._far.close()
        await self._control.close()

    @property
    def _machine(self) -> str:
        return self._joined.result().machine

    # -- events of the control link ------------------------------------------------------------------------------------

    def machine_starting(self, machine: str, kernels: KernelProgress | None) -> None:
        """Do nothing: a test waits for the registration."""

    def machine_start_ended(self, machine: str) -> None:
        """Do nothing, as above."""

    async def machine_registered(self, register: control_link.Register) -> None:
        self._joined.set_result(register)
        self._control.order(register.machine, control_link.Welcome("of this test", ()))

    def machine_said(self, machine: str, event: control_link.FromAgent) -> None:
        match event:
            case control_link.Launched(container, pid):
                self._containers[container].launched.set_result(pid)
            case control_link.Exited(container, status):
                self._containers[container].end(status)
            case control_link.LaunchFailed(container, refusal):
                self._containers[container].refuse(rebuild(refusal.slug, refusal.text))

    def machine_gone(self, machine: str) -> None:
        for container in self._containers.values():
            container.end(UNKNOWN_STATUS)
