"""A robot that is watched by the node ``diagnostics``, with messages that a test sends."""

import math
from collections.abc import Callable

import msgspec

from ppaas.clock import ManualClock
from ppaas.diagnosis.diagnose import diagnose
from ppaas.diagnosis.observations.facts import LinkFacts, Observations, PlaceFacts, TopicFacts
from ppaas.diagnosis.observations.place import WatchedRobot
from ppaas.diagnosis.observations.topic_table import TrafficCounter
from ppaas.diagnosis.rules.finding import Finding
from ppaas.errors import PPaaSError
from ppaas.geometry import Pose2D
from ppaas.messages import encode
from ppaas.messages.base.message import Message
from ppaas.messages.base.std_msgs import Header, String, Time
from ppaas.messages.geometry_msgs import Pose, PoseWithCovariance, Twist, TwistWithCovariance
from ppaas.messages.health.watching import ObserveRequest, ObserveResponse
from ppaas.messages.nav_msgs import Odometry
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.nodes.base import Node
from ppaas.nodes.diagnostics.node import DiagnosticsNode
from ppaas.nodes.graph import Graph
from ppaas.nodes.tf.state_publisher import StatePublisherNode, StatePublisherParameters
from ppaas.nodes.topics import AMCL_STATUS, CMD_VEL, MOVE_BASE_STATUS, SCAN
from ppaas.robot_model.known_models import robot_model

EPOCH = 1_700_000_000.0
"""Time since the epoch at which the clock of a test is 0 [s]."""

LINK = LinkFacts(robots=1, operators=0, round_trip=0.004, connects=1, subscribed=("cmd_vel",))
"""Connection of a robot with which nothing is wrong."""


PLACE = PlaceFacts(
    pose=(1.0, 2.0, 0.0), silence=0.1, deviation=0.05, turn_deviation=0.02, explained=0.95, cell="free", clearance=0.8,
    radius=0.2,
)  # fmt: skip
"""Localization of a robot with which nothing is wrong."""


def healthy(**changed: object) -> Observations:
    """Return the observations of a robot with which nothing is wrong, except for what is changed."""
    topics = [
        TopicFacts(name="scan", count=100, rate=10.0, bandwidth=2e4, size=2e3, silence=0.05, gap=0.12, late=0.03),
        TopicFacts(name="odom", count=200, rate=20.0, bandwidth=1e4, size=5e2, silence=0.02, gap=0.06, late=0.02),
    ]
    return msgspec.structs.replace(Observations(seconds=5.0, topics=topics, link=LINK, place=PLACE), **changed)


def with_topic(name: str, **changed: object) -> Observations:
    """Return the observations of a healthy robot, one topic of which is changed."""
    seen = healthy()
    others = [topic for topic in seen.topics if topic.name != name]
    seen.topics = [*others, msgspec.structs.replace(seen.topic(name), **changed)]
    return seen


def kinds(findings: list[Finding]) -> list[str]:
    """Return the kinds of the findings that are no notes."""
    return [finding.kind for finding in findings if finding.level != "ok"]


class OtherTopics(Node):
    """Has the topics of localization and Move Base, which a test publishes."""

    name = "others"
    subscribes = (SCAN,)
    publishes = (CMD_VEL, AMCL_STATUS, MOVE_BASE_STATUS)


class DiagnosedRobot:
    """A graph with the robot's frames and the node that watches it."""

    def __init__(self, robot: WatchedRobot | None = None) -> None:
        self.clock = ManualClock()
        self.graph = Graph(clock=self.clock, stamp_clock=lambda: EPOCH + self.clock())
        self.traffic = TrafficCounter()
        body = robot_model("turtlebot3_burger")
        self.graph.add(lambda context: StatePublisherNode(context, body, StatePublisherParameters("")))
        self.graph.add(OtherTopics)
        self.node = self.graph.add(
            lambda context: DiagnosticsNode(context, self.graph, self.traffic, robot or WatchedRobot())
        )

    def send(self, topic: str, message: Message, sender: int = 1) -> None:
        """Deliver a message of a client, as a container does."""
        self.traffic.note(topic, len(encode(message)), sender, self.clock())
        try:
            self.graph.inject(topic, message)
        except PPaaSError as error:
            self.traffic.refuse(topic, str(error), self.clock())

    def ask(self, seconds: float = 0.0) -> list[Observations]:
        """Call the service; return the list to which its answer is added, now or later."""
        answers: list[Observations] = []

        def answered(answer: object) -> None:
            assert isinstance(answer, ObserveResponse), answer
            answers.append(msgspec.json.decode(answer.observations, type=Observations))

        self.graph.call("diagnostics/observe", ObserveRequest(seconds), answered)
        return answers

    def run(self, seconds: float, sends: Callable[["DiagnosedRobot", int], None], period: float = 0.05) -> None:
        """Let time pass, and send what a robot sends in each period."""
        for number in range(round(seconds / period)):
            self.clock.advance(period)
            self.graph.run_due()
            sends(self, number)

    def findings(self, sends: Callable[["DiagnosedRobot", int], None], seconds: float = 4.0) -> list[Finding]:
        """Return the findings about a robot that sends messages for a time [s], as if it were well connected."""
        answers = self.ask(seconds)
        self.run(seconds + 0.1, sends)
        [seen] = answers
        seen.link = LINK
        return diagnose(seen)

    @property
    def stamp(self) -> Time:
        """The time now."""
        return Time.of(EPOCH + self.clock())

    def scan(self, frame: str = "base_scan", late: float = 0.0, **changed: object) -> LaserScan:
        """Return a scan of 180 beams, all of 2 m, stamped some time ago [s]."""
        header = Header(stamp=Time.of(EPOCH + self.clock() - late), frame_id=frame)
        step = 2.0 * math.pi / 180
        scan = LaserScan(header, -math.pi, math.pi - step, step, 0.12, 8.0, [2.0] * 180)
        return msgspec.structs.replace(scan, **changed)

    def odometry(self, pose: Pose2D = Pose2D(0.0, 0.0, 0.0), child: str = "base_link", late: float = 0.0) -> Odometry:
        """Return a message of the odometry, stamped some time ago [s]."""
        header = Header(stamp=Time.of(EPOCH + self.clock() - late), frame_id="odom")
        return Odometry(header, child, PoseWithCovariance(Pose.of(pose)), TwistWithCovariance(Twist()))

    def well(self, number: int) -> None:
        """Send what a healthy robot sends: odometry at 20 Hz, and scans at 10 Hz."""
        self.send("odom", self.odometry())
        if number % 2:
            self.send("scan", self.scan())
            self.graph.publish("amcl/status", String(""))
