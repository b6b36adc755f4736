"""Namespaces of a robot: its id, and the one that a client names in its address.

In a fleet the nodes of each robot run below a namespace, usually the name of the robot. The clone's names have none, so
it is removed from names that begin with it.
"""

import re
from collections.abc import Collection

from ppaas.errors import InvalidParameter, MalformedMessage, NotFound, PPaaSError, rebuild
from ppaas.nodes.topics import TOPICS
from ppaas.wire.names import CLIENTS, NameScope, normalise

RESERVED = frozenset(
    {name.partition("/")[0] for name in TOPICS} | {"rosapi", CLIENTS, "ppaas", "node_monitor", "recorder"}
)
"""First parts of names that mean the clone, a client, or the cloud, and so no namespace."""

_NOT_IN_NAMES = re.compile(r"\W", re.ASCII)


def parse_namespace(text: str) -> str:
    """Return the namespace that a client names, without slashes around it.

    Raises
    ------
    InvalidParameter
        It is not a ROS name, or one whose first part means something else.
    """
    try:
        namespace = normalise(text.removesuffix("/"))
    except MalformedMessage as error:
        raise InvalidParameter(f"namespace must be a ROS name, such as tb3_1, not {text[:64]!r}") from error
    if namespace.partition("/")[0] in RESERVED:
        raise InvalidParameter(f"namespace {namespace[:64]!r} is a name of the clone: give that of the robot, or none")
    return namespace


def scope_of(robot: str, namespace: str | None = None) -> NameScope:
    """Return the names of a client of a robot.

    Parameters
    ----------
    robot : str
        Id of the robot; as a namespace, its characters that no ROS name has are underscores.
    namespace : str, optional
        Namespace that the client names.
    """
    found = [] if namespace is None else [namespace]
    try:
        own = normalise(_NOT_IN_NAMES.sub("_", robot))
    except MalformedMessage:
        return NameScope(found)
    return NameScope(found if own in RESERVED else [*found, own])


def namespace_hint(name: str, known: Collection[str]) -> str:
    """Return what to do if a name that is not known is a known one below a namespace; empty if it is not."""
    parts = name.split("/")
    for count in range(1, 1 if parts[0] in RESERVED else len(parts)):
        if "/".join(parts[count:]) in known:
            namespace = "/".join(parts[:count])
            return f"; if {namespace!r} is the namespace of the robot, add '&namespace={namespace}' to the address"
    return ""


def with_hint(error: NotFound, name: str, known: Collection[str]) -> PPaaSError:
    """Return an error of a name that is not known, with the ``namespace_hint`` if there is one."""
    hint = namespace_hint(name, known)
    return rebuild(error.slug, f"{error}{hint}") if hint else error
