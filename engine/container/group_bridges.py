"""Group bridges: pass reports from clones to the nodes of their groups, and the answers of these to the clones."""

import logging

from engine.container.executor import NodeExecutor
from engine.container.fleet_bridge import RobotIsHere
from engine.container.machine_client import MachineClient
from engine.protocols import machine_link
from engine.specs.containers import GroupNode, Launch
from ppaas.errors import NotPermitted, PPaaSError
from ppaas.messages import decode, encode
from ppaas.messages.base.message import Message
from ppaas.nodes.base import Payload, Topic
from ppaas.nodes.topics import PEOPLE_REPORT, PEOPLE_STATE, TRAFFIC_GRANTS, TRAFFIC_REPORT

logger = logging.getLogger(__name__)

PEOPLE_PERIOD, TRAFFIC_PERIOD = 0.05, 0.02
"""Smallest times between two reports of a robot [s], for traffic shorter than a cycle of Move Base; more frequent ones
are dropped."""


class GroupBridge:
    """Bridge between the graph of a container and its machine link, for one kind of group.

    A clone shares its reports, unless its robot makes a new map, and receives the answers of the group's node. While
    its robot is away it reports nothing, so that the node counts the robot as silent. The node receives the reports,
    and shares the answers: those that name a robot with that one alone. The machine decides which containers receive
    what.

    Parameters
    ----------
    launch : Launch
        Specification of the container.
    home : NodeExecutor
        Executor of the graph, with its nodes.
    machine : MachineClient
        The machine link.
    node : {"people", "traffic"}
        Node of the groups.
    report, answer : Topic
        Topics of the reports of robots, and of the answers of the node.
    report_period : float
        Smallest time between two reports of a robot [s]; more frequent ones are dropped.
    robot_is_here : callable
        Returns whether the robot of the clone is connected.
    """

    def __init__(
        self,
        launch: Launch,
        home: NodeExecutor,
        machine: MachineClient,
        *,
        node: GroupNode,
        report: Topic,
        answer: Topic,
        report_period: float,
        robot_is_here: RobotIsHere,
    ) -> None:
        spec = launch.spec
        self._robot_is_here = robot_is_here
        self._home, self._graph, self._machine = home, home.graph, machine
        self._report, self._answer, self._report_period = report, answer, report_period
        self._heard = report if spec.group_node == node else answer
        self._robot = "" if spec.robot is None else spec.robot.id
        self._last_report = float("-inf")
        self._refused: set[str] = set()
        if spec.group_node == node:
            self._graph.tap(answer.name, self._share_answer)
        elif spec.robot is not None and not spec.maps and report.name in self._graph.topics:
            self._graph.tap(report.name, self._share_report)

    def _share_report(self, topic: str, report: Payload) -> None:
        now = self._graph.elapsed()
        if not self._robot_is_here():
            return
        if now - self._last_report >= self._report_period and isinstance(report, self._report.type):
            self._last_report = now
            self._machine.share(topic, encode(report))

    def _share_answer(self, topic: str, answer: Payload) -> None:
        if isinstance(answer, self._answer.type):
            self._machine.share(topic, encode(answer), _robot_in(answer) or "")

    def hears(self, topic: str) -> bool:
        """Return whether messages of a topic are reports or answers for this container."""
        return topic == self._heard.name and topic in self._graph.topics

    def shared(self, message: machine_link.Shared) -> None:
        """Take a report or an answer; messages of other topics are ignored.

        One that is not valid, or names another robot than the one that it is from or for, is dropped. So is a message
        that a node refuses. The first one of each robot is logged.
        """
        if not self.hears(message.topic):
            return
        try:
            content = decode(self._heard.type, message.payload)
            named = _robot_in(content)
            if named is not None and named != (self._robot or message.robot):
                raise NotPermitted(f"it names robot {named[:64]!r}")
            self._graph.inject(message.topic, content)
        except PPaaSError as error:
            self._log(message, str(error))
        else:
            self._refused.discard(message.robot)
        self._home.attend()

    def _log(self, message: machine_link.Shared, reason: str) -> None:
        level = logging.DEBUG if message.robot in self._refused else logging.WARNING
        logger.log(level, "a message on %s of %s is refused: %s", message.topic, message.robot, reason)
        self._refused.add(message.robot)


def _robot_in(message: Message) -> str | None:
    """Return the robot that a report is from or an answer is for; None if messages of its type name none."""
    robot: str | None = getattr(message, "robot", None)
    return robot


def people_bridge(
    launch: Launch, home: NodeExecutor, machine: MachineClient, robot_is_here: RobotIsHere
) -> GroupBridge:
    """Return the bridge between the clones of robots that see people and their coordinator."""
    topics = {"report": PEOPLE_REPORT, "answer": PEOPLE_STATE}
    return GroupBridge(
        launch, home, machine, node="people", **topics, report_period=PEOPLE_PERIOD, robot_is_here=robot_is_here
    )


def traffic_bridge(
    launch: Launch, home: NodeExecutor, machine: MachineClient, robot_is_here: RobotIsHere
) -> GroupBridge:
    """Return the bridge between the clones of robots that take part in traffic and their traffic node."""
    topics = {"report": TRAFFIC_REPORT, "answer": TRAFFIC_GRANTS}
    return GroupBridge(
        launch, home, machine, node="traffic", **topics, report_period=TRAFFIC_PERIOD, robot_is_here=robot_is_here
    )
