"""Calls of services of a graph that reply at once."""

from typing import Any

from ppaas.errors import PPaaSError
from ppaas.messages.base.message import Message
from ppaas.nodes.graph import Graph


def call_service(graph: Graph, service: str, request: Message) -> Any:
    """Call a service and return its reply; an error is raised."""
    replies: list[Any] = []
    graph.call(service, request, replies.append)
    if isinstance(replies[0], PPaaSError):
        raise replies[0]
    return replies[0]
