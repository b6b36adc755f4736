"""Node ``diagnostics``: watches what a robot sends while somebody asks, and publishes findings on ``diagnostics``."""

from collections.abc import Callable
from typing import ClassVar, Protocol

from ppaas.bounded import BoundedDict
from ppaas.diagnosis.diagnose import diagnose
from ppaas.diagnosis.observations.facts import Observations, ReportFacts, observations_to_json
from ppaas.diagnosis.observations.place import WatchedRobot
from ppaas.diagnosis.observations.recorder import HEARD, ObservationRecorder
from ppaas.diagnosis.observations.topic_table import TopicTable, TrafficCounter
from ppaas.diagnosis.rules.finding import LEVELS, Finding
from ppaas.errors import InvalidInput
from ppaas.messages import type_name
from ppaas.messages.base.message import Message
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.health.diagnostic_msgs import DiagnosticArray, DiagnosticStatus, KeyValue
from ppaas.messages.health.watching import Observe, ObserveRequest, ObserveResponse
from ppaas.nodes import topics
from ppaas.nodes.base import Context, Node, Payload, Reply, Service, Timer, Topic
from ppaas.nodes.message_checks import expect

PERIOD = 1.0
"""Period of the messages on ``diagnostics`` [s]."""

IDLE = 30.0
"""Time after the last question after which the robot is no longer watched [s]."""

LONGEST = 8.0
"""Longest time for which a question waits [s]."""

MOST_REPORTS = 100
"""Largest number of statuses of the robot's programs that are kept."""

REPORT_AGE = 10.0
"""Time for which a status of a program counts [s]; they are repeated every second."""

MOST_TEXT = 200
"""Length of the name and the text of a status that is kept [characters]."""

_OWN = "ppaas: "
"""Prefix of the names of the statuses of the cloud, which tells them from those of the robot's programs."""


class TappedBus(Protocol):
    """Topics of the executor, as the node taps them."""

    topics: dict[str, Topic]

    def has_taps(self, topic: str) -> bool:
        """Return whether a topic has subscribers outside the graph."""
        ...

    def tap(self, topic: str, callback: Callable[[str, Payload], None]) -> Callable[[], None]:
        """Subscribe to a topic; returns a function that unsubscribes."""
        ...


class DiagnosticsNode(Node):
    """Watches a robot while a client subscribes to ``diagnostics``, or within `IDLE` seconds after ``observe``.

    As long as nobody looks, it hears no topic but ``diagnostics``, on which programs of the robot publish, too.

    Parameters
    ----------
    context : Context
        The node's context.
    bus : TappedBus
        Topics of the executor; the node hears references of messages, after the nodes that use them.
    traffic : TrafficCounter
        Counts of the messages that the container receives.
    robot : WatchedRobot
    """

    name: ClassVar[str] = "diagnostics"
    subscribes: ClassVar[tuple[Topic, ...]] = (topics.DIAGNOSTICS,)
    publishes: ClassVar[tuple[Topic, ...]] = (topics.DIAGNOSTICS,)
    services: ClassVar[tuple[Service, ...]] = (Service("diagnostics/observe", Observe),)

    def __init__(self, context: Context, bus: TappedBus, traffic: TrafficCounter, robot: WatchedRobot) -> None:
        super().__init__(context)
        self._bus, self._traffic, self._robot = bus, traffic, robot
        self._recorder: ObservationRecorder | None = None
        self._table = TopicTable(traffic, 0.0)
        self._untap: list[Callable[[], None]] = []
        self._asked = float("-inf")
        self._reports: BoundedDict[str, tuple[float, ReportFacts]] = BoundedDict(MOST_REPORTS)

    @property
    def watches(self) -> bool:
        """Whether the robot is watched now."""
        return self._recorder is not None

    def start(self) -> None:
        """Start to look once a second whether somebody subscribes."""
        self.context.every(PERIOD, self._tick)

    def on_message(self, topic: str, message: Payload) -> None:
        """Note what programs of the robot report.

        Raises
        ------
        InvalidInput
            The message is not a ``diagnostic_msgs/DiagnosticArray``.
        """
        now = self.context.elapsed()
        for status in expect(message, DiagnosticArray).status:
            if not status.name.startswith(_OWN):
                name, text = status.name[:MOST_TEXT], status.message[:MOST_TEXT]
                self._reports[name] = now, ReportFacts(name=name, level=status.level, text=text)

    def on_call(self, service: str, request: Message, reply: Reply) -> None:
        """Answer what was observed, once the robot has been watched for the requested time.

        Raises
        ------
        InvalidInput
            The time is not from 0 to `LONGEST`.
        """
        seconds = expect(request, ObserveRequest).seconds
        if not 0.0 <= seconds <= LONGEST:
            raise InvalidInput(f"a robot is watched for 0 to {LONGEST:g} s before the answer, not {seconds:g}")
        self._asked = self.context.elapsed()
        recorder = self._watch()
        left = seconds - (self._asked - recorder.since)
        if left <= 0.0:
            reply(self._response())
            return
        timer: Timer

        def answer() -> None:
            timer.stop()
            reply(self._response())

        timer = self.context.every(left, answer)

    # -- watching ------------------------------------------------------------------------------------------------------

    def _watch(self) -> ObservationRecorder:
        """Return the recorder, which begins to hear the robot's topics if it does not yet."""
        if self._recorder is None:
            now = self.context.elapsed()
            self._recorder, self._table = ObservationRecorder(now), TopicTable(self._traffic, now)
            for topic in HEARD:
                if topic.name in self._bus.topics:
                    self._untap.append(self._bus.tap(topic.name, self._heard))
        return self._recorder

    def _heard(self, topic: str, message: Payload) -> None:
        if self._recorder is not None:
            self._recorder.take(topic, message, self.context.elapsed(), self.context.now())

    def _tick(self) -> None:
        now, subscribed = self.context.elapsed(), self._bus.has_taps(topics.DIAGNOSTICS.name)
        if subscribed:
            self._watch()
        elif self._recorder is not None and now - self._asked > IDLE:
            self._stop()
        if self._recorder is None:
            return
        self._table.look(now)
        if subscribed:
            self._publish()

    def _stop(self) -> None:
        for untap in self._untap:
            untap()
        self._untap, self._recorder = [], None

    def observations(self) -> Observations:
        """Return what was observed since the robot is watched."""
        recorder, now = self._watch(), self.context.elapsed()
        seen = recorder.observations(now, self._robot)
        types = {name: type_name(topic.type) for name, topic in self._bus.topics.items()}
        seen.topics = self._table.facts(now, recorder.arrivals, types)
        seen.reports = [report for at, report in self._reports.values() if now - at <= REPORT_AGE]
        return seen

    def _response(self) -> ObserveResponse:
        return ObserveResponse(observations_to_json(self.observations()))

    def _publish(self) -> None:
        findings = _statuses_of(diagnose(self.observations()))
        header = Header(stamp=Time.of(self.context.now()))
        self.context.publish(topics.DIAGNOSTICS.name, DiagnosticArray(header, findings))


def _statuses_of(findings: list[Finding]) -> list[DiagnosticStatus]:
    """Return the status of each finding; one that says that all is well if there is none."""
    if not findings:
        return [DiagnosticStatus(0, f"{_OWN}robot", "Everything that the cloud checks is in order.")]
    return [
        DiagnosticStatus(LEVELS.index(each.level), f"{_OWN}{each.kind}", each.text, values=_values(each))
        for each in findings
    ]


def _values(finding: Finding) -> list[KeyValue]:
    named = {"advice": finding.advice, "topic": finding.topic}
    return [KeyValue(key, value) for key, value in named.items() if value]
