"""The part of a graph that is one robot: its namespace, and the topics that it publishes and subscribes to."""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from ppaas.errors import NotFound
from ppaas.wire.ros.graph import Entity, Kind
from robots.bridges.core.tables import ODOMETRY, SCAN, UpTopic

TWIST, TWIST_STAMPED = "geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped"
TF_MESSAGE = "tf2_msgs/msg/TFMessage"

UNTYPED = ("", "*")
"""Types of subscribers that take any message, such as ROS 1's ``topic_tools``: its master knows none, or ``*``."""


@dataclass(frozen=True, slots=True)
class PublishedTopic:
    """Topic of the robot: its full name, and its publishers."""

    topic: str
    publishers: tuple[Entity, ...]

    @property
    def latched(self) -> bool:
        """Whether all publishers keep messages for late subscribers."""
        return all(publisher.qos.latched for publisher in self.publishers)

    def same_as(self, other: "PublishedTopic") -> bool:
        """Return whether a subscription to one serves the other."""
        return (self.topic, self.latched) == (other.topic, other.latched)


class RobotGraph:
    """Entities of one robot, and of other nodes beside it.

    Parameters
    ----------
    entities : sequence of Entity
        All entities but the bridge's.
    namespace : str
        Namespace of the robot: empty, or a name with a leading slash.
    """

    def __init__(self, entities: Sequence[Entity], namespace: str) -> None:
        self.entities, self.namespace = entities, namespace

    def full(self, name: str) -> str:
        """Return the full name of a topic, a service or an action in the robot's namespace."""
        return f"{self.namespace}/{name}"

    def source(self, topic: UpTopic) -> PublishedTopic | None:
        """Return the topic by which the robot publishes what a topic of the cloud wants; None if there is none."""
        of_type = self._publishers(topic.type)
        for name in topic.names:
            if self.full(name) in of_type:
                return PublishedTopic(self.full(name), tuple(of_type[self.full(name)]))
        inside = [name for name in of_type if name.startswith(f"{self.namespace}/")]
        if topic.only and len(inside) == 1:
            return PublishedTopic(inside[0], tuple(of_type[inside[0]]))
        return None

    def transforms(self, name: str) -> PublishedTopic | None:
        """Return the topic ``tf`` or ``tf_static`` of the robot: in its namespace, else in the root."""
        of_type = self._publishers(TF_MESSAGE)
        for topic in (self.full(name), f"/{name}"):
            if topic in of_type:
                return PublishedTopic(topic, tuple(of_type[topic]))
        return None

    def tf_topic(self) -> str:
        """Return the topic on which the robot expects transforms."""
        source = self.transforms("tf")
        if source:
            return source.topic
        wanted_at_root = self.subscribers("/tf") and not self.subscribers(self.full("tf"))
        return "/tf" if wanted_at_root else self.full("tf")

    def velocity_topics(self) -> dict[str, set[str]]:
        """Return the topics on which bases expect velocities, with their types.

        The preferred name is ``cmd_vel``: its subscriber decides what reaches the base, as a mux does that a joystick
        or a stop may switch. In ROS 1 a topic that only such relays subscribe to has no type; velocities are Twist
        then, as ``move_base`` publishes them. Without a subscriber of that name, the only topic that a base subscribes
        to is taken, such as ``diff_drive_controller/cmd_vel``.
        """
        found: dict[str, set[str]] = {}
        for entity in self.entities:
            if entity.kind is Kind.SUBSCRIBER and entity.type in (TWIST, TWIST_STAMPED):
                found.setdefault(entity.name, set()).add(entity.type)
        preferred = self.full("cmd_vel")
        if preferred in found:
            return {preferred: found[preferred]}
        if subscribers := self.of(Kind.SUBSCRIBER, preferred):
            return {preferred: {TWIST}} if any(one.type in UNTYPED for one in subscribers) else {}
        inside = {name: types for name, types in found.items() if name.startswith(f"{self.namespace}/")}
        return inside if len(inside) == 1 else {}

    def of(self, kind: Kind, topic: str, type_name: str = "") -> list[Entity]:
        """Return the entities of a topic, given its full name; only of one type if one is named."""
        return [one for one in self.entities if one.kind is kind and one.name == topic and type_name in ("", one.type)]

    def subscribers(self, topic: str) -> frozenset[str]:
        """Return the ids of the subscribers of a topic."""
        return frozenset(one.id for one in self.of(Kind.SUBSCRIBER, topic))

    def _publishers(self, type_name: str) -> dict[str, list[Entity]]:
        found: dict[str, list[Entity]] = {}
        for entity in self.entities:
            if entity.kind is Kind.PUBLISHER and entity.type == type_name:
                found.setdefault(entity.name, []).append(entity)
        return found


def find_namespace(entities: Iterable[Entity], robot: str) -> str | None:
    """Return the namespace of the robot in a graph: the one of its odometry or scan; None if there is none yet.

    Parameters
    ----------
    entities : iterable of Entity
        All entities but the bridge's.
    robot : str
        Id of the robot, whose namespace is preferred if there are several.

    Raises
    ------
    NotFound
        Several robots are there, and none of them has the name of this one.
    """
    found = find_namespaces(entities)
    own = f"/{name_in_graph(robot)}"
    if own in found:
        return own
    if len(found) > 1:
        raise NotFound("namespace of robot", robot, sorted(namespace or "/" for namespace in found))
    return found.pop() if found else None


def name_in_graph(robot: str) -> str:
    """Return the id of a robot as a name of ROS, which has letters, digits and ``_`` alone."""
    return re.sub("[^A-Za-z0-9_]", "_", robot)


def find_namespaces(entities: Iterable[Entity]) -> set[str]:
    """Return the namespaces of the robots in a graph, as ``find_namespace`` does: the ones of odometry and scans."""
    found = set()
    for entity in entities:
        for topic in (ODOMETRY, SCAN):
            if entity.kind is Kind.PUBLISHER and entity.type == topic.type:
                names = [name for name in topic.names if entity.name.endswith(f"/{name}")]
                found.add(entity.name.removesuffix(f"/{names[0]}") if names else "")
    return found
