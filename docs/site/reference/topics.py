"""Page of the topics and services, from the nodes of clones of all kinds."""

from collections import defaultdict
from collections.abc import Iterable

from docs.site.reference.clones import KINDS, Member, members
from docs.site.reference.markdown import code, slug, table
from docs.site.reference.markdown import page as joined
from ppaas.messages import type_name
from ppaas.nodes.base import Topic

INTRODUCTION = """
All topics and services of a clone, with the nodes that publish and subscribe to them. Which nodes a clone has depends
on its robot: the [robot protocol](../protocol.md) describes the topics by kind of robot, with their rates and purposes,
and the [node monitor](../node-monitor.md) the nodes that may run on the robot instead.
"""


def page() -> str:
    """Return the page."""
    found = members()
    return joined(
        "# Topics and services",
        INTRODUCTION,
        "## Topics",
        "*Delivery* tells what happens to messages: see [below](#delivery).",
        _topics(found),
        "## Delivery",
        _DELIVERY,
        "## Services",
        _services(found),
        "## Nodes",
        _nodes(found),
    )


def _topics(found: Iterable[Member]) -> str:
    topics: dict[str, Topic] = {}
    publishers, subscribers = defaultdict[str, set[str]](set), defaultdict[str, set[str]](set)
    for member in found:
        topics |= member.topics
        for topic in member.node.publishes:
            publishers[topic.name].add(member.name)
        for topic in member.node.subscribes:
            subscribers[topic.name].add(member.name)
    rows = (
        (
            code(name),
            message_link(type_name(topics[name].type)),
            _listed(publishers[name]),
            _listed(subscribers[name]),
            ", ".join(delivery(topics[name])),
        )
        for name in sorted(topics)
    )
    return table(("topic", "type", "published by", "subscribed to by", "delivery"), rows)


def _services(found: Iterable[Member]) -> str:
    servers = defaultdict[tuple[str, str], set[str]](set)
    for member in found:
        for service in member.node.services:
            servers[service.name, service.type.name].add(member.name)
    rows = ((code(name), message_link(kind), _listed(servers[name, kind])) for name, kind in sorted(servers))
    return table(("service", "type", "node"), rows)


def _nodes(found: Iterable[Member]) -> str:
    containers = defaultdict[str, list[str]](list)
    for member in found:
        containers[member.name].append(member.of)
    rows = (
        (code(name), "every robot" if len(containers[name]) == len(KINDS) else "; ".join(containers[name]))
        for name in sorted(containers)
    )
    return table(("node", "in the container of"), rows)


def message_link(name: str) -> str:
    """Return the link to a type on the page of messages."""
    return f"[{code(name)}](messages.md#{slug(name)})"


def _listed(names: Iterable[str]) -> str:
    return ", ".join(code(name) for name in sorted(names))


def delivery(topic: Topic) -> list[str]:
    """Return the words for the delivery policy of a topic."""
    words = {
        "latched": topic.latched,
        "stream": topic.stream,
        "once": topic.published_once,
        "robot only": topic.robot_only,
        "shared": topic.shared,
        "lasting": topic.lasting,
        "local": topic.local,
    }
    return [word for word, holds in words.items() if holds]


_DELIVERY = """
| word | meaning |
|---|---|
| latched | later subscribers get the last message |
| stream | the next message replaces the one before; on other topics each message arrives |
| once | a message leaves its container only after the checkpoint that contains its event is stored |
| robot only | only the robot publishes it, not its operators |
| shared | the other robots on the map get it |
| lasting | kept for a client that reconnects |
| local | not sent to the cloud while a node on the robot subscribes |
"""
