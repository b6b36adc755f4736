"""The composition root: here, and only here, the engine is put together."""

import asyncio
import contextlib
import itertools
import logging
import secrets
import shutil
from collections.abc import Callable, Collection
from dataclasses import dataclass, field
from pathlib import Path

from engine.agent.config import AgentConfig
from engine.agent.master_redial import ADOPT_WITHIN
from engine.container.monitor.parameters import monitor_parameters
from engine.fabric.router import RouterProcess
from engine.local.agent_record import read_record
from engine.local.machine import Agents, LocalMachine, settle_config
from engine.master.balancers.registry import BALANCERS, DEFAULT
from engine.master.master import Master
from engine.master.quotas import Quota, Quotas
from engine.processes.background import Background
from engine.processes.instances import instance_name, sweep_stale
from engine.protocols.address import parse_host_port
from engine.remote.cluster_settings import ContainerSettings
from engine.remote.machines import RemoteMachines
from engine.remote.ray.config import WatchConfig
from engine.remote.ray.machines import RayMachines
from engine.remote.ray.watcher_process import WatcherProcess
from engine.runtimes import registry as runtimes
from engine.service.cloud import Cloud
from engine.service.listener import CloudListener
from engine.service.machine_events import RETURN_TIMEOUT
from engine.service.machine_registry import Roll
from engine.service.master_driver import CloudService
from engine.service.robot_sessions import LINGER, RobotSessions
from engine.specs.checkpoints import CheckpointSelection
from ppaas.errors import InvalidInput, Unavailable
from storage.ports import MapStore, Store
from storage.urls.opening import open_map_store, open_store

logger = logging.getLogger(__name__)

USUAL_START = 3.0
STILL_STARTING = "still starting: the first start on a computer compiles the kernels, half a minute, on a slow one two"

OWN_AGENT, MACHINES_HERE = "own-agent.json", "machines-here.json"
"""Files in the folder for what a killed cloud process leaves to the next."""

MACHINE_TIMEOUT, LOOK = 600.0, 1.0
"""Seconds for the first start on a computer, which compiles the kernels, where every later one takes a second or two;
and after which it is asked anew whether there is hope."""

HOPELESS = 3
"""Deaths of an agent by which it is waited for no longer."""


@dataclass(frozen=True, slots=True)
class CloudConfig:
    """What the cloud is made of.

    Parameters
    ----------
    store, map_store : str
        URLs of the stores.
    listen_machines : str, optional
        Where machines of other hosts arrive, ``host:port``; the next port is taken as well.
    machines : str
        Folder for what tells those machines from others.
    outbox : str, optional
        File in which plans wait while a store that is not on this machine is away.
    machine : str
        Name of this machine.
    cores : int, optional
        CPUs that containers may use here; without it, all.
    quota : Quota
        Of each user who has no limits of the user's own.
    linger : float
        Seconds that a clone waits for its robot to come back.
    machine_settings : str, optional
        File for what administrators say of machines; without it, that ends with the cloud.
    left : str, optional
        Folder for what a cloud process that is killed leaves to the next; without it, that is nothing.
    adopt_within : float
        Seconds for which containers outlive a cloud process that is killed.
    balancer : str
        Chooses machines for containers.
    runtime : str
        Starts the containers of this machine.
    image : str
        Image that they run from, for a runtime that has images.
    node_priorities : tuple of str
        What node monitors go by, where a robot's file says nothing else; empty for their own order.
    allowed : tuple of str
        Other people's plug-ins that may run in the cloud, each as ``group:name`` of its entry point.
    ray_address : str, optional
        ``host:port`` of a Ray cluster, or ``auto``: its nodes are the machines then, in place of this one.
    """

    store: str
    map_store: str
    listen_machines: str | None = None
    machines: str = "machines"
    outbox: str | None = None
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
    ray_address: str | None = None


def _far_machines(config: CloudConfig, cloud: str) -> RemoteMachines:
    return RemoteMachines(
        Path(config.machines),
        parse_host_port(config.listen_machines or ""),
        cloud=cloud,
        store=config.store,
        map_store=config.map_store,
        own=config.machine,
        runs=ContainerSettings(config.runtime, config.image, config.allowed, config.adopt_within),
    )


def _agent_config(config: CloudConfig, cloud: str, far: RemoteMachines | None) -> AgentConfig:
    """Return what the agent of this machine is told, beside where the master is."""
    return AgentConfig(
        machine=config.machine,
        control="",
        secret="",
        run_dir="",
        cloud=cloud,
        store=config.store,
        map_store=config.map_store,
        outbox=config.outbox,
        cores=config.cores,
        peering=far.peering if far is not None else None,
        runtime=config.runtime,
        image=config.image,
        allowed=config.allowed,
        adopt_within=config.adopt_within,
    )


def _watcher(config: CloudConfig, far: RemoteMachines | None) -> WatcherProcess:
    if far is None:
        raise InvalidInput("the nodes of a Ray cluster reach the cloud by --listen-machines HOST:PORT")
    return WatcherProcess(WatchConfig(config.ray_address or "", config.machines, far.host, config.cores))


def _new_ids() -> Callable[[], str]:
    """Return what names containers: no other cloud process, the one before this included, gives such a name."""
    numbers, ours = itertools.count(1), secrets.token_hex(4)
    return lambda: f"c{next(numbers)}-{ours}"


class Engine(CloudListener):
    """The engine of one cloud, with this machine in it.

    Parameters
    ----------
    config : CloudConfig
        What it is made of.
    """

    def __init__(self, config: CloudConfig) -> None:
        balancer = BALANCERS.create(config.balancer, {})
        monitor_parameters({"priorities": config.node_priorities} if config.node_priorities else {})
        self._own = config.machine
        self._background = Background()
        runtimes.RUNTIMES.load(config.runtime)  # one that is unknown is told here, not by a machine that never comes
        self.store: Store = open_store(config.store, outbox=Path(config.outbox) if config.outbox else None)
        self.map_store: MapStore = open_map_store(config.map_store)
        instance = instance_name()
        self._far = _far_machines(config, instance) if config.listen_machines is not None else None
        watcher = _watcher(config, self._far) if config.ray_address is not None else None
        self._roll = Roll(Path(config.left) / MACHINES_HERE) if config.left is not None else None
        # After what may be refused, so that nothing is left behind.
        file = Path(config.left) / OWN_AGENT if config.left is not None and watcher is None else None
        left = read_record(file) if file is not None else None
        own = settle_config(_agent_config(config, instance, self._far), left)
        self._run_dir = Path(own.run_dir)
        self._agents: Agents = self._on_ray(watcher) if watcher is not None else LocalMachine(own, file, left)
        quotas = Quotas(config.quota)
        self.service = CloudService(
            Master(balancer, quotas, new_id=_new_ids()),
            CheckpointSelection(self.store, instance, config.linger),
            self._run_dir,
            own.secret,
            self,
        )
        if config.machine_settings is not None:
            self.service.administration.keep_in(Path(config.machine_settings))
        self.service.administration.admit(config.machine)  # its agent is started with us
        self.sessions = RobotSessions(
            self.service, self.store, self.map_store, config.linger, node_priorities=config.node_priorities
        )
        self.cloud = Cloud(self.service, quotas)

    def _on_ray(self, watcher: WatcherProcess) -> RayMachines:
        """Return what keeps the agents of the nodes of a Ray cluster."""
        peering = self._far.peering if self._far is not None else None
        return RayMachines(watcher, RouterProcess(self._run_dir, peering=peering))

    def machine_frozen(self, machine: str) -> None:
        """End its agent, if we can."""
        self._agents.kill(machine)

    def machine_removed(self, machine: str) -> None:
        """End its agent, if it is ours: else it would be started again."""
        if machine == self._own:
            self._background.run(self._agents.stop())

    def machines_changed(self, machines: Collection[str]) -> None:
        """Note which machines there are, for a cloud process after this one."""
        if self._roll is not None:
            self._roll.note(machines)

    def place_adopted(self, key: str) -> None:
        """Await the robot whose clone it is."""
        self.sessions.await_back(key)

    async def start(self) -> None:
        """Start, and wait until this machine is in.

        Raises
        ------
        Unavailable
            The machine did not come up.
        """
        patience = asyncio.get_running_loop().call_later(USUAL_START, logger.info, STILL_STARTING)
        try:
            await self.service.start()
            if self._roll is not None:
                self.service.of_machines.expect_back(self._roll.left())
            if self._far is not None:
                await self._far.start(*self.service.servers)
            await self._agents.start()
            if self._agents.expected_at_start:
                await self._wait_for_own()
        finally:
            patience.cancel()

    async def _wait_for_own(self) -> None:
        if self._agents.was_adopted:
            try:
                await self.service.wait_for_machine(RETURN_TIMEOUT)
            except Unavailable:
                self._agents.kill(self._own)  # it is frozen, and another is started
        until = asyncio.get_running_loop().time() + MACHINE_TIMEOUT
        while self._agents.deaths < HOPELESS and asyncio.get_running_loop().time() < until:
            with contextlib.suppress(Unavailable):
                return await self.service.wait_for_machine(LOOK)
        raise Unavailable(f"no machine registered and its agent ended {self._agents.deaths} times; see what it logged")

    async def close(self) -> None:
        """End everything that was started, be it only half; what fails at it does not keep the rest from ending."""
        async with contextlib.AsyncExitStack() as last_first:
            last_first.push_async_callback(asyncio.to_thread, sweep_stale)  # of agents that were killed
            last_first.push_async_callback(asyncio.to_thread, shutil.rmtree, self._run_dir, ignore_errors=True)
            last_first.callback(self.store.close)
            last_first.push_async_callback(self._agents.stop)
            last_first.push_async_callback(self._background.join)
            last_first.push_async_callback(self.service.close)
            if self._far is not None:
                last_first.push_async_callback(self._far.close)
            last_first.push_async_callback(self.sessions.close)
            last_first.callback(self.cloud.close)
