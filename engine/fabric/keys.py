"""Key expressions of the fabric, and the keys of one container.

::

    ppaas/map/<map>/<user>/<robot>/<topic>    topics that a robot shares with all robots of its map
    ppaas/map/<map>/<user>/_traffic/<topic>/<robot>    topics of a traffic node for one robot

The people coordinator and the traffic node of a user's robots on a map have the place of a robot in keys, under names
that no robot has: `COORDINATOR` and `TRAFFIC_NODE`. They receive what the robots of their user share. These robots
receive what the coordinator shares, and each of them what the traffic node addresses to it.

Names of users, robots and maps may contain any characters; those that a key must not contain are written as
``%xx``. Topics are ROS graph names. Only the agent of a machine uses the fabric. A container names topics, never keys:
the agent makes its keys from its ``Scope``.
"""

from dataclasses import dataclass
from typing import NamedTuple
from urllib.parse import quote, unquote

from ppaas.errors import InvalidParameter, MalformedMessage, NotPermitted
from ppaas.wire.names import normalise

ROOT = "ppaas"
SHARED = "map"

COORDINATOR = "_coordinator"
"""Name of people coordinators in keys; names of robots begin with a letter or a digit."""

TRAFFIC_NODE = "_traffic"
"""Name of traffic nodes in keys."""

_SPECIAL = frozenset("*$?#")


class SharedKey(NamedTuple):
    """The parts of the key of a shared topic."""

    map: str
    user: str
    robot: str
    topic: str

    def topic_for(self, robot: str) -> str:
        """Return the topic as a robot receives it: without the robot's name, if the key is addressed to it."""
        return self.topic.removesuffix(f"/{chunk(robot)}") if self.robot == TRAFFIC_NODE else self.topic


def chunk(name: str) -> str:
    """Return a name as one chunk of a key.

    Raises
    ------
    InvalidParameter
        The name is empty.
    """
    if not name:
        raise InvalidParameter("names in keys of the fabric must not be empty")
    return quote(name, safe="") if name.strip(".") else name.replace(".", "%2E")


def shared_key(map_id: str, user: str, robot: str, topic: str) -> str:
    """Return the key of a topic that a robot shares with the robots of its map."""
    return "/".join((ROOT, SHARED, chunk(map_id), chunk(user), chunk(robot), _topic(topic)))


def addressed_key(map_id: str, user: str, topic: str, robot: str) -> str:
    """Return the key of a topic that the traffic node of a user's robots on a map publishes for one of them."""
    return f"{shared_key(map_id, user, TRAFFIC_NODE, topic)}/{chunk(robot)}"


def shared_by_all(map_id: str, topic: str) -> str:
    """Return the key expression of a topic that all robots of a map share."""
    return "/".join((ROOT, SHARED, chunk(map_id), "*", "*", _topic(topic)))


def shared_by_user(map_id: str, user: str, topic: str) -> str:
    """Return the key expression of a topic that the robots of one user share on a map."""
    return "/".join((ROOT, SHARED, chunk(map_id), chunk(user), "*", _topic(topic)))


def parse_shared(key: str) -> SharedKey:
    """Read the key of a shared topic.

    Raises
    ------
    InvalidParameter
        It is not the key of a shared topic.
    """
    root, _, rest = key.partition(f"/{SHARED}/")
    parts = rest.split("/", 3)
    if root != ROOT or len(parts) != 4 or not all(parts):
        raise InvalidParameter(f"{key!r} is not the key of a shared topic")
    map_id, user, robot, topic = parts
    return SharedKey(unquote(map_id), unquote(user), unquote(robot), topic)


def _topic(name: str) -> str:
    if _SPECIAL.intersection(name) or ".." in name.split("/"):
        raise NotPermitted(f"the topic name {name!r} must not contain wildcards or '..'")
    try:
        return normalise(name).replace("~", "%7E")
    except MalformedMessage as error:
        raise InvalidParameter(str(error)) from error


@dataclass(frozen=True, slots=True)
class Scope:
    """Who a container is on the fabric, from which its keys are made.

    Parameters
    ----------
    user, robot : str
        User and robot of the container.
    map : str
        Map of the robot.
    """

    user: str
    robot: str
    map: str

    def shared_key(self, topic: str) -> str:
        """Return the key of a topic that this robot shares with the robots of its map."""
        return shared_key(self.map, self.user, self.robot, topic)

    def addressed_key(self, topic: str, robot: str) -> str:
        """Return the key of a topic that this traffic node publishes for one robot of its user on its map.

        Raises
        ------
        NotPermitted
            It is the scope of a robot or a coordinator.
        """
        if self.robot != TRAFFIC_NODE:
            raise NotPermitted(f"{self.robot!r} of user {self.user!r} may not address a robot: only a traffic node may")
        return addressed_key(self.map, self.user, topic, robot)

    def shared_pattern(self, topic: str) -> str:
        """Return the key expression of a topic of all robots of its map, including itself."""
        return shared_by_all(self.map, topic)
