"""Node monitor: a node of the clone that decides on homes, leases nodes to the robot, and takes back lost ones."""

import logging
from collections.abc import Callable
from typing import ClassVar

import msgspec

from engine.container.monitor.facts import MonitoredNode, NetworkLink, RobotComputer
from engine.container.monitor.leased_logs import MOST_BYTES, LeasedLogs, change_of, parts_of
from engine.container.monitor.leases import GrantedLease, HomeRecord, UnacknowledgedMessages
from engine.container.monitor.measurements import History, TopicRates
from engine.container.monitor.node_switch import NodeSwitch
from engine.container.monitor.parameters import NAME, NodeMonitorParameters
from engine.container.monitor.verdict import asked, judge
from ppaas.decoding import from_json
from ppaas.errors import InvalidInput, InvalidParameter, NotFound, PPaaSError, Unavailable
from ppaas.messages.base.message import Message
from ppaas.messages.ppaas_msgs import (
    GiveNode,
    GiveNodeRequest,
    HoldNode,
    HoldNodeRequest,
    HoldNodeResponse,
    ListNodes,
    NodeHome,
    NodeHomes,
    ProbeLink,
    ProbeLinkRequest,
    ProbeLinkResponse,
    RunNode,
    RunNodeRequest,
    TellRobot,
    TellRobotRequest,
    TellRobotResponse,
)
from ppaas.nodes.base import Context, Node, Reply, Service, Topic
from ppaas.nodes.message_checks import expect
from ppaas.nodes.topics import NODE_HOMES

logger = logging.getLogger(__name__)

LOOK_PERIOD = 0.5
"""Period of the check for expired leases [s]."""

MAX_PROBE = 1 << 20
"""Largest probe of the link [bytes]."""

MAX_STATE = 1 << 20
"""Largest checkpoint of a node that a robot may send [characters]; the built-in nodes' have some hundred."""


class MonitorState(msgspec.Struct):
    """Checkpoint of the node monitor."""

    robot: RobotComputer | None
    link: NetworkLink | None
    round_trips: History
    leases: int
    records: dict[str, HomeRecord]


class NodeMonitorNode(Node):
    """Serves ``node_monitor/…`` and publishes ``node_monitor/homes``: the current and the wanted home of each node.

    A robot runs a node while it holds a lease on it, and renews the lease at least every ``patience`` seconds, each
    time with the node's checkpoint. Otherwise the node continues in the cloud from the last checkpoint. A robot that
    returns later with an expired lease gets the answer that it holds none.

    Parameters
    ----------
    context : Context
        Node context.
    switch : NodeSwitch
        Removes nodes from the graph and adds them again.
    rates : TopicRates
        Data rates of the topics that the clone receives over the link.
    parameters : NodeMonitorParameters
        Parameters of the verdicts.

    Attributes
    ----------
    logs : LeasedLogs
        Logs of the nodes that the robot runs.
    """

    name: ClassVar[str] = NAME
    publishes: ClassVar[tuple[Topic, ...]] = (NODE_HOMES,)
    services: ClassVar[tuple[Service, ...]] = (
        Service("node_monitor/list_nodes", ListNodes),
        Service("node_monitor/tell_robot", TellRobot),
        Service("node_monitor/run_node", RunNode),
        Service("node_monitor/hold_node", HoldNode),
        Service("node_monitor/give_node", GiveNode),
        Service("node_monitor/probe_link", ProbeLink),
    )

    def __init__(
        self, context: Context, switch: NodeSwitch, rates: TopicRates, parameters: NodeMonitorParameters
    ) -> None:
        super().__init__(context)
        self._switch = switch
        self._rates = rates
        self._parameters = parameters
        self._robot: RobotComputer | None = None
        self._link: NetworkLink | None = None
        self._round_trips = History()
        self._leases = 0
        self.logs = LeasedLogs()
        self._kept: tuple[str, set[str]] = "", set()
        self._records = {node: HomeRecord() for node in switch.nodes()}
        self._takers: dict[str, Callable[[Message], Message]] = {
            "list_nodes": lambda _: self._homes(),
            "tell_robot": self._tell_robot,
            "run_node": self._run_node,
            "hold_node": self._hold_node,
            "give_node": self._give_node,
            "probe_link": self._probe_link,
        }

    def start(self) -> None:
        """Start to check the leases of the robot."""
        self.context.every(LOOK_PERIOD, self._check_leases)
        self._publish_homes()

    def on_call(self, service: str, request: Message, reply: Reply) -> None:
        """Answer a service call.

        Raises
        ------
        NotFound
            The clone has no such node.
        InvalidInput
            A number, a state or the name of a home is invalid.
        Unavailable
            The wanted home of the node is the cloud.
        """
        reply(self._takers[service.rpartition("/")[2]](request))

    # -- service calls -------------------------------------------------------------------------------------------------

    def _tell_robot(self, message: Message) -> Message:
        robot = expect(message, TellRobotRequest)
        self._robot = RobotComputer(robot.cores, robot.clock, robot.benchmark, tuple(robot.nodes))
        self._link = NetworkLink(robot.rtt, robot.bandwidth)
        self._round_trips = History([robot.rtt])
        for record in self._records.values():
            record.adrift = False
        return TellRobotResponse(self._switch.config, self._robot.power)

    def _run_node(self, message: Message) -> Message:
        wanted = expect(message, RunNodeRequest)
        record = self._record(wanted.node)
        if wanted.home not in ("", "cloud", "robot"):
            raise InvalidParameter(f"a home is 'cloud' or 'robot', or empty for the best one, not {wanted.home[:32]!r}")
        verdict = judge(self._robot, self._link_now(), self._facts(wanted.node), self._parameters)
        if wanted.home == "cloud":
            verdict = asked("cloud")
        elif wanted.home == "robot" and self._may_be_taken(wanted.node):
            verdict = asked("robot")
        reason, kept = self._kept
        if reason and verdict.home == "robot":
            kept.add(wanted.node)
            verdict = verdict._replace(home="cloud", reasons=(reason,))
        record.wanted, record.score, record.reasons = verdict
        self._publish_homes()
        return self._home_of(wanted.node)

    def _may_be_taken(self, node: str) -> bool:
        return self._robot is not None and node in self._robot.nodes and self._switch.nodes()[node] is not None

    def _hold_node(self, message: Message) -> Message:
        report = expect(message, HoldNodeRequest)
        record = self._record(report.node)
        record.adrift = False
        if report.lease == 0:
            return self._hand_over(report.node, record)
        if record.lease is None or record.lease.number != report.lease:
            return HoldNodeResponse(0)
        record.lease.heard = self.context.elapsed()
        record.lease.state = _checked(report.state) or record.lease.state
        record.lease.unheard.heard(report.heard)
        self.logs.change(report.node, change_of(report.log, report.obsolete))
        record.robot_seconds.note(report.seconds)
        self._round_trips.note(report.rtt)
        return HoldNodeResponse(report.lease, unheard=record.lease.unheard.all())

    def _hand_over(self, node: str, record: HomeRecord) -> Message:
        if record.wanted != "robot":
            raise Unavailable(
                f"the wanted home of {node} is the cloud; request 'robot' with node_monitor/run_node first"
            )
        if record.lease is None:
            self._begin_log(node, record)
            unheard = UnacknowledgedMessages()
            state = self._switch.take_out(node, unheard.note)
        else:  # a robot that requests a node it holds has lost its state: it gets the last checkpoint
            state, unheard = record.lease.state, record.lease.unheard
        self._leases += 1
        record.lease = GrantedLease(self._leases, state, self.context.elapsed(), unheard)
        logger.info("%s continues on the robot", node)
        self._publish_homes()
        return HoldNodeResponse(record.lease.number, state, log=parts_of(self.logs.of(node)))

    def _begin_log(self, node: str, record: HomeRecord) -> None:
        """Begin the log of a node that is to be handed over; a node whose log is too large stays."""
        self.logs.begin(node, self._switch.whole_log(node))
        size = self.logs.size(node)
        if size > MOST_BYTES:
            self.logs.end(node)
            reason = f"its log of {size / 2**20:.0f} MiB is too large to be moved, at most {MOST_BYTES >> 20} MiB are"
            record.wanted, record.score, record.reasons = "cloud", 1.0, (reason,)
            self._publish_homes()
            raise Unavailable(f"{node} stays in the cloud: {reason}")

    def _give_node(self, message: Message) -> Message:
        report = expect(message, GiveNodeRequest)
        record = self._record(report.node)
        if record.lease is None or record.lease.number == report.lease:
            state = _checked(report.state)
            if record.lease is not None and state:
                record.lease.state = state
                record.lease.unheard.heard(report.heard)
                self.logs.change(report.node, change_of(report.log, report.obsolete))
            self._take_back(report.node, report.failure[:200])
        return self._home_of(report.node)

    @staticmethod
    def _probe_link(message: Message) -> Message:
        size = expect(message, ProbeLinkRequest).bytes
        if not 0 <= size <= MAX_PROBE:
            raise InvalidInput(f"a probe has up to {MAX_PROBE} bytes, not {size}")
        return ProbeLinkResponse("0" * size)

    def lacks(self, node: str, topic: str) -> bool:
        """Return whether the robot runs a node, or may, and has not confirmed the last message on a latched topic."""
        record = self._record(node)
        return record.adrift if record.lease is None else record.lease.unheard.has(topic)

    def _record(self, node: str) -> HomeRecord:
        if node not in self._records:
            raise NotFound("node", node, list(self._records))
        return self._records[node]

    # -- facts for verdicts --------------------------------------------------------------------------------------------

    def _link_now(self) -> NetworkLink | None:
        rtt = self._round_trips.median
        return self._link if self._link is None or rtt is None else NetworkLink(rtt, self._link.bandwidth)

    def _facts(self, node: str) -> MonitoredNode:
        demands, record = self._switch.nodes(), self._records[node]
        own = demands[node]
        others = [d.compute for n, d in demands.items() if d and n != node and self._records[n].lease is not None]
        recent = 0.0 <= self.context.now() - record.failed < self._parameters.retry_after
        return MonitoredNode(
            node,
            own,
            self._rates.of(own.rates) if own is not None else {},
            cloud_seconds=record.cloud_seconds.median,
            robot_seconds=record.robot_seconds.median,
            taken=sum(others),
            failure=record.failure if recent else "",
        )

    def _home_of(self, node: str) -> NodeHome:
        record = self._records[node]
        return NodeHome(node, record.home, record.wanted, record.score, list(record.reasons))

    def _homes(self) -> NodeHomes:
        return NodeHomes([self._home_of(node) for node in self._records])

    def _publish_homes(self) -> None:
        self.context.publish(NODE_HOMES.name, self._homes())

    # -- expired leases ------------------------------------------------------------------------------------------------

    def _check_leases(self) -> None:
        now = self.context.elapsed()
        self._rates.look(now)
        for node, seconds in self._switch.run_times().items():
            if node in self._records:
                self._records[node].cloud_seconds.note(seconds)
        for node, record in self._records.items():
            if record.lease is not None and now - record.lease.heard > self._parameters.patience:
                record.adrift = True
                self._take_back(node, f"the robot did not renew its lease for {self._parameters.patience:g} s")

    def recall(self, reason: str) -> None:
        """Continue all nodes that run on the robot here, from their last checkpoints, as after a lost lease.

        Their wanted home stays, so the robot takes them again, built from the current map.
        """
        for node, record in self._records.items():
            if record.lease is not None:
                lease, record.lease = record.lease, None
                logger.info("%s continues in the cloud until the robot takes it again: %s", node, reason)
                self._put_in(node, lease)
        self._publish_homes()

    def keep_here(self, reason: str) -> None:
        """Run all nodes in the cloud for a reason; without one, let the robot take again those that it ran before."""
        if reason:
            self.recall(reason)
            held = {node for node, record in self._records.items() if record.wanted == "robot"}
            self._kept = reason, self._kept[1] | held
        else:
            held, self._kept = self._kept[1], ("", set())
        for node in held:
            self._records[node].wanted = "cloud" if reason else "robot"
            self._records[node].reasons = (reason or "the reason why it was kept in the cloud has ended",)
        self._publish_homes()

    def _take_back(self, node: str, failure: str) -> None:
        record = self._records[node]
        lease, record.lease = record.lease, None
        wanted, record.wanted = record.wanted, "cloud"
        if wanted == "robot":
            record.score, record.reasons = 1.0, ("the robot gave it back",)
        if failure:
            record.failure, record.failed = failure, self.context.now()
            record.score, record.reasons = 1.0, (f"it could not be run on the robot: {failure}",)
            logger.warning("%s continues in the cloud: %s", node, failure)
        if lease is not None:
            self._put_in(node, lease)
        self._publish_homes()

    def _put_in(self, node: str, lease: GrantedLease) -> None:
        try:
            self._switch.put_in(node, lease.state, self.logs.end(node))
        except PPaaSError as error:
            logger.warning("%s starts anew in the cloud, since its state cannot be restored: %s", node, error)
        for message in lease.unheard.all():
            try:
                self._switch.tell(node, message)
            except PPaaSError as error:
                logger.warning("%s rejects a message on %s that arrived while it moved: %s", node, message.topic, error)

    # -- checkpoints ---------------------------------------------------------------------------------------------------

    def checkpoint(self) -> bytes:
        """Return the records of all nodes, with the last states of those that the robot runs."""
        state = MonitorState(self._robot, self._link, self._round_trips, self._leases, self._records)
        return msgspec.json.encode(state)

    def restore(self, state: bytes) -> None:
        """Restore the records; leased nodes leave the graph, and the robot has ``patience`` seconds to renew."""
        restored = from_json(state, MonitorState)
        self._robot, self._link = restored.robot, restored.link
        self._round_trips, self._leases = restored.round_trips, restored.leases
        for node in self._records.keys() & restored.records.keys():
            record = self._records[node] = restored.records[node]
            if record.lease is not None:
                record.lease.heard = self.context.elapsed()
                self.logs.load(node, ())
                self._switch.take_out(node, record.lease.unheard.note)
        self._publish_homes()

    def carry_over(self, state: bytes) -> None:
        """Restore the records; nodes that the robot runs on another map begin here, until it takes them again."""
        restored = from_json(state, MonitorState)
        for record in restored.records.values():
            record.lease = None
        self.restore(msgspec.json.encode(restored))


def _checked(state: str) -> str:
    if len(state) > MAX_STATE:
        raise InvalidInput(f"the state of a node may have {MAX_STATE} characters, not {len(state)}")
    return state
