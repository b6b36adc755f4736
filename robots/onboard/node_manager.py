"""Local node manager: runs those nodes on the robot that the clone's node monitor has placed there.

::

    async with RobotClient(url, robot="tb1", token=token) as client:
        manager = LocalNodes(client, this_computer())
        running = asyncio.create_task(manager.run())
        home = await manager.ask("move_base")

The nodes are the same classes as in the cloud and run in a child process. Sensor messages reach them directly; all
other topics go through the client's WebSocket.
"""

import asyncio
import logging
from collections.abc import Collection, Sequence

import msgspec

from ppaas.clock import Clock, monotonic
from ppaas.errors import PPaaSError, Unavailable
from ppaas.messages import encode, ppaas_msgs
from ppaas.messages.base.message import Empty
from ppaas.messages.fleet.traffic import GetZones, ZonesOfMap
from ppaas.messages.nav_msgs import GetMap, GetMapResponse, OccupancyGrid
from ppaas.nodes import topics
from ppaas.nodes.map_server.node import KEEPOUT_MASK, MAP_SERVICE, SPEED_MASK, ZONES
from robots.client.robot_client import RobotClient
from robots.onboard.computer import Computer
from robots.onboard.executor import protocol
from robots.onboard.node_bridge import NodeServices, TopicBridge
from robots.onboard.node_leases import NodeLease, NodeLeases, log_change
from robots.onboard.node_monitor_client import NodeMonitorClient, NodeSnapshot
from robots.onboard.node_process import NodeProcess
from robots.onboard.stop_latch import OnboardLatch

logger = logging.getLogger(__name__)

NODES = (
    "amcl", "grid_slam", "move_base", "waypoint_follower", "depthimage_to_laserscan", "laser_proc", "torso_detector",
    "leg_detector", "people_tracker", "follow_person",
)  # fmt: skip
"""Nodes of a clone that may run on a robot. A clone has one of the first two, and those for depth cameras and people if
the robot has parameters for them."""

SENSORS = (
    topics.SCAN.name, topics.ECHOES.name, topics.ODOM.name, topics.DEPTH_IMAGE.name, topics.COMPRESSED_DEPTH_IMAGE.name,
    topics.DEPTH_CAMERA_INFO.name, topics.CLOUD_IN.name,
)  # fmt: skip
"""Topics of sensors, which the robot's client publishes and local nodes receive directly."""

LEAVE_TIMEOUT = 3.0
"""Time limit for handing all nodes back when the manager stops [s]."""

HOLD_PERIOD = 0.5
"""Period of the lease renewals [s]."""


class LocalNodes:
    """Local node manager of one robot.

    Parameters
    ----------
    client : RobotClient
        Connected client of the robot.
    computer : Computer
        The robot's computer.
    nodes : sequence of str
        Nodes that this computer can run.
    sensors : collection of str
        Topics that the client publishes and local nodes receive directly. Those that only a local node uses, as
        images, are not sent to the cloud.
    clock : callable
        Monotonic seconds.
    """

    def __init__(
        self,
        client: RobotClient,
        computer: Computer,
        *,
        nodes: Sequence[str] = NODES,
        sensors: Collection[str] = SENSORS,
        clock: Clock = monotonic,
    ) -> None:
        self._client = client
        self._monitor = NodeMonitorClient(client, computer, nodes, clock)
        self._changed = asyncio.Event()
        self._process: NodeProcess | None = None
        self._latch = OnboardLatch(client)
        self._bridge = TopicBridge(client, sensors, self._latch)
        self._services = NodeServices(client)
        self._config: protocol.CloneConfig | None = None
        self._wanted: dict[str, str] = {}
        self._leases = NodeLeases(self._monitor)
        self._connection = 0
        self.ready = asyncio.Event()

    @property
    def running(self) -> frozenset[str]:
        """Names of the nodes that run here and have received the messages that arrived during their move."""
        return self._leases.synchronized()

    @property
    def pid(self) -> int | None:
        """Process id of the executor; None while no node runs here."""
        return self._process.pid if self._process is not None else None

    # -- public methods ------------------------------------------------------------------------------------------------

    async def ask(self, node: str, home: str = "") -> ppaas_msgs.NodeHome:
        """Request a home for a node, empty for the best; return the node monitor's decision.

        Raises
        ------
        NotFound
            The clone has no such node.
        InvalidParameter
            There is no such home.
        """
        return await self._monitor.run_node(node, home)

    async def run(self) -> None:
        """Run the nodes that are placed here until cancelled; they then continue in the cloud.

        Raises
        ------
        PPaaSError
            The robot's clone has no node monitor, or the client has failed.
        """
        self._connection = self._client.connections
        self._config = await self._monitor.tell_robot()
        await self._client.subscribe("node_monitor/homes", ppaas_msgs.NodeHomes, self._on_homes)
        await self._latch.open()
        self._client.attach(self._bridge)
        forwarding = asyncio.create_task(self._bridge.run())
        self.ready.set()
        try:
            while True:
                self._changed.clear()
                await self._update()
                await self._wait()
        finally:
            await self._leave()
            forwarding.cancel()
            await self._latch.close()
            self._client.attach(None)

    async def _leave(self) -> None:
        """Hand all nodes back; if the cloud is unreachable, it notices by their expired leases."""
        try:
            async with asyncio.timeout(LEAVE_TIMEOUT):
                for node in self._leases.nodes():
                    await self._give_back(node)
        except (PPaaSError, TimeoutError) as error:
            logger.info("nodes could not be handed back; the cloud continues from their last states: %s", error)
        finally:
            await self._end_process()

    async def _wait(self) -> None:
        try:
            async with asyncio.timeout(HOLD_PERIOD):
                await self._changed.wait()
        except TimeoutError:
            return

    async def _check_connection(self) -> None:
        """Register again if the connection is new, and keep the nodes that run here.

        The clone may have another node monitor, or the same one, which lost contact because an endpoint was killed.
        """
        connection = self._client.connections
        if connection == self._connection:
            return
        self._config = await self._monitor.tell_robot()
        for known in await self._monitor.list_nodes():
            if known.home == "cloud" and known.node in self._leases:
                self._wanted[known.node] = (await self.ask(known.node, "robot")).wanted
        self._connection = connection

    def _on_homes(self, homes: ppaas_msgs.NodeHomes) -> None:
        self._wanted = {node.node: node.wanted for node in homes.nodes}
        self._changed.set()

    # -- moving nodes --------------------------------------------------------------------------------------------------

    async def _update(self) -> None:
        try:
            await self._check_connection()
            await self._leases.report_lost()
            if self._process is not None and not self._process.alive:
                await self._fail_all("the process of the local nodes has exited")
            for node, wanted in tuple(self._wanted.items()):
                if wanted == "robot" and node not in self._leases:
                    await self._take(node)
                elif wanted == "cloud" and node in self._leases:
                    await self._give_back(node)
            if self._leases.nodes():
                await self._hold()
        except Unavailable as error:  # the link is down, or the container is being replaced: retried soon
            logger.info("cannot reach the node monitor: %s", error)

    async def _take(self, node: str) -> None:
        """Take a node over. The executor starts first, so the node pauses only for the move itself."""
        try:
            process = await self._started()
        except PPaaSError as error:
            await self._leases.refuse(node, str(error))
            self._wanted[node] = "cloud"
            return
        taken = await self._leases.take(node)
        self._bridge.expect(node)
        log = [(part.number, part.data) for part in taken.log]
        try:
            added = await process.ask(protocol.Add(node, taken.state, log), protocol.Added)
        except PPaaSError as error:
            await self._fail_all(str(error))
            return
        await self._bridge.open(added, process)
        await self._services.open(added, process)
        logger.info("%s now runs on the robot", node)

    async def _started(self) -> NodeProcess:
        if self._process is not None and self._process.alive:
            return self._process
        begin = await self._begin()
        process = NodeProcess(self._bridge.on_message, self._changed.set)
        try:
            await process.start(begin)
        except BaseException:
            await process.stop()
            raise
        self._process = process
        return process

    async def _begin(self) -> protocol.Begin:
        assert self._config is not None
        if self._config.new_map:
            return protocol.Begin(self._config)  # the map comes on its topics
        grid, keepout, speed = [await self._grid(service) for service in (MAP_SERVICE, KEEPOUT_MASK, SPEED_MASK)]
        loaded = {name: mask for name, mask in ((KEEPOUT_MASK, keepout), (SPEED_MASK, speed)) if mask.info.width}
        masks = {name: msgspec.Raw(encode(mask)) for name, mask in loaded.items()}
        zones = await self._client.call(ZONES, GetZones, Empty(), timeout=60.0)
        assert isinstance(zones, ZonesOfMap)
        return protocol.Begin(self._config, msgspec.Raw(encode(grid)), masks, zones.geojson)

    async def _grid(self, service: str) -> OccupancyGrid:
        answer = await self._client.call(service, GetMap, Empty(), timeout=60.0)
        assert isinstance(answer, GetMapResponse)
        return answer.map

    async def _give_back(self, node: str) -> None:
        process, heard = self._process, self._bridge.heard(node)
        await self._services.close(node)
        if process is not None:
            try:
                removed = await process.ask(protocol.Remove(node), protocol.Removed)
            except PPaaSError as error:
                await self._fail_all(str(error))
                return
            self._leases.note(node, NodeSnapshot(removed.state, heard, log_change(removed)))
        lease = await self._forget(node)
        await self._leases.give_back(node, lease)

    async def _forget(self, node: str) -> NodeLease:
        lease = self._leases.drop(node)
        await self._bridge.close(node)
        await self._services.close(node)
        if not self._leases.nodes():
            await self._end_process()
        return lease

    async def _hold(self) -> None:
        """Renew the leases with the nodes' states; stop the nodes that the cloud has taken back."""
        process = self._process
        assert process is not None
        # Read before the states, which then include these messages.
        heard = {node: self._bridge.heard(node) for node in self._leases.nodes()}
        try:
            states = self._leases.collect((await process.ask(protocol.AskStates(), protocol.States)).nodes)
        except PPaaSError as error:
            await self._fail_all(str(error))
            return
        for node in self._leases.nodes():
            missed = await self._leases.renew(node, states.get(node), heard[node])
            if missed is not None:
                self._bridge.deliver_missed(node, missed, process)
            elif self._client.connections != self._connection:
                return  # the answer is of a lost connection: register by the new one first
            else:
                logger.warning("%s continues in the cloud: its lease expired because renewals arrived too late", node)
                await process.ask(protocol.Remove(node), protocol.Removed)
                await self._forget(node)

    async def _fail_all(self, failure: str) -> None:
        """Hand all nodes to the cloud with their last known states, after a failure of the executor."""
        logger.warning("local nodes continue in the cloud: %s", failure)
        lost = self._leases.lose(failure)
        await self._end_process()
        for node in lost:
            self._wanted[node] = "cloud"
            await self._bridge.close(node)
            await self._services.close(node)
        await self._leases.report_lost()

    async def _end_process(self) -> None:
        process, self._process = self._process, None
        if process is not None:
            await process.stop()
