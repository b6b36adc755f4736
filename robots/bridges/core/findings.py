"""Faults of a robot's graph, in words: missing topics, types and qualities of service that do not match.

The graph is examined once a second; the log and ``ppaas doctor`` name its faults. Findings are published on
``diagnostics``, which the doctor repeats for some seconds after each message.
"""

import asyncio
from collections.abc import Awaitable, Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

from ppaas.wire.ros import RosTypes
from ppaas.wire.ros.graph import Entity, Kind, Qos
from ppaas.wire.ros.types import to_json
from robots.bridges.core.parts import BridgeParts
from robots.bridges.core.robot_graph import TF_MESSAGE, UNTYPED, RobotGraph, find_namespaces
from robots.bridges.core.tables import ODOMETRY, SCAN, Tables, UpTopic

WARN, ERROR = 1, 2
"""Levels of ``diagnostic_msgs/DiagnosticStatus``."""

VELOCITY = Qos(depth=1)
"""Quality of service of velocities."""


@dataclass(frozen=True, slots=True)
class GraphFault:
    """Fault of a robot's graph: the topic or other subject of it, its text, and its level."""

    subject: str
    text: str
    level: int = WARN


@dataclass(frozen=True, slots=True)
class OfferedTopic:
    """Topic that the bridge publishes."""

    topic: str
    type: str
    qos: Qos


def examine(graph: RobotGraph, types: RosTypes, tables: Tables, *, qos_matters: bool = True) -> list[GraphFault]:
    """Return the faults of the graph of a robot.

    Parameters
    ----------
    graph : RobotGraph
        The robot.
    types : RosTypes
        Types of its release of ROS.
    tables : Tables
        What the bridge carries.
    qos_matters : bool
        Whether the transport connects only publishers and subscribers whose qualities of service match.
    """
    offers = [OfferedTopic(graph.full(topic.name), topic.type, topic.qos) for topic in tables.down]
    velocities = graph.velocity_topics()
    offers += [OfferedTopic(topic, kind, VELOCITY) for topic, kinds in velocities.items() for kind in kinds]
    found = [*_missing(graph), *_base(graph, velocities), *_carried(graph, types, tables)]
    if not types.ros1:
        found += _static(graph)
    for offer in offers:
        wanted = velocities.get(offer.topic, {offer.type})
        found += _subscribers(graph.of(Kind.SUBSCRIBER, offer.topic), offer, wanted, qos_matters=qos_matters)
        found += _hashes(offer.topic, graph.of(Kind.SUBSCRIBER, offer.topic, offer.type), types, offer.type)
    return found


# -- topics of the robot -----------------------------------------------------------------------------------------------


def _missing(graph: RobotGraph) -> Iterator[GraphFault]:
    for topic in (ODOMETRY, SCAN):
        if graph.source(topic) is None:
            yield GraphFault(topic.cloud, f"{_why(graph, topic)}: the clone cannot localize it", ERROR)


def _why(graph: RobotGraph, topic: UpTopic) -> str:
    others = {one.type for name in topic.names for one in graph.of(Kind.PUBLISHER, graph.full(name))}
    if others:
        return f"the robot publishes {graph.full(topic.cloud)!r} as {', '.join(sorted(others))}, not as {topic.type}"
    named = sorted({one.name for one in graph.entities if one.kind is Kind.PUBLISHER and one.type == topic.type})
    inside = [name for name in named if name.startswith(f"{graph.namespace}/")]
    if len(inside) > 1:
        return f"the robot publishes {topic.type} on {', '.join(inside)}; none of them is {topic.cloud!r}"
    if named:
        spaces = sorted(namespace or "/" for namespace in find_namespaces(graph.entities))
        return (
            f"the robot does not publish {topic.cloud!r} in namespace {graph.namespace or '/'}, but "
            f"{', '.join(named)} (--namespace; known: {', '.join(spaces)})"
        )
    return f"the robot does not publish {topic.cloud!r}"


def _base(graph: RobotGraph, velocities: dict[str, set[str]]) -> Iterator[GraphFault]:
    if velocities:
        return
    others = sorted({one.type for one in graph.of(Kind.SUBSCRIBER, graph.full("cmd_vel"))})
    reason = f"; 'cmd_vel' is subscribed to as {', '.join(others)}" if others else ""
    yield GraphFault("cmd_vel", f"no base subscribes to 'cmd_vel'{reason}: the robot will not move", ERROR)


def _static(graph: RobotGraph) -> Iterator[GraphFault]:
    source = graph.transforms("tf_static")
    if source is not None and not source.latched:
        text = f"{source.topic} is not transient local: transforms that were published before the bridge came are lost"
        yield GraphFault("tf_static", text)


def _carried(graph: RobotGraph, types: RosTypes, tables: Tables) -> Iterator[GraphFault]:
    sources = [(topic.type, graph.source(topic)) for topic in tables.up]
    sources += [(TF_MESSAGE, graph.transforms(name)) for name in ("tf", "tf_static")]
    for type_name, source in sources:
        if source is not None:
            yield from _hashes(source.topic, source.publishers, types, type_name)


# -- ends that do not match --------------------------------------------------------------------------------------------


def _hashes(topic: str, ends: Iterable[Entity], types: RosTypes, type_name: str) -> Iterator[GraphFault]:
    stated = [one for one in ends if one.type_hash]
    if not stated or not types.knows(type_name):
        return
    known = types.type_hash(type_name)
    differ = {one.node or f"a {one.kind.value}" for one in stated if one.type_hash != known}
    if differ:
        nodes = ", ".join(sorted(differ))
        text = (
            f"{nodes} has another definition of {type_name} on {topic} than ROS 2 {types.release}: "
            "name the robot's release by --distro"
        )
        yield GraphFault(topic, text, ERROR)


def _subscribers(
    subscribers: Sequence[Entity], offer: OfferedTopic, types: set[str], *, qos_matters: bool
) -> Iterator[GraphFault]:
    for one in subscribers:
        if one.type in UNTYPED:
            continue
        node = one.node or "a node"
        if one.type not in types:
            yield GraphFault(offer.topic, f"{node} subscribes to {offer.topic} as {one.type}, not as {offer.type}")
        elif one.type == offer.type and qos_matters and (lacks := _lacks(offer.qos, one.qos)):
            yield GraphFault(
                offer.topic,
                f"{node} gets nothing of {offer.topic}: it requests {lacks}, which the bridge does not offer there",
                ERROR if offer.qos is VELOCITY else WARN,
            )


def _lacks(offered: Qos, requested: Qos) -> str:
    lacks = ["'reliable'"] if requested.reliable and not offered.reliable else []
    lacks += ["'transient local'"] if requested.latched and not offered.latched else []
    return " and ".join(lacks)


# -- examination of the robot's graph once a second --------------------------------------------------------------------

MISSING_AFTER = 5.0
"""Time that a robot has to show its topics before it is examined [s]."""

PERIOD = 1.0
"""Time between two examinations [s]."""

RECENT = 5.0
"""Time for which a warning about a single event is repeated [s]."""

MOST = 32
"""Largest number of findings that are published."""

TOPIC = "diagnostics"
NAME = "bridge"


class GraphExamination:
    """Logs and publishes the faults of the robot's graph.

    Parameters
    ----------
    parts : BridgeParts
        Ends of the bridge.
    look : callable
        Returns the faults that are there now.
    """

    def __init__(self, parts: BridgeParts, look: Callable[[], Awaitable[Sequence[GraphFault]]]) -> None:
        self._parts, self._look = parts, look
        self._published: dict[str, GraphFault] = {}

    async def run(self) -> None:
        """Examine until cancelled."""
        await asyncio.sleep(MISSING_AFTER)
        while True:
            found = await self._look()
            for finding in found:
                self._parts.notices.tell(finding.text)
            self._publish([*found, *self._warnings()][:MOST])
            await asyncio.sleep(PERIOD)

    def _warnings(self) -> list[GraphFault]:
        texts = self._parts.notices.recent(self._parts.clock() - RECENT)
        return [GraphFault(f"warning {number}", text) for number, text in enumerate(texts, 1)]

    def _publish(self, found: Sequence[GraphFault]) -> None:
        """Publish findings, and once more those that are gone, as healthy."""
        now: dict[str, GraphFault] = {}
        for finding in found:
            before = now.get(finding.subject)
            text = f"{before.text}; {finding.text}" if before else finding.text
            now[finding.subject] = GraphFault(
                finding.subject, text, max(finding.level, before.level if before else WARN)
            )
        gone = [GraphFault(subject, "", 0) for subject in self._published.keys() - now.keys()]
        self._published = now
        if statuses := [*now.values(), *gone]:
            array = [{"level": one.level, "name": f"{NAME}: {one.subject}", "message": one.text} for one in statuses]
            self._parts.link.publish_newest(TOPIC, to_json({"status": array}))
