"""Container of a clone: its graph as the sessions of its clients use it, its links, and its checkpoints.

All that listen to the clone are served in the same way: the sessions in this process, and by frames each link, to the
master and to endpoints.
"""

import asyncio
import logging
import os
from collections import deque
from collections.abc import Callable, Iterable
from pathlib import Path

from engine.container.endpoint_links import EndpointLink, EndpointLinks, ServedLink
from engine.container.executor import NodeExecutor
from engine.container.graph_building import Attendants
from engine.container.machine_client import MachineClient
from engine.container.node_logs import NodeLogs
from engine.container.robot_report import RobotReporter
from engine.container.shared_plans import PlanningNotes
from engine.links.open_calls import Outcome
from engine.processes.heartbeats import BEAT_PERIOD
from engine.processes.occasional_log import OccasionalLog
from engine.protocols import robot_link
from engine.protocols.address import RELAY
from engine.protocols.refusals import error_of, refusal_of
from engine.protocols.versions import OWN
from engine.sessions.host import SessionHost
from engine.sessions.place.clone import CloneListener
from engine.sessions.place.place import Place
from engine.specs.containers import LINK_STATE, SESSIONS_STATE, ContainerSpec, Launch, RobotConfig, base_frame
from ppaas.errors import Conflict, PPaaSError
from ppaas.listener_faults import internal_error
from ppaas.messages import decode, encode, type_name
from ppaas.messages.base.message import Message
from ppaas.nodes.base import Node, Payload, Topic
from ppaas.nodes.graph import Graph
from ppaas.tracing.spans import span, within

logger = logging.getLogger(__name__)

CHECKPOINT_PERIOD = 0.25
"""Largest time between checkpoints [s]; localization tolerates the motion of a robot in this time."""

MAX_UNSENT = 100
"""Number of messages on ``published_once`` topics that are kept without an endpoint, for the next subscriber."""


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


def sessions_of(spec: ContainerSpec, robot: RobotConfig) -> SessionHost:
    """Return the sessions of the clients of a robot; those of an earlier container are in the checkpoint."""
    sessions = SessionHost(Place(f"{spec.user}/{robot.id}", base_frame(robot)))
    if SESSIONS_STATE in spec.checkpoint:
        sessions.restore(spec.checkpoint[SESSIONS_STATE])
    return sessions


def _for_clients(error: PPaaSError) -> PPaaSError:
    """Return an error as clients may read it; a text for operators is logged here."""
    return error_of(refusal_of(error))


class Container:
    """Clone of a container for all that listen to it, with its links and its checkpoints.

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
    attendants : Attendants, optional
        Node monitor of a clone, and its node of stops.
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
        attendants: Attendants | None = None,
        sessions: SessionHost | None = None,
    ) -> None:
        self._notes = notes
        monitoring = self._monitoring = None if attendants is None else attendants.monitoring
        self._stop = None if attendants is None else attendants.stop
        self._sessions = sessions
        self._reporter = None if sessions is None else RobotReporter(home.graph, sessions, notes.goal_ended)
        self._launch = launch
        self._home = home
        self._graph = home.graph
        self._endpoint = endpoint
        self._machine = machine
        self._remote = ServedLink(endpoint, int(launch.spec.checkpoint.get(LINK_STATE, b"0")))
        self._links = [self._remote]
        self._listeners: list[CloneListener] = [self._remote]
        self.endpoints = EndpointLinks(self, sessions, Path(launch.link).parent / RELAY, launch.on)
        self._unheard_stops = False
        self._taps: dict[str, Callable[[], None]] = {}
        self._dirty = asyncio.Event()
        self._unsaved = OccasionalLog(logger)
        self._logs = NodeLogs(home.graph, None if monitoring is None else monitoring.logs)
        self._held: list[tuple[str, bytes]] = []
        self._unsent: deque[tuple[str, bytes]] = deque(maxlen=MAX_UNSENT)
        self._graph.watch(self._topic_changed)
        if monitoring is not None:
            monitoring.changed = self._report_nodes
        if self._stop is not None:
            self._stop.changed = self._report_stops

    def _report_nodes(self) -> None:
        services, nodes = self.services(), self.nodes()
        for listener in self._listeners:
            listener.nodes_changed(services, nodes)
        self._note_heard_stops()

    def _report_stops(self) -> None:
        """Report the stops in force to the master, and store a request that it may not have yet."""
        if (stops := self._stops()) is not None:
            self._endpoint.write(stops)
            self._unheard_stops = stops.unheard
        self._dirty.set()

    def _note_heard_stops(self) -> None:
        """Report the stops in force again, if the robot has confirmed them or does so no longer."""
        if self._monitoring is not None and self._monitoring.lacks_stops() != self._unheard_stops:
            self._report_stops()

    def _stops(self) -> robot_link.StopsInForce | None:
        if self._stop is None or self._monitoring is None:
            return None
        latch = self._stop.latch
        return robot_link.StopsInForce(latch.stops, latch.requested, self._monitoring.lacks_stops())

    # -- the clone -----------------------------------------------------------------------------------------------------

    def topics(self) -> list[robot_link.TopicInfo]:
        """Return the topics of the clone."""
        return [topic_info(topic) for topic in self._graph.topics.values()]

    def services(self) -> list[robot_link.ServiceInfo]:
        """Return the services of the clone."""
        return [robot_link.ServiceInfo(service.name, service.type.name) for service in self._graph.services.values()]

    def nodes(self) -> list[robot_link.NodeInfo]:
        """Return the nodes of the clone."""
        return [node_info(self._graph, node) for node in self._graph.nodes.values()]

    def add_listener(self, listener: CloneListener) -> None:
        """Notify a listener of what happens from now on."""
        self._listeners.append(listener)

    def deliver(self, topic: str, payload: bytes, client: int, sequence: int) -> PPaaSError | None:
        """Give the nodes a message; with sequence 0 it may be lost. Return the reason if it is refused."""
        if self._monitoring is not None:
            self._monitoring.rates.note(topic, len(payload))
            self._monitoring.traffic.note(topic, len(payload), client, self._graph.elapsed())
        refusal = None
        try:
            self._graph.inject(topic, decode(self._graph.topic(topic).type, payload))
        except PPaaSError as error:
            refusal = error
        except Exception as error:
            # Reliable messages are sent again to the next container: one bad message must not cause a crash loop.
            logger.exception("a message on %s caused an internal error in a node", topic)
            refusal = internal_error(error)
        if refusal is not None and self._monitoring is not None:
            self._monitoring.traffic.refuse(topic, str(refusal), self._graph.elapsed())
        if sequence or any(node.has_log_change for node in self._graph.nodes_with_logs):
            self._dirty.set()
        self._home.attend()
        return None if refusal is None else _for_clients(refusal)

    def subscribe(self, listener: CloneListener, topic: str, client: int) -> None:
        """Send a listener the messages of a topic that it wants; the last one at once if the topic is latched."""
        if topic not in self._graph.topics:
            return
        if topic not in self._taps:
            self._taps[topic] = self._graph.tap(topic, self._forward)
        elif self._graph.topics[topic].published_once:
            unsent, self._unsent = [*self._unsent], deque(maxlen=MAX_UNSENT)
            self._send_or_keep(unsent)
        elif (last := self._graph.latched(topic)) is not None:
            listener.published(topic, payload_bytes(last), client)
        self._home.attend()

    def unsubscribe(self, topic: str) -> None:
        """End a subscription; messages on ``published_once`` topics are kept for the next subscriber."""
        if self._is_wanted(topic) or topic not in self._taps:
            return
        if topic not in self._graph.topics or not self._graph.topics[topic].published_once:
            self._taps.pop(topic)()

    def _is_wanted(self, topic: str) -> bool:
        return any(listener.wants(topic) for listener in self._listeners)

    def call(self, service: str, payload: bytes, reply: Callable[[Outcome], None]) -> None:
        """Call a service; ``reply`` is called with the response as JSON or the error, now or later."""
        if service == robot_link.LINK_FACTS and self._sessions is not None:  # known to the sessions, not to a node
            reply(self._sessions.link_facts())
            return
        called = span("service", {"ppaas.service": service}, "server")

        def answer(result: Payload | PPaaSError) -> None:
            called.end(result)
            reply(_for_clients(result) if isinstance(result, PPaaSError) else payload_bytes(result))

        try:
            request = decode(self._graph.service(service).type.request, payload)
            called.rename(f"service {service}")
            with called.active():
                self._graph.call(service, request, answer)
        except PPaaSError as error:
            answer(error)
        except Exception as error:
            # As with messages: a repeated bad call must not crash one container after another.
            logger.exception("a call of service %s caused an internal error in a node", service)
            answer(internal_error(error))
        self._note_heard_stops()
        self._home.attend()

    # -- to all that listen --------------------------------------------------------------------------------------------

    def _topic_changed(self, node: Node, name: str, topic: Topic | None) -> None:
        if topic is None:
            self._taps.pop(name, None)
            for listener in self._listeners:
                listener.topic_removed(name)
            return
        info = topic_info(topic)
        for listener in self._listeners:
            listener.topic_added(info, node.name)
        if self._is_wanted(name):
            self._taps[name] = self._graph.tap(name, self._forward)

    def _forward(self, topic: str, payload: Payload) -> None:
        kind = self._graph.topics[topic]
        if kind.published_once:
            self._held.append((topic, payload_bytes(payload)))
            self._dirty.set()
            return
        must_arrive = (kind.latched and not kind.repeated) or kind.lasting
        hearers = [each for each in self._listeners if each.wants(topic) and (must_arrive or not each.is_slow)]
        if hearers:
            content = payload_bytes(payload)  # once for all
            for listener in hearers:
                listener.published(topic, content)

    def _send_or_keep(self, messages: Iterable[tuple[str, bytes]]) -> None:
        """Send messages on ``published_once`` topics to all that are subscribed; else keep them for the next."""
        for topic, payload in messages:
            hearers = [listener for listener in self._listeners if listener.wants(topic)]
            for listener in hearers:
                listener.published(topic, payload)
            if not hearers:
                self._unsent.append((topic, payload))

    def map_replaced(self) -> None:
        """Notify all listeners that only changes of the map were published."""
        for listener in self._listeners:
            listener.map_replaced()

    # -- the robot link ------------------------------------------------------------------------------------------------

    def hello(self, pid: int, endpoint: robot_link.DialEndpoint | None = None) -> robot_link.Hello:
        """Return the first frame for the link to the master, or to an endpoint: the topics, services and nodes."""
        return robot_link.Hello(
            container=self._launch.spec.id,
            secret=self._launch.secret if endpoint is None else endpoint.secret,
            pid=pid,
            applied=self._remote.applied if endpoint is None else 0,
            topics=self.topics(),
            services=self.services(),
            nodes=self.nodes(),
            place="" if endpoint is None else endpoint.place,
            generation=0 if endpoint is None else endpoint.generation,
            beat=self._beat(),
            stops=self._stops(),
            protocols=OWN,
        )

    async def serve(self) -> None:
        """Handle frames until an endpoint sends a shutdown."""
        await self._endpoint.serve(lambda frame: self.take(self._remote, frame), self._hello_again, self._endpoint_lost)
        self._notes.tell(self._machine)
        await self._save()

    def _hello_again(self) -> robot_link.Hello:
        if self._sessions is not None:
            self._sessions.link_up(self._endpoint)
        return self.hello(os.getpid())

    def _endpoint_lost(self) -> None:
        if self._sessions is not None:
            self._sessions.link_lost(self._endpoint)
        self._drop_subscriptions(self._remote)

    def take(self, link: ServedLink, frame: robot_link.ToContainer) -> bool:
        """Handle a frame of a link; return false if it is the last."""
        match frame:
            case robot_link.Deliver():
                self._deliver(link, frame)
            case robot_link.SubscribeTopic():
                link.wanted.add(frame.topic)
                self.subscribe(link, frame.topic, frame.client)
            case robot_link.UnsubscribeTopic():
                link.wanted.discard(frame.topic)
                self.unsubscribe(frame.topic)
            case robot_link.ServiceCall():
                self._call(link, frame)
            case robot_link.Shutdown():
                return False
            case robot_link.DialEndpoint() | robot_link.LeaveEndpoint() | robot_link.SetStops():
                self._obey(frame)
            case _:
                if self._sessions is not None:
                    self._sessions.take(link.end, frame)
        self._home.attend()
        return True

    def _obey(self, order: robot_link.DialEndpoint | robot_link.LeaveEndpoint | robot_link.SetStops) -> None:
        """Execute an order of the master."""
        match order:
            case robot_link.DialEndpoint():
                self.endpoints.dial(order)
            case robot_link.LeaveEndpoint():
                self.endpoints.leave(order.endpoint)
            case robot_link.SetStops() if self._stop is not None:
                self._stop.set(order.stops)

    def _deliver(self, link: ServedLink, frame: robot_link.Deliver) -> None:
        if 0 < frame.sequence <= link.applied:
            return
        with within(frame.trace):
            refusal = self.deliver(frame.topic, frame.payload, frame.client, frame.sequence)
        if refusal is not None:
            link.end.write(robot_link.MessageRefused(frame.client, frame.topic, refusal_of(refusal), frame.sequence))
        if frame.sequence:
            link.applied = frame.sequence

    def _call(self, link: ServedLink, frame: robot_link.ServiceCall) -> None:
        stream = self._endpoint.stream if link is self._remote else link.end  # the answer is for this endpoint only

        def reply(outcome: Outcome) -> None:
            if isinstance(outcome, PPaaSError):
                stream.write(robot_link.ServiceAnswer(frame.call, refusal=refusal_of(outcome)))
            else:
                stream.write(robot_link.ServiceAnswer(frame.call, outcome))

        with within(frame.trace):
            self.call(frame.service, frame.payload, reply)

    def add_link(self, link: ServedLink) -> None:
        """Serve a link, too."""
        self._links.append(link)
        self._listeners.append(link)

    def drop_link(self, link: ServedLink) -> None:
        """Stop serving a link: drop its subscriptions."""
        self._links.remove(link)
        self._listeners.remove(link)
        self._drop_subscriptions(link)

    def _drop_subscriptions(self, link: ServedLink) -> None:
        topics, link.wanted = link.wanted, set()
        for topic in topics:
            self.unsubscribe(topic)

    async def beat(self) -> None:
        """Send heartbeats to the master and the endpoints, and new planning times to the machine."""
        while True:
            beat = self._beat()
            for link in self._links:  # the sessions in this process end with it
                link.end.write(beat)
            self._notes.tell(self._machine)
            await asyncio.sleep(BEAT_PERIOD)

    def _beat(self) -> robot_link.ContainerBeat:
        sessions = self._sessions
        if sessions is None or self._reporter is None:
            return robot_link.ContainerBeat(self._graph.busy)
        return robot_link.ContainerBeat(
            self._graph.busy, sessions.sockets, sessions.taken, sessions.round_trip, sessions.robot_is_here,
            self._reporter.report(),
        )  # fmt: skip

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
        applied, held, self._held = [(each, each.applied) for each in self._listeners], self._held, []
        nodes = {checkpoint.node: checkpoint.state for checkpoint in self._graph.checkpoints()}
        # Only of the master's link: endpoints send nothing that must arrive, and sessions have their own checkpoint.
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
            for listener, sequence in applied:
                listener.acknowledged(sequence)
        self._send_or_keep(held)  # sent even if the save failed: better twice than never
