"""The local node manager: runs on the robot what the node monitor of the cloud wants there.

::

    async with RobotClient(url, robot="tb1", token=token) as client:
        manager = LocalNodes(client, this_computer())
        running = asyncio.create_task(manager.run())
        home = await manager.ask("move_base")

The nodes are of the same classes as in the cloud, in one process beside this one. What the robot senses reaches them
without the cloud; what else they hear, and all that they say, goes over the client's one WebSocket.
"""

import asyncio
import logging
from collections.abc import Collection, Sequence

import msgspec

from ppaas.clock import Clock, monotonic
from ppaas.errors import PPaaSError, Unavailable
from ppaas.messages import encode, ppaas_msgs
from ppaas.messages.message import Empty
from ppaas.messages.nav_msgs import GetMap, GetMapResponse, OccupancyGrid
from ppaas.nodes.map_server.node import KEEPOUT_MASK, MAP_SERVICE, SPEED_MASK
from robots.client.robot_client import RobotClient
from robots.onboard.computer import Computer
from robots.onboard.executor import protocol
from robots.onboard.node_monitor_client import Known, NodeMonitorClient
from robots.onboard.node_process import NodeProcess
from robots.onboard.node_services import NodeServices
from robots.onboard.topic_bridge import Crossing

logger = logging.getLogger(__name__)

NODES = ("amcl", "move_base", "waypoint_follower", "depthimage_to_laserscan")
"""Those of a clone that may live on a robot; the last one is in that of a robot with a depth camera."""

LEAVE_TIMEOUT = 3.0

HOLD_PERIOD = 0.5
"""Seconds between two words to the cloud about what runs here."""


class LocalNodes:
    """Runs nodes of one robot.

    Parameters
    ----------
    client : RobotClient
        Of the robot, open.
    computer : Computer
        What it has to run them on.
    nodes : sequence of str
        Those that it can run.
    sensors : collection of str
        Topics that the client publishes, which local nodes hear from there. Images, for which only a node here has a
        use, do not go to the cloud.
    clock : callable
        Monotonic seconds.
    """

    def __init__(
        self,
        client: RobotClient,
        computer: Computer,
        *,
        nodes: Sequence[str] = NODES,
        sensors: Collection[str] = ("scan", "odom"),
        clock: Clock = monotonic,
    ) -> None:
        self._client = client
        self._monitor = NodeMonitorClient(client, computer, nodes, clock)
        self._changed = asyncio.Event()
        self._process: NodeProcess | None = None
        self._crossing = Crossing(client, sensors)
        self._services = NodeServices(client)
        self._config: protocol.CloneConfig | None = None
        self._wanted: dict[str, str] = {}
        self._leases: dict[str, int] = {}
        self._states: dict[str, Known] = {}
        self._lost: dict[str, tuple[int, str]] = {}
        self._settled = set[str]()
        self._session = 0
        self.ready = asyncio.Event()

    @property
    def running(self) -> frozenset[str]:
        """Names of the nodes that run here, and have heard what came for them while they moved."""
        return frozenset(self._leases.keys() & self._settled)

    @property
    def pid(self) -> int | None:
        """Of the process that they run in; None where none does."""
        return self._process.pid if self._process is not None else None

    # -- what the user asks --------------------------------------------------------------------------------------------

    async def ask(self, node: str, home: str = "") -> ppaas_msgs.NodeHome:
        """Have a node run where the node monitor finds best, or where it is asked for; return what it says.

        Raises
        ------
        NotFound
            No such node.
        InvalidParameter
            No such home.
        """
        return await self._monitor.run_node(node, home)

    async def run(self) -> None:
        """Run what is wanted here, until cancelled; then all goes on in the cloud.

        Raises
        ------
        PPaaSError
            The cloud has no node monitor for this robot, or the client has given up.
        """
        self._session = self._session_now()
        self._config = await self._monitor.tell_robot()
        await self._client.subscribe("node_monitor/homes", ppaas_msgs.NodeHomes, self._homes_told)
        self._client.attach(self._crossing)
        pumping = asyncio.create_task(self._crossing.run())
        self.ready.set()
        try:
            while True:
                self._changed.clear()
                await self._see_to_nodes()
                await self._wait()
        finally:
            await self._leave()
            pumping.cancel()
            self._client.attach(None)

    async def _leave(self) -> None:
        """Give all back, if the cloud can be told; else it notices by itself."""
        try:
            async with asyncio.timeout(LEAVE_TIMEOUT):
                for node in tuple(self._leases):
                    await self._give_back(node)
        except (PPaaSError, TimeoutError) as error:
            logger.info("the cloud goes on from what it was told last: %s", error)
        finally:
            await self._end_process()

    async def _wait(self) -> None:
        try:
            async with asyncio.timeout(HOLD_PERIOD):
                await self._changed.wait()
        except TimeoutError:
            return

    async def _see_to_session(self) -> None:
        """Tell a session that is new what the one before was told, and go on with what runs here.

        Its node monitor may be another; or the same, which took the silence of a killed cloud process for ours.
        """
        session = self._session_now()
        if session == self._session:
            return
        self._config = await self._monitor.tell_robot()
        for there in await self._monitor.list_nodes():
            if there.home == "cloud" and there.node in self._leases:
                self._wanted[there.node] = (await self.ask(there.node, "robot")).wanted
        self._session = session

    def _session_now(self) -> int:
        return self._client.connections - self._client.resumptions

    def _homes_told(self, homes: ppaas_msgs.NodeHomes) -> None:
        self._wanted = {node.node: node.wanted for node in homes.nodes}
        self._changed.set()

    # -- what is wanted here -------------------------------------------------------------------------------------------

    async def _see_to_nodes(self) -> None:
        try:
            await self._see_to_session()
            if self._lost:
                await self._give_up()
            if self._process is not None and not self._process.alive:
                await self._lose("the process of local nodes has ended")
            for node, wanted in tuple(self._wanted.items()):
                if wanted == "robot" and node not in self._leases:
                    await self._take(node)
                elif wanted == "cloud" and node in self._leases:
                    await self._give_back(node)
            if self._leases:
                await self._hold()
        except Unavailable as error:  # the link is down, or a container is replaced: the next look comes soon
            logger.info("the cloud cannot be told of local nodes now: %s", error)

    async def _take(self, node: str) -> None:
        """Take a node over: get ready first, so that it is away from the cloud for no longer than it takes to move."""
        try:
            process = await self._started()
        except PPaaSError as error:
            await self._monitor.give_node(node, 0, failure=str(error))
            self._wanted[node] = "cloud"
            return
        taken = await self._monitor.take_node(node)
        self._leases[node], self._states[node] = taken.lease, Known(taken.state, [])
        self._settled.discard(node)
        self._crossing.expect(node)
        try:
            added = await process.ask(protocol.Add(node, taken.state), protocol.Added)
        except PPaaSError as error:
            await self._lose(str(error))
            return
        await self._crossing.open(added, process)
        await self._services.open(added, process)
        logger.info("%s runs here", node)

    async def _started(self) -> NodeProcess:
        if self._process is not None and self._process.alive:
            return self._process
        begin = await self._begin()
        process = NodeProcess(self._crossing.said, self._changed.set)
        try:
            await process.start(begin)
        except BaseException:
            await process.stop()
            raise
        self._process = process
        return process

    async def _begin(self) -> protocol.Begin:
        assert self._config is not None
        grid, keepout, speed = [await self._grid(service) for service in (MAP_SERVICE, KEEPOUT_MASK, SPEED_MASK)]
        there = {name: mask for name, mask in ((KEEPOUT_MASK, keepout), (SPEED_MASK, speed)) if mask.info.width}
        masks = {name: msgspec.Raw(encode(mask)) for name, mask in there.items()}
        return protocol.Begin(self._config, msgspec.Raw(encode(grid)), masks)

    async def _grid(self, service: str) -> OccupancyGrid:
        answer = await self._client.call(service, GetMap, Empty(), timeout=60.0)
        assert isinstance(answer, GetMapResponse)
        return answer.map

    async def _give_back(self, node: str) -> None:
        process, lease, heard = self._process, self._leases[node], self._crossing.heard(node)
        await self._services.close(node)
        if process is not None:
            try:
                state = (await process.ask(protocol.Remove(node), protocol.Removed)).state
            except PPaaSError as error:
                await self._lose(str(error))
                return
            self._states[node] = Known(state, heard)
        await self._forget(node)
        await self._monitor.give_node(node, lease, self._states.pop(node))

    async def _forget(self, node: str) -> None:
        self._leases.pop(node, None)
        await self._crossing.close(node)
        await self._services.close(node)
        if not self._leases:
            await self._end_process()

    async def _hold(self) -> None:
        """Say what still runs here, and how it is; what the cloud has given up meanwhile ends."""
        process = self._process
        assert process is not None
        heard = {node: self._crossing.heard(node) for node in self._leases}  # before it is asked: it is in its states
        try:
            states = (await process.ask(protocol.AskStates(), protocol.States)).nodes
        except PPaaSError as error:
            await self._lose(str(error))
            return
        for node, lease in tuple(self._leases.items()):
            told = states.get(node, protocol.NodeState(self._states[node].state))
            self._states[node] = Known(told.state, heard[node])
            answer = await self._monitor.hold_node(node, lease, told, heard[node])
            if answer.lease == lease:
                self._crossing.tell_unheard(node, answer.unheard, process)
                self._settled.add(node)
            elif self._session_now() != self._session:
                return  # it was asked for in another session, which was lost with the cloud: the new one is told first
            else:
                logger.warning("%s goes on in the cloud, which heard nothing of it for too long", node)
                await process.ask(protocol.Remove(node), protocol.Removed)
                await self._forget(node)

    async def _lose(self, failure: str) -> None:
        """Let the cloud go on with all that ran here, from what was last known of it."""
        logger.warning("local nodes go on in the cloud: %s", failure)
        lost, self._leases = self._leases, {}
        await self._end_process()
        for node in lost:
            self._wanted[node] = "cloud"
            await self._crossing.close(node)
            await self._services.close(node)
        self._lost |= {node: (lease, failure) for node, lease in lost.items()}
        await self._give_up()

    async def _give_up(self) -> None:
        """Tell the cloud what is lost here, until it has heard it."""
        for node, (lease, failure) in tuple(self._lost.items()):
            await self._monitor.give_node(node, lease, self._states.get(node), failure)
            del self._lost[node]

    async def _end_process(self) -> None:
        process, self._process = self._process, None
        if process is not None:
            await process.stop()
