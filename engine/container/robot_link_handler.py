"""The container's end of the robot link: takes frames into the graph, sends what the graph says, keeps checkpoints."""

import asyncio
import logging
import os
from collections import deque
from collections.abc import Callable, Iterable

from engine.container.endpoint_link import EndpointLink
from engine.container.executor import CloudHome
from engine.container.machine_client import MachineClient
from engine.container.monitor.setup import Monitoring
from engine.container.shared_plans import PlanningNotes
from engine.processes.heartbeats import BEAT_PERIOD
from engine.protocols import robot_link
from engine.specs.containers import LINK_STATE, Launch
from ppaas.errors import PPaaSError
from ppaas.messages import decode, encode, type_name
from ppaas.messages.message import Message
from ppaas.nodes.base import Node, Payload, Topic
from ppaas.nodes.graph import Graph

logger = logging.getLogger(__name__)

CHECKPOINT_PERIOD = 0.25
"""Seconds; in them a robot moves no farther than localization forgives, should the container be lost."""
MAX_UNTOLD = 100
"""Messages that are said once and kept, while there is no endpoint, for whoever subscribes to them next."""

MAX_WAITING = 1 << 20
"""Bytes that may wait for a slow endpoint before messages that may be lost are."""


def payload_bytes(payload: Payload) -> bytes:
    """Return a message as JSON, made only now if it is lazy."""
    return encode(payload if isinstance(payload, Message) else payload.to_message())


def topic_info(topic: Topic) -> robot_link.TopicInfo:
    """Return a topic as the endpoint is told of it."""
    return robot_link.TopicInfo(topic.name, type_name(topic.type), topic.latched)


def node_info(graph: Graph, node: Node) -> robot_link.NodeInfo:
    """Return a node as the endpoint is told of it."""
    subscribes = tuple(topic.name for topic in node.subscribes)
    return robot_link.NodeInfo(node.name, graph.published_by(node), subscribes, tuple(s.name for s in node.services))


class Container:
    """What runs in the process.

    Parameters
    ----------
    launch : Launch
        What the machine handed over.
    home : CloudHome
        With the graph built and restored.
    endpoint : EndpointLink
        The robot link.
    machine : MachineClient
        The machine link.
    notes : PlanningNotes
        What is to be told of planning.
    monitoring : Monitoring, optional
        Which of a clone's nodes run here.
    """

    def __init__(
        self,
        launch: Launch,
        home: CloudHome,
        endpoint: EndpointLink,
        machine: MachineClient,
        notes: PlanningNotes,
        *,
        monitoring: Monitoring | None = None,
    ) -> None:
        self._notes = notes
        self._monitoring = monitoring
        self._launch = launch
        self._home = home
        self._graph = home.graph
        self._endpoint = endpoint
        self._machine = machine
        self._wanted: set[str] = set()
        self._taps: dict[str, Callable[[], None]] = {}
        self._applied = int(launch.spec.checkpoint.get(LINK_STATE, b"0"))
        self._dirty = asyncio.Event()
        self._held: list[robot_link.Published] = []
        self._untold: deque[robot_link.Published] = deque(maxlen=MAX_UNTOLD)
        self._graph.watch(self._topic_changed)
        if monitoring is not None:
            monitoring.changed = lambda: endpoint.write(self._offers())

    # -- the robot link ------------------------------------------------------------------------------------------------

    def _offers(self) -> robot_link.NodesChanged:
        graph = self._graph
        services = [robot_link.ServiceInfo(service.name, service.type.name) for service in graph.services.values()]
        return robot_link.NodesChanged(services, [node_info(graph, node) for node in graph.nodes.values()])

    def hello(self, pid: int) -> robot_link.Hello:
        """Return what the endpoint is told first."""
        graph, offers = self._graph, self._offers()
        return robot_link.Hello(
            container=self._launch.spec.id,
            secret=self._launch.secret,
            pid=pid,
            applied=self._applied,
            topics=[topic_info(topic) for topic in graph.topics.values()],
            services=offers.services,
            nodes=offers.nodes,
        )

    async def serve(self) -> None:
        """Take frames until an endpoint says stop."""
        await self._endpoint.serve(self._take, lambda: self.hello(os.getpid()), self._forget_clients)
        self._notes.tell(self._machine)
        await self._save()

    def _forget_clients(self) -> None:
        """Send nobody anything; what is said once is kept for whoever subscribes to it next."""
        self._wanted.clear()
        for topic in tuple(self._taps):
            if topic not in self._graph.topics or not self._graph.topics[topic].published_once:
                self._taps.pop(topic)()

    def _take(self, frame: robot_link.ToContainer) -> bool:
        match frame:
            case robot_link.Deliver():
                self._deliver(frame)
            case robot_link.Subscribe():
                self._subscribe(frame.topic, frame.client)
            case robot_link.Unsubscribe():
                self._unsubscribe(frame.topic)
            case robot_link.ServiceCall():
                self._call(frame)
            case robot_link.Shutdown():
                return False
        self._home.attend()
        return True

    def _deliver(self, frame: robot_link.Deliver) -> None:
        if 0 < frame.sequence <= self._applied:
            return
        if self._monitoring is not None:
            self._monitoring.rates.note(frame.topic, len(frame.payload))
        try:
            self._graph.inject(frame.topic, decode(self._graph.topic(frame.topic).type, frame.payload))
        except PPaaSError as error:
            self._refuse(frame, error)
        except Exception as error:
            # What must arrive is sent again to the next container: one bad message must not become a crash loop.
            logger.exception("a message on %s broke a node", frame.topic)
            self._refuse(frame, PPaaSError(f"internal error: {type(error).__name__}"))
        if frame.sequence:
            self._applied = frame.sequence
            self._dirty.set()

    def _refuse(self, frame: robot_link.Deliver, error: PPaaSError) -> None:
        refusal = robot_link.Refusal(error.slug, str(error))
        self._endpoint.write(robot_link.MessageRefused(frame.client, frame.topic, refusal, frame.sequence))

    def _subscribe(self, topic: str, client: int) -> None:
        self._wanted.add(topic)
        if topic not in self._graph.topics:
            return
        if topic not in self._taps:
            self._taps[topic] = self._graph.tap(topic, self._forward)
        elif self._graph.topics[topic].published_once:
            told, self._untold = [*self._untold], deque(maxlen=MAX_UNTOLD)
            self._tell(told)
        elif (last := self._graph.latched(topic)) is not None:
            self._endpoint.write(robot_link.Published(topic, payload_bytes(last), client))

    def _unsubscribe(self, topic: str) -> None:
        self._wanted.discard(topic)
        untap = self._taps.pop(topic, None)
        if untap is not None:
            untap()

    def _topic_changed(self, node: Node, name: str, topic: Topic | None) -> None:
        """Tell the endpoint; what it wants to hear is tapped again as often as it comes."""
        if topic is None:
            self._taps.pop(name, None)
            self._endpoint.write(robot_link.TopicRemoved(name))
            return
        self._endpoint.write(robot_link.TopicAdded(topic_info(topic), node.name))
        if name in self._wanted:
            self._taps[name] = self._graph.tap(name, self._forward)

    def _forward(self, topic: str, payload: Payload) -> None:
        kind = self._graph.topics[topic]
        if kind.published_once:
            self._held.append(robot_link.Published(topic, payload_bytes(payload)))
            self._dirty.set()
        elif kind.latched or self._endpoint.waiting <= MAX_WAITING:
            self._endpoint.write(robot_link.Published(topic, payload_bytes(payload)))

    def _tell(self, said: Iterable[robot_link.Published]) -> None:
        """Tell once what is said once."""
        for published in said:
            if published.topic in self._wanted:
                self._endpoint.write(published)
            else:
                self._untold.append(published)

    def _call(self, frame: robot_link.ServiceCall) -> None:
        stream = self._endpoint.stream  # another endpoint did not ask

        def reply(result: Payload | PPaaSError) -> None:
            if isinstance(result, PPaaSError):
                answer = robot_link.ServiceAnswer(frame.call, refusal=robot_link.Refusal(result.slug, str(result)))
            else:
                answer = robot_link.ServiceAnswer(frame.call, payload_bytes(result))
            stream.write(answer)

        try:
            service = self._graph.service(frame.service)
            request = decode(service.type.request, frame.payload)
            self._graph.call(frame.service, request, reply)
        except PPaaSError as error:
            reply(error)
        except Exception as error:
            # As for messages: whoever asks again and again must not end container after container.
            logger.exception("a call of %s broke a node", frame.service)
            reply(PPaaSError(f"internal error: {type(error).__name__}"))

    async def beat(self) -> None:
        """Show that this process is not frozen, and tell the machine what was planned meanwhile."""
        while True:
            self._endpoint.write(robot_link.ContainerBeat(self._graph.busy))
            self._notes.tell(self._machine)
            await asyncio.sleep(BEAT_PERIOD)

    # -- checkpoints ---------------------------------------------------------------------------------------------------

    async def keep_checkpoints(self) -> None:
        """Save the clone's state: at once after what must not be lost, else once a period."""
        while True:
            try:
                async with asyncio.timeout(CHECKPOINT_PERIOD):
                    await self._dirty.wait()
            except TimeoutError:
                pass
            await self._save()

    async def _save(self) -> None:
        self._dirty.clear()
        if self._launch.spec.robot is None or not self._endpoint.is_up:
            return
        applied, told, self._held = self._applied, self._held, []
        nodes = {checkpoint.node: checkpoint.state for checkpoint in self._graph.checkpoints()}
        nodes[LINK_STATE] = str(applied).encode()
        try:
            await self._machine.save_clone(nodes)
        except PPaaSError as error:
            logger.warning("the checkpoint was not kept, and will be tried again: %s", error)
        else:
            self._endpoint.write(robot_link.Ack(applied))
        self._tell(told)  # where nothing can be kept, that it is told goes before that it is told once
