"""Bridge between a robot and its clone, over any transport."""

import asyncio
import contextlib
from collections import defaultdict
from collections.abc import Callable, Coroutine
from typing import Any

import msgspec

from ppaas.clock import epoch, monotonic
from ppaas.errors import NotFound, PPaaSError
from robots.bridges.core.actions import ActionServer, in_release
from robots.bridges.core.cloud_link import CloudLink
from robots.bridges.core.downward import Downward, VelocityPublishers
from robots.bridges.core.findings import ERROR, GraphExamination, GraphFault, examine
from robots.bridges.core.frames import Frames
from robots.bridges.core.localization import RobotLocalization
from robots.bridges.core.notices import Notices
from robots.bridges.core.parts import BridgeParts, RobotTime
from robots.bridges.core.robot_graph import TWIST, RobotGraph, find_namespace
from robots.bridges.core.tables import OTHER_PACKAGES, BridgedService
from robots.bridges.core.transport import Closable, Transport
from robots.bridges.core.upward import Upward

SETTLE = 0.05
"""Time for which changes of the graph are collected before the bridge follows them [s]."""


class Bridge:
    """Carries topics, services and actions between the graph of a robot and the cloud.

    Parameters
    ----------
    transport : Transport
        The robot.
    url, robot, token : str
        URL of the cloud, id of the robot, and token of its owner.
    namespace : str, optional
        Namespace of the robot's nodes; found in the graph by default.
    actions : callable
        Called with the name, the type and the name in the graph of an action, and with the ends of the bridge; offers
        the action to the robot's nodes.
    """

    def __init__(
        self,
        transport: Transport,
        *,
        url: str,
        robot: str,
        token: str,
        namespace: str | None = None,
        actions: Callable[[str, str, str, BridgeParts], Closable] = ActionServer,
    ) -> None:
        self._transport, self._robot, self._actions = transport, robot, actions
        self._namespace = None if namespace is None else f"/{namespace.strip('/')}".rstrip("/")
        self._link = CloudLink(url, robot=robot, token=token, renewed=self._renewed)
        self._changed = asyncio.Event()
        self._known: frozenset[str] = frozenset()
        self._tasks: set[asyncio.Task[None]] = set()
        self._servers: list[Closable] = []
        self._notices = Notices()
        time = RobotTime(monotonic, epoch)
        parts = BridgeParts(transport, self._link, Frames(), time, self._notices, monotonic, self._start)
        self._parts = parts
        self._localization = RobotLocalization(parts)
        self._upward, self._downward = Upward(parts, self._localization), Downward(parts)
        self._velocity = VelocityPublishers(parts)

    async def run(self) -> None:
        """Carry messages until cancelled.

        Raises
        ------
        PPaaSError
            The cloud refuses the robot, or the transport cannot be opened, and why.
        """
        await self._transport.open(self._changed.set)
        try:
            async with self._link:
                self._notices.info(f"robot {self._robot} is connected to the cloud")
                if self._transport.lacking:
                    self._notices.tell(self._transport.lacking)
                await self._link.subscribe("cmd_vel", TWIST, self._velocity.received)
                for topic in self._transport.tables.up:
                    if not topic.clone:
                        await self._link.advertise(topic.cloud, topic.type)
                following = asyncio.create_task(self._follow())
                examining = asyncio.create_task(GraphExamination(self._parts, self._findings).run())
                closed = asyncio.create_task(self._link.closed())
                ended = asyncio.create_task(self._transport.ended())
                lasting = (closed, ended, following, examining)
                self._tasks.update(lasting)
                await asyncio.wait(lasting, return_when=asyncio.FIRST_COMPLETED)
                for task in lasting:
                    if task.done():
                        task.result()
        finally:
            await self._stop()

    async def _stop(self) -> None:
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        self._velocity.close()
        self._upward.close()
        self._downward.close()
        for server in self._servers:
            server.close()
        await self._transport.close()

    def _start(self, work: Coroutine[Any, Any, None]) -> None:
        task = asyncio.create_task(self._guarded(work))
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def _guarded(self, work: Coroutine[Any, Any, None]) -> None:
        try:
            await work
        except PPaaSError as error:
            self._notices.warn(str(error))

    # -- the graph -----------------------------------------------------------------------------------------------------

    def _renewed(self) -> None:
        for told in (self._upward.renew(), self._localization.renew(), self._ask_topics()):
            self._start(told)

    async def _ask_topics(self) -> None:
        answer = msgspec.json.decode(await self._link.call("rosapi/topics", "rosapi_msgs/srv/Topics", b"{}"))
        self._known = frozenset(str(topic).lstrip("/") for topic in answer["topics"])
        self._changed.set()

    async def _follow(self) -> None:
        """Adapt to each change of the graph and of the clone."""
        while True:
            await self._changed.wait()
            await asyncio.sleep(SETTLE)
            self._changed.clear()
            self._update()

    def _update(self) -> None:
        entities = self._transport.entities()
        if self._namespace is None:
            with contextlib.suppress(NotFound):  # of several robots none has this name, as the examination says
                self._namespace = find_namespace(entities, self._robot)
            if self._namespace is None:
                return
            self._notices.info(f"the robot's namespace is {self._namespace or '/'}")
        graph = RobotGraph(entities, self._namespace)
        if self._known:
            self._upward.update(graph, self._known)
        self._downward.update(graph)
        self._velocity.update(graph.velocity_topics())
        for topic in self._velocity.topics:
            self._notices.info(f"velocities go to {topic}")
        if self._transport.services and not self._servers:
            self._serve(graph)

    async def _findings(self) -> list[GraphFault]:
        entities = self._transport.entities()
        faults = [GraphFault(subject, text, ERROR) for subject, text in self._transport.faults().items()]
        if self._namespace is not None:
            graph, transport = RobotGraph(entities, self._namespace), self._transport
            return faults + examine(graph, transport.types, transport.tables, qos_matters=transport.qos_matters)
        try:
            find_namespace(entities, self._robot)
        except NotFound as error:
            return [*faults, GraphFault("namespace", f"{error}; name one by --namespace", ERROR)]
        text = "no robot is found: nobody publishes nav_msgs/Odometry or sensor_msgs/LaserScan; "
        if domains := await self._transport.other_domains():
            names = ", ".join(map(str, domains))
            text += f"robots are in domain {names}, and the bridge in {self._transport.domain}: "
        return [*faults, GraphFault("robot", text + self._transport.not_found, ERROR)]

    # -- services and actions ------------------------------------------------------------------------------------------

    def _serve(self, graph: RobotGraph) -> None:
        """Offer what the release of the robot's ROS has, and report what its packages lack."""
        transport, lacking = self._transport, defaultdict[str, list[str]](list)
        for service in transport.tables.services:
            if transport.has_type(service.type):
                full = graph.full(service.name)
                self._servers.append(transport.serve(full, service.type, self._answer(service)))
            else:
                lacking[service.type.partition("/")[0]].append(service.name)
        for name, usual in transport.tables.actions.items():
            kind = usual if transport.types.knows(f"{usual}_SendGoal") else OTHER_PACKAGES.get(usual, usual)
            if not (transport.types.ros1 or transport.types.knows(f"{kind}_SendGoal")):
                continue  # actions of ROS 1 have no services
            if transport.has_type(kind):
                self._servers.append(self._actions(name, kind, graph.full(name), self._parts))
            else:
                lacking[kind.partition("/")[0]].append(name)
        for package, names in lacking.items():
            listed, are = ", ".join(map(repr, names)), "is" if len(names) == 1 else "are"
            self._notices.warn(f"{listed} {are} not offered: the robot's ROS has no package {package} with them")

    def _answer(self, service: BridgedService) -> Any:
        async def answer(request: bytes) -> bytes:
            types = self._transport.types
            text = types.decode_json(f"{service.type}_Request", request)
            response = await self._link.call(service.cloud, service.cloud_type, text)
            name = f"{service.type}_Response"
            return types.encode(name, in_release(types, name, msgspec.json.decode(response)))

        return answer
