"""Composition root of the engine: creates and connects all its parts."""

import asyncio
import contextlib
import logging
import secrets
import shutil
from collections.abc import Collection
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from engine.agent.config import ADOPT_WITHIN, AgentConfig
from engine.container.monitor.parameters import monitor_parameters
from engine.control.administration import MachineRegistry
from engine.control.journeys.calls import JourneyCalls
from engine.control.journeys.leader import JourneyLeader
from engine.control.master_calls.cloud import Cloud
from engine.control.master_calls.server import SOCKET, EndpointServer, Extra
from engine.control.master_driver import RETURN_TIMEOUT, CloudListener, MasterDriver
from engine.control.robot_sessions import RobotSessions
from engine.control.tasks.runner import TaskRunner
from engine.devices.hosts import DeviceHosts
from engine.fabric.router import RouterProcess
from engine.leadership.leadership import Leadership
from engine.local.machine import Agents, LocalMachine, read_record, settle_config
from engine.master.balancers.registry import BALANCERS, DEFAULT
from engine.master.master import Master
from engine.master.places import LINGER
from engine.master.quotas import Quota, Quotas
from engine.processes.background import Background
from engine.processes.instances import instance_name, sweep_stale
from engine.protocols.address import parse_host_port
from engine.remote.cluster_settings import ContainerSettings, EndpointSettings
from engine.remote.endpoint_processes import EndpointProcesses
from engine.remote.ray.config import WatchConfig
from engine.remote.ray.watcher_process import RayMachines, WatcherProcess
from engine.runtimes import registry as runtimes
from engine.specs.checkpoints import CheckpointSelection
from engine.specs.start_state import log_start
from ppaas.errors import InvalidInput, Unavailable
from storage.disk_space import DiskReserve
from storage.ports import MapStore, Store
from storage.recordings import RecordingsFolder
from storage.urls.opening import open_map_store, open_store

if TYPE_CHECKING:
    from engine.remote.machines import RemoteMachines

logger = logging.getLogger(__name__)

OWN_AGENT, MACHINES_HERE = "own-agent.json", "machines-here.json"
"""Names of files that a killed cloud process leaves to the next."""

MACHINE_TIMEOUT, LOOK = 600.0, 1.0
"""Time limit of a start, and the period at which a crashed agent is checked for [s]. The first start on a computer
compiles the kernels; later ones take a second or two."""

HOPELESS = 3
"""Number of exits of the local agent after which the start fails."""


@dataclass(frozen=True, slots=True)
class CloudConfig:
    """Configuration of a cloud.

    Parameters
    ----------
    store, map_store : str
        URLs of the stores.
    listen_machines : str, optional
        Address for machines of other hosts, ``host:port``; the next port is used as well. None to accept none.
    machines : str
        Folder for the certificates and tickets of these machines.
    join_secrets, standby_secrets : str, optional
        Files of secrets with which machines and standbys may join without a ticket.
    masters : tuple of str
        Addresses at which a master of this cloud may listen for machines, each ``host:port``.
    outbox : str, optional
        File in which plans are stored while a remote store is unreachable.
    keep_versions : int, optional
        Number of versions of a map that are kept, beside those that robots use; None for all.
    reserve : str, optional
        Folder for the reserve of disk space; None for no reserve.
    recordings : str, optional
        Folder of the recordings of robots; None to keep none.
    machine : str
        Name of this machine.
    cores : int, optional
        CPUs that containers may use on this machine; None for all.
    quota : Quota
        Quota of users without own limits.
    linger : float
        Time for which the place of a robot outlives its last client [s].
    machine_settings : str, optional
        File for the settings of machines by administrators; without it, they are lost when the cloud ends.
    left : str, optional
        Folder for what a killed cloud process leaves to the next one; None to leave nothing.
    adopt_within : float
        Time for which containers outlive a killed cloud process [s].
    balancer : str
        Name of the balancer, which chooses machines for containers.
    runtime : str
        Name of the runtime that starts the containers of this machine.
    image : str
        Image of the containers, for a runtime that uses images.
    node_priorities : tuple of str
        Priorities of node monitors, unless a robot's file sets its own; empty for the default order.
    allowed : tuple of str
        Plug-ins of other distributions that may run in the cloud, each as ``group:name`` of its entry point.
    device_hosts : tuple of str
        Hosts at which lifts and doors may be: names, addresses, networks, each maybe with a port.
    ray_address : str, optional
        ``host:port`` of a Ray cluster, or ``auto``; its nodes are then the machines, instead of this one.
    ray_endpoints : EndpointProcesses, optional
        Endpoints of each node of the Ray cluster; None for none.
    """

    store: str
    map_store: str
    listen_machines: str | None = None
    machines: str = "machines"
    join_secrets: str | None = None
    standby_secrets: str | None = None
    masters: tuple[str, ...] = ()
    outbox: str | None = None
    reserve: str | None = None
    recordings: str | None = None
    keep_versions: int | None = None
    machine: str = "local"
    cores: int | None = None
    quota: Quota = field(default_factory=Quota)
    linger: float = LINGER
    machine_settings: str | None = None
    left: str | None = None
    adopt_within: float = ADOPT_WITHIN
    balancer: str = DEFAULT
    runtime: str = runtimes.DEFAULT
    image: str = ""
    node_priorities: tuple[str, ...] = ()
    allowed: tuple[str, ...] = ()
    device_hosts: tuple[str, ...] = ()
    ray_address: str | None = None
    ray_endpoints: EndpointProcesses | None = None


def _far_machines(config: CloudConfig, cloud: str) -> "RemoteMachines":
    from engine.remote.join_secrets import JoinSecrets  # noqa: PLC0415
    from engine.remote.machines import RemoteMachines  # noqa: PLC0415 - imports cryptography, for other hosts only

    return RemoteMachines(
        Path(config.machines),
        parse_host_port(config.listen_machines or ""),
        cloud=cloud,
        store=config.store,
        map_store=config.map_store,
        own=config.machine,
        runs=ContainerSettings(config.runtime, config.image, config.allowed, config.adopt_within),
        serves=EndpointSettings(config.quota, config.keep_versions, config.linger),
        join_secrets=JoinSecrets(_path(config.join_secrets), _path(config.standby_secrets)),
        masters=tuple(str(parse_host_port(address)) for address in config.masters),
    )


def _path(text: str | None) -> Path | None:
    return None if text is None else Path(text)


def _agent_config(config: CloudConfig, cloud: str, far: "RemoteMachines | None") -> AgentConfig:
    return AgentConfig(
        machine=config.machine,
        control="",
        secret="",
        run_dir="",
        cloud=cloud,
        store=config.store,
        map_store=config.map_store,
        outbox=config.outbox,
        reserve=config.reserve,
        recordings=config.recordings,
        cores=config.cores,
        peering=far.peering if far is not None else None,
        runtime=config.runtime,
        image=config.image,
        allowed=config.allowed,
        adopt_within=config.adopt_within,
    )


def _watcher(config: CloudConfig, far: "RemoteMachines | None") -> WatcherProcess:
    if far is None:
        raise InvalidInput(
            "a Ray cluster needs --listen-machines HOST:PORT, the address at which its nodes reach the cloud"
        )
    watched = WatchConfig(config.ray_address or "", config.machines, far.host, config.cores, config.ray_endpoints)
    return WatcherProcess(watched)


class Engine(CloudListener):
    """The engine of one cloud, with this machine in it.

    Parameters
    ----------
    config : CloudConfig
        Its configuration.
    leadership : Leadership, optional
        Leadership of this process; without one it leads alone, as in tests.
    """

    def __init__(self, config: CloudConfig, leadership: Leadership | None = None) -> None:
        balancer = BALANCERS.create(config.balancer, {})
        monitor_parameters({"priorities": config.node_priorities} if config.node_priorities else {})
        self.config = config
        self._own, self._listens = config.machine, asyncio.Event()
        self._background, self._watching = Background(), Background()
        hosts = DeviceHosts(config.device_hosts)
        runtimes.RUNTIMES.load(config.runtime)  # raises here if unknown; otherwise the agent would fail
        self.keep_versions = config.keep_versions
        self._open_stores(config)
        instance = instance_name()
        self._far = _far_machines(config, instance) if config.listen_machines is not None else None
        watcher = _watcher(config, self._far) if config.ray_address is not None else None
        self._roll = MachineRegistry(Path(config.left) / MACHINES_HERE) if config.left is not None else None
        # Only after the configuration was checked, so that a refused one leaves nothing behind.
        file = Path(config.left) / OWN_AGENT if config.left is not None and watcher is None else None
        left = read_record(file) if file is not None else None
        own = settle_config(_agent_config(config, instance, self._far), left)
        self.run_dir = Path(own.run_dir)
        self._agents: Agents = self._on_ray(watcher) if watcher is not None else LocalMachine(own, file, left)
        quotas = Quotas(config.quota)
        self.service = MasterDriver(
            Master(balancer, quotas, id_suffix=f"-{secrets.token_hex(4)}"),
            CheckpointSelection(self.store, instance, config.linger),
            self.run_dir,
            own.secret,
            self,
        )
        self._former = self._let_lead(leadership) if leadership is not None else ""
        if config.machine_settings is not None:
            self.service.administration.keep_in(Path(config.machine_settings))
        self.sessions = RobotSessions(
            self.service, self.store, self.map_store, config.linger, node_priorities=config.node_priorities
        )
        self.cloud, self.secret = Cloud(self.service, quotas, self.store, self.sessions), own.secret
        self.endpoints = EndpointServer(self.run_dir / SOCKET, own.secret, self.cloud, self.sessions)
        self.journeys = JourneyLeader(
            self.service, self.sessions, self.store, self.map_store, self.cloud.planning, hosts=hosts
        )
        self.endpoints.serve_also(lambda: Extra(JourneyCalls, self.journeys))

    def _open_stores(self, config: CloudConfig) -> None:
        outbox, reserve = (Path(path) if path else None for path in (config.outbox, config.reserve))
        self.recordings = None if config.recordings is None else RecordingsFolder(Path(config.recordings))
        self.reserve = DiskReserve(reserve) if reserve is not None else None
        if self.reserve is not None:
            self.reserve.keep()
        self.store: Store = open_store(config.store, outbox=outbox, reserve=reserve)
        self.map_store: MapStore = open_map_store(config.map_store, reserve=reserve)

    def task_runner(self, kept_for: float) -> TaskRunner:
        """Return what leads the tasks of the cloud, which are kept for a time after their end [s]."""
        return self.cloud.task_runner(self.store, self.map_store, kept_for, self.journeys)

    def _let_lead(self, leadership: Leadership) -> str:
        """Give orders only while this process leads; return the process that it replaced, if there was one."""
        control, _ = self.service.servers
        control.mandate, leadership.renewed = leadership, control.resume
        return leadership.former

    def _on_ray(self, watcher: WatcherProcess) -> RayMachines:
        peering = self._far.peering if self._far is not None else None
        return RayMachines(watcher, RouterProcess(self.run_dir, peering=peering))

    def machine_frozen(self, machine: str) -> None:
        """Kill its agent, if this process manages it."""
        self._agents.kill(machine)

    def machine_removed(self, machine: str) -> None:
        """Stop the local agent if its machine was removed; otherwise it would be restarted."""
        if machine == self._own:
            self._background.run(self._agents.stop())

    def machines_changed(self, machines: Collection[str]) -> None:
        """Store the names of the machines for the next cloud process."""
        if self._roll is not None:
            self._roll.note(machines)

    def place_opened(self, key: str) -> None:
        """Give its robot the nodes of its groups: a people coordinator, a traffic node."""
        self.cloud.place_opened(key)

    def place_adopted(self, key: str) -> None:
        """Keep the place until its robot reconnects, for the time of ``linger``; nodes of groups follow robots."""
        self.cloud.place_opened(key)
        if not self.service.serves_group(key):
            self.sessions.await_back(key)

    async def start(self) -> None:
        """Start, and wait until the local machine has joined; in place of another process, wait for none.

        The robots of that process come back now, and wait for their machines.

        Raises
        ------
        Unavailable
            The local machine did not join.
        """
        if self._agents.expected_at_start and not (self._former or self._agents.was_adopted):
            self.service.of_machines.await_machine(self._own)  # one that an earlier process left can start containers
        await self.service.administration.admit(self._own)  # starting the cloud starts its agent again
        self._watching.run(log_start(self.service.start_state))
        await self.service.start()
        await self.endpoints.start()
        self._listens.set()
        if self._roll is not None:
            self.service.of_machines.expect_back(self._expected())
        if self._far is not None:
            await self._far.start(*self.service.servers, self.endpoints.connected)
        await self._agents.start()
        if self._agents.expected_at_start and not self._former:
            await self._wait_for_own()

    async def listening(self) -> None:
        """Wait until endpoints may register."""
        await self._listens.wait()

    def _expected(self) -> list[str]:
        """Return the machines that may run clones of an earlier cloud process.

        The own machine of another host's process never returns here, and its clones act until its lease ends.
        """
        left = self._roll.left() if self._roll is not None else []
        if not self._former:
            return left
        return [*(machine for machine in left if machine != self._own), f"{self._own} of {self._former}"]

    async def _wait_for_own(self) -> None:
        if self._agents.was_adopted:
            try:
                await self.service.wait_for_machine(RETURN_TIMEOUT)
            except Unavailable:
                self._agents.kill(self._own)  # the adopted agent is frozen; another one is started
        until = asyncio.get_running_loop().time() + MACHINE_TIMEOUT
        while self._agents.deaths < HOPELESS and asyncio.get_running_loop().time() < until:
            with contextlib.suppress(Unavailable):
                return await self.service.wait_for_machine(LOOK)
        raise Unavailable(
            f"no machine registered; its agent exited {self._agents.deaths} times: see the log of the agent"
        )

    async def end_own_machine(self) -> None:
        """End the machine of this host with its containers; their robots continue on others."""
        await self._agents.stop()

    async def close(self) -> None:
        """End everything that was started, also after a failed start; errors do not keep the rest from ending."""
        async with contextlib.AsyncExitStack() as last_first:
            last_first.push_async_callback(asyncio.to_thread, sweep_stale)  # leftovers of killed agents
            last_first.push_async_callback(asyncio.to_thread, shutil.rmtree, self.run_dir, ignore_errors=True)
            if self.reserve is not None:
                last_first.callback(self.reserve.release)
            last_first.callback(self.store.close)
            last_first.push_async_callback(self.cloud.robot_stops.close)
            last_first.push_async_callback(self._agents.stop)
            last_first.push_async_callback(self._watching.cancel)
            last_first.push_async_callback(self._background.join)
            last_first.push_async_callback(self.service.close)
            last_first.push_async_callback(self.endpoints.close)
            if self._far is not None:
                last_first.push_async_callback(self._far.close)
            last_first.push_async_callback(self.sessions.close)
            last_first.callback(self.cloud.close)
