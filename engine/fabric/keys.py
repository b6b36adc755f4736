"""Key expressions of the fabric: how they are made, and which of them a container may use.

::

    ppaas/<user>/<group>/<robot>/<topic>      a robot's own
    ppaas/map/<map>/<user>/<robot>/<topic>    what a robot shows to all robots of its map

Users, groups, robots and maps may be named with any characters: what a key cannot carry is written as ``%xx``.
Topics are ROS graph names. Only the agent of a machine speaks on the fabric; it asks a ``Scope`` before it publishes
or subscribes for a container.
"""

from dataclasses import dataclass
from typing import NamedTuple
from urllib.parse import quote, unquote

from ppaas.errors import InvalidParameter, MalformedMessage, NotPermitted
from ppaas.wire.names import normalise

ROOT = "ppaas"
SHARED = "map"
_SPECIAL = frozenset("*$?#")


class SharedKey(NamedTuple):
    """What the key of a shared topic says."""

    map: str
    user: str
    robot: str
    topic: str


def chunk(name: str) -> str:
    """Return a name as one chunk of a key.

    Raises
    ------
    InvalidParameter
        The name is empty.
    """
    if not name:
        raise InvalidParameter("a key needs a name that is not empty")
    if name == SHARED:  # a user of this name must not be taken for the shared part
        return f"%{ord(name[0]):02X}{name[1:]}"
    return quote(name, safe="") if name.strip(".") else name.replace(".", "%2E")


def topic_key(user: str, group: str, robot: str, topic: str) -> str:
    """Return the key of a robot's own topic."""
    return "/".join((ROOT, chunk(user), chunk(group), chunk(robot), _topic(topic)))


def shared_key(map_id: str, user: str, robot: str, topic: str) -> str:
    """Return the key under which a robot shows a topic to the robots of its map."""
    return "/".join((ROOT, SHARED, chunk(map_id), chunk(user), chunk(robot), _topic(topic)))


def everyones(map_id: str, topic: str) -> str:
    """Return the key expression of a topic as all robots of a map show it."""
    return "/".join((ROOT, SHARED, chunk(map_id), "*", "*", _topic(topic)))


def parse_shared(key: str) -> SharedKey:
    """Read the key of a shared topic.

    Raises
    ------
    InvalidParameter
        It is the key of something else.
    """
    root, _, rest = key.partition(f"/{SHARED}/")
    parts = rest.split("/", 3)
    if root != ROOT or len(parts) != 4 or not all(parts):
        raise InvalidParameter(f"not the key of a shared topic: {key!r}")
    map_id, user, robot, topic = parts
    return SharedKey(unquote(map_id), unquote(user), unquote(robot), topic)


def _topic(name: str) -> str:
    if _SPECIAL.intersection(name) or ".." in name.split("/"):
        raise NotPermitted(f"a topic is named without wildcards or '..': {name!r}")
    try:
        return normalise(name).replace("~", "%7E")
    except MalformedMessage as error:
        raise InvalidParameter(str(error)) from error


@dataclass(frozen=True, slots=True)
class Scope:
    """What one container may read and write.

    Parameters
    ----------
    user, group, robot : str
        Whose container it is.
    map : str
        The map that its robot stands in.
    """

    user: str
    group: str
    robot: str
    map: str

    def own(self, topic: str) -> str:
        """Return the key of a topic that nobody but this robot's own user reads."""
        return topic_key(self.user, self.group, self.robot, topic)

    def shown(self, topic: str) -> str:
        """Return the key under which this robot shows a topic to the robots of its map."""
        return shared_key(self.map, self.user, self.robot, topic)

    def seen(self, topic: str) -> str:
        """Return the key expression of a topic of all robots of its map, itself among them."""
        return everyones(self.map, topic)

    def check_write(self, key: str) -> None:
        """Make sure that the container may publish under a key.

        Raises
        ------
        NotPermitted
            The key is not the robot's own, or has wildcards.
        """
        _no_wildcards(key)
        shown = f"{ROOT}/{SHARED}/{chunk(self.map)}/{chunk(self.user)}/{chunk(self.robot)}/"
        if not key.startswith((self._mine, shown)):
            raise NotPermitted(f"robot {self.robot!r} of {self.user!r} may not write {key!r}; it writes {self._mine}…")

    def check_read(self, key: str) -> None:
        """Make sure that the container may read a key: one of its own, or one shown to the robots of its map.

        Raises
        ------
        NotPermitted
            Anything else, or wildcards.
        """
        _no_wildcards(key)
        if not key.startswith((self._mine, f"{ROOT}/{SHARED}/{chunk(self.map)}/")):
            raise NotPermitted(f"robot {self.robot!r} of {self.user!r} may not read {key!r}")

    @property
    def _mine(self) -> str:
        return f"{ROOT}/{chunk(self.user)}/{chunk(self.group)}/{chunk(self.robot)}/"


def _no_wildcards(key: str) -> None:
    chunks = key.split("/")
    if _SPECIAL.intersection(key) or any(not part.strip(".") for part in chunks):
        raise NotPermitted(f"a key is named without wildcards, '..' or empty parts: {key!r}")
