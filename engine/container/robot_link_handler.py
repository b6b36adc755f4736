"""Robot link handler: passes frames to the graph, sends the graph's messages, and saves checkpoints.

A clone serves all its links in the same way: to the master, to endpoints, and to the sessions of its clients.
"""

import asyncio
import logging
import os
from collections import deque
from collections.abc import Callable, Iterable
from pathlib import Path

from engine.container.endpoint_link import EndpointLink
from engine.container.endpoint_links import EndpointLinks
from engine.container.executor import NodeExecutor
from engine.container.machine_client import MachineClient
from engine.container.monitor.setup import ContainerMonitor
from engine.container.node_logs import NodeLogs
from engine.container.served_link import ServedLink
from engine.container.shared_plans import PlanningNotes
from engine.processes.heartbeats import BEAT_PERIOD
from engine.processes.occasional_log import OccasionalLog
from engine.protocols import robot_link
from engine.protocols.address import RELAY
from engine.protocols.refusals import refusal_of
from engine.sessions.host import SessionHost
from engine.specs.containers import LINK_STATE, SESSIONS_STATE, Launch
from ppaas.errors import Conflict, PPaaSError
from ppaas.messages import decode, encode, type_name
from ppaas.messages.base.message import Message
from ppaas.nodes.base import Node, Payload, Topic
from ppaas.nodes.graph import Graph

logger = logging.getLogger(__name__)

CHECKPOINT_PERIOD = 0.25
"""Largest time between checkpoints [s]; localization tolerates the motion of a robot in this time."""

MAX_UNSENT = 100
"""Number of messages on ``published_once`` topics that are kept without an endpoint, for the next subscriber."""

MAX_WAITING = 1 << 20
"""Bytes queued for a slow endpoint above which messages are dropped whose topic is neither latched nor lasting, or is
repeated."""


def payload_bytes(payload: Payload) -> bytes:
    """Return a message as JSON; a lazy payload is converted now."""
    return encode(payload if isinstance(payload, Message) else payload.to_message())


def topic_info(topic: Topic) -> robot_link.TopicInfo:
    """Return the description of a topic for the endpoint."""
    return robot_link.TopicInfo(topic.name, type_name(topic.type), topic.latched)


def node_info(graph: Graph, node: Node) -> robot_link.NodeInfo:
    """Return the description of a node for the endpoint."""
    subscribes = tuple(topic.name for topic in node.subscribes)
    return robot_link.NodeInfo(node.name, graph.published_by(node), subscribes, tuple(s.name for s in node.services))


class Container:
    """Handler of one container's robot link, with its checkpoints.

    Parameters
    ----------
    launch : Launch
        Specification of the container, from its machine.
    home : NodeExecutor
        Node executor, with the graph built and restored.
    endpoint : EndpointLink
        The robot link.
    machine : MachineClient
        The machine link.
    notes : PlanningNotes
        Planning times that are to be reported to the machine.
    monitoring : ContainerMonitor, optional
        Node monitor of a clone.
    sessions : SessionHost, optional
        Sessions of the clients of a clone.
    """

    def __init__(
        self,
        launch: Launch,
        home: NodeExecutor,
        endpoint: EndpointLink,
        machine: MachineClient,
        notes: PlanningNotes,
        *,
        monitoring: ContainerMonitor | None = None,
        sessions: SessionHost | None = None,
    ) -> None:
        self._notes = notes
        self._monitoring = monitoring
        self._sessions = sessions
        self._launch = launch
        self._home = home
        self._graph = home.graph
        self._endpoint = endpoint
        self._machine = machine
        self._remote = ServedLink(endpoint, int(launch.spec.checkpoint.get(LINK_STATE, b"0")))
        self._links = [self._remote]
        self.endpoints = EndpointLinks(self, sessions, Path(launch.link).parent / RELAY, launch.on)
        self._taps: dict[str, Callable[[], None]] = {}
        self._dirty = asyncio.Event()
        self._unsaved = OccasionalLog(logger)
        self._logs = NodeLogs(home.graph, None if monitoring is None else monitoring.logs)
        self._held: list[robot_link.Published] = []
        self._unsent: deque[robot_link.Published] = deque(maxlen=MAX_UNSENT)
        self._graph.watch(self._topic_changed)
        if monitoring is not None:
            monitoring.changed = lambda: self._write(self._offers())

    def _write(self, frame: robot_link.FromContainer) -> None:
        for link in self._links:
            link.end.write(frame)

    def add_link(self, link: ServedLink) -> None:
        """Serve a link, too."""
        self._links.append(link)

    def drop_link(self, link: ServedLink) -> None:
        """Stop serving a link: drop its subscriptions."""
        self._links.remove(link)
        for topic in tuple(link.wanted):
            self._unsubscribe(link, topic)

    # -- the robot link ------------------------------------------------------------------------------------------------

    def _offers(self) -> robot_link.NodesChanged:
        graph = self._graph
        services = [robot_link.ServiceInfo(service.name, service.type.name) for service in graph.services.values()]
        return robot_link.NodesChanged(services, [node_info(graph, node) for node in graph.nodes.values()])

    def hello(self, pid: int, endpoint: robot_link.DialEndpoint | None = None) -> robot_link.Hello:
        """Return the first frame for the link to the master, or to an endpoint: the topics, services and nodes."""
        graph, offers = self._graph, self._offers()
        return robot_link.Hello(
            container=self._launch.spec.id,
            secret=self._launch.secret if endpoint is None else endpoint.secret,
            pid=pid,
            applied=self._remote.applied if endpoint is None else 0,
            topics=[topic_info(topic) for topic in graph.topics.values()],
            services=offers.services,
            nodes=offers.nodes,
            place="" if endpoint is None else endpoint.place,
            generation=0 if endpoint is None else endpoint.generation,
            beat=self._beat(),
        )

    async def serve(self) -> None:
        """Handle frames until an endpoint sends a shutdown."""
        await self._endpoint.serve(lambda frame: self.take(self._remote, frame), self._hello_again, self._endpoint_lost)
        self._notes.tell(self._machine)
        await self._save()

    def _hello_again(self) -> robot_link.Hello:
        """Return the hello for an endpoint that the container dials after it lost one."""
        if self._sessions is not None:
            self._sessions.link_up(self._endpoint)
        return self.hello(os.getpid())

    def _endpoint_lost(self) -> None:
        """Detach the sockets of the endpoint, and drop its subscriptions."""
        if self._sessions is not None:
            self._sessions.link_lost(self._endpoint)
        for topic in tuple(self._remote.wanted):
            self._unsubscribe(self._remote, topic)

    def take(self, link: ServedLink, frame: robot_link.ToContainer) -> bool:
        """Handle a frame of a link; return false if it is the last."""
        match frame:
            case robot_link.Deliver():
                self._deliver(link, frame)
            case robot_link.Subscribe():
                self._subscribe(link, frame.topic, frame.client)
            case robot_link.Unsubscribe():
                self._unsubscribe(link, frame.topic)
            case robot_link.ServiceCall():
                self._call(link, frame)
            case robot_link.Shutdown():
                return False
            case robot_link.DialEndpoint():
                self.endpoints.dial(frame)
            case robot_link.LeaveEndpoint():
                self.endpoints.leave(frame.endpoint)
            case _:
                if self._sessions is not None:
                    self._sessions.take(link.end, frame)
        self._home.attend()
        return True

    def _deliver(self, link: ServedLink, frame: robot_link.Deliver) -> None:
        if 0 < frame.sequence <= link.applied:
            return
        if self._monitoring is not None:
            self._monitoring.rates.note(frame.topic, len(frame.payload))
            self._monitoring.traffic.note(frame.topic, len(frame.payload), frame.client, self._graph.elapsed())
        try:
            self._graph.inject(frame.topic, decode(self._graph.topic(frame.topic).type, frame.payload))
        except PPaaSError as error:
            self._refuse(link, frame, error)
        except Exception as error:
            # Reliable messages are sent again to the next container: one bad message must not cause a crash loop.
            logger.exception("a message on %s caused an internal error in a node", frame.topic)
            self._refuse(link, frame, PPaaSError(f"internal error: {type(error).__name__}"))
        if frame.sequence:
            link.applied = frame.sequence
            self._dirty.set()
        elif any(node.has_log_change for node in self._graph.nodes_with_logs):
            self._dirty.set()

    def _refuse(self, link: ServedLink, frame: robot_link.Deliver, error: PPaaSError) -> None:
        refusal = refusal_of(error)
        if self._monitoring is not None:
            self._monitoring.traffic.refuse(frame.topic, str(error), self._graph.elapsed())
        link.end.write(robot_link.MessageRefused(frame.client, frame.topic, refusal, frame.sequence))

    def _subscribe(self, link: ServedLink, topic: str, client: int) -> None:
        link.wanted.add(topic)
        if topic not in self._graph.topics:
            return
        if topic not in self._taps:
            self._taps[topic] = self._graph.tap(topic, self._forward)
        elif self._graph.topics[topic].published_once:
            unsent, self._unsent = [*self._unsent], deque(maxlen=MAX_UNSENT)
            self._send_or_keep(unsent)
        elif (last := self._graph.latched(topic)) is not None:
            link.end.write(robot_link.Published(topic, payload_bytes(last), client or None))

    def _unsubscribe(self, link: ServedLink, topic: str) -> None:
        """End a subscription; messages on ``published_once`` topics are kept for the next subscriber."""
        link.wanted.discard(topic)
        if self._is_wanted(topic) or topic not in self._taps:
            return
        if topic not in self._graph.topics or not self._graph.topics[topic].published_once:
            self._taps.pop(topic)()

    def _is_wanted(self, topic: str) -> bool:
        return any(topic in link.wanted for link in self._links)

    def _topic_changed(self, node: Node, name: str, topic: Topic | None) -> None:
        """Announce a new or removed topic to all links; forward a new one to the links that are subscribed to it."""
        if topic is None:
            self._taps.pop(name, None)
            self._write(robot_link.TopicRemoved(name))
            return
        self._write(robot_link.TopicAdded(topic_info(topic), node.name))
        if self._is_wanted(name):
            self._taps[name] = self._graph.tap(name, self._forward)

    def map_replaced(self) -> None:
        """Notify all links that only changes of the map were published."""
        self._write(robot_link.MapReplaced())

    def _forward(self, topic: str, payload: Payload) -> None:
        kind = self._graph.topics[topic]
        if kind.published_once:
            self._held.append(robot_link.Published(topic, payload_bytes(payload)))
            self._dirty.set()
            return
        must_arrive = (kind.latched and not kind.repeated) or kind.lasting
        ends = [link.end for link in self._links if topic in link.wanted]
        ends = [end for end in ends if must_arrive or end.waiting <= MAX_WAITING]
        if ends:
            published = robot_link.Published(topic, payload_bytes(payload))
            for end in ends:
                end.write(published)

    def _send_or_keep(self, messages: Iterable[robot_link.Published]) -> None:
        """Send messages on ``published_once`` topics to the links that are subscribed; else keep them for the next."""
        for published in messages:
            ends = [link.end for link in self._links if published.topic in link.wanted]
            for end in ends:
                end.write(published)
            if not ends:
                self._unsent.append(published)

    def _call(self, link: ServedLink, frame: robot_link.ServiceCall) -> None:
        stream = self._endpoint.stream if link is self._remote else link.end  # the answer is for this endpoint only

        def reply(result: Payload | PPaaSError) -> None:
            if isinstance(result, PPaaSError):
                answer = robot_link.ServiceAnswer(frame.call, refusal=refusal_of(result))
            else:
                answer = robot_link.ServiceAnswer(frame.call, payload_bytes(result))
            stream.write(answer)

        if frame.service == robot_link.LINK_FACTS and self._sessions is not None:
            stream.write(robot_link.ServiceAnswer(frame.call, self._sessions.link_facts()))
            return
        try:
            service = self._graph.service(frame.service)
            request = decode(service.type.request, frame.payload)
            self._graph.call(frame.service, request, reply)
        except PPaaSError as error:
            reply(error)
        except Exception as error:
            # As with messages: a repeated bad call must not crash one container after another.
            logger.exception("a call of service %s caused an internal error in a node", frame.service)
            reply(PPaaSError(f"internal error: {type(error).__name__}"))

    async def beat(self) -> None:
        """Send heartbeats to the master and the endpoints, and new planning times to the machine."""
        while True:
            self._write(self._beat())
            self._notes.tell(self._machine)
            await asyncio.sleep(BEAT_PERIOD)

    def _beat(self) -> robot_link.ContainerBeat:
        sessions = self._sessions
        if sessions is None:
            return robot_link.ContainerBeat(self._graph.busy)
        return robot_link.ContainerBeat(
            self._graph.busy, sessions.sockets, sessions.taken, sessions.round_trip, sessions.robot_is_here
        )

    # -- checkpoints ---------------------------------------------------------------------------------------------------

    async def keep_checkpoints(self) -> None:
        """Save the clone's state at once after a reliable message, and otherwise every `CHECKPOINT_PERIOD`."""
        while True:
            try:
                async with asyncio.timeout(CHECKPOINT_PERIOD):
                    await self._dirty.wait()
            except TimeoutError:
                pass
            await self._save()

    async def restore_logs(self) -> None:
        """Give the nodes their logs, after a checkpoint; a new session has none."""
        if self._launch.spec.checkpoint:
            await self._logs.restore(self._machine)

    async def _save(self) -> None:
        self._dirty.clear()
        if self._launch.spec.kind == "planning" or not (self._endpoint.is_up or self.endpoints.any_up):
            return
        applied, held, self._held = [(link, link.applied) for link in self._links], self._held, []
        nodes = {checkpoint.node: checkpoint.state for checkpoint in self._graph.checkpoints()}
        nodes[LINK_STATE] = str(self._remote.applied).encode()
        if self._sessions is not None:
            nodes[SESSIONS_STATE] = self._sessions.checkpoint()
        try:
            await self._logs.save(self._machine, nodes)
        except PPaaSError as error:
            self._unsaved.warning("the checkpoint was not saved; it will be tried again: %s", error)
            if isinstance(error, Conflict):
                # The machine is cut off: the robot's next container may publish these. It ends this one, or acts for a
                # master again.
                held, self._held = [], [*held, *self._held]
        else:
            self._unsaved.is_over("checkpoints are saved again")
            for link, sequence in applied:
                link.end.write(robot_link.Ack(sequence))
        self._send_or_keep(held)  # sent even if the save failed: better twice than never
