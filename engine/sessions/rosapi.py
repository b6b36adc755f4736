"""rosapi of a robot's place: topics, services and nodes of its clone and its clients."""

from engine.links.shared_place import SharedPlace
from ppaas.clock import epoch
from ppaas.wire import rosapi
from ppaas.wire.names import CLIENTS, NameScope
from ppaas.wire.own_topics import OWN_TOPICS
from ppaas.wire.rosapi import GraphView, NodeView

ITSELF = "rosapi"
"""Node that offers the services of rosapi."""


def view_of(place: SharedPlace, names: NameScope | None = None) -> GraphView:
    """Return the graph of a place; ``names`` reads the names in a client's requests.

    A client need not advertise topics that the clone knows. Topics that the clone subscribes to and none of its nodes
    publishes therefore count as published by the clients.
    """
    clone = {node.name: NodeView(node.publishes, node.subscribes, node.services) for node in place.nodes.values()}
    given = {topic for node in clone.values() for topic in node.publishes} | OWN_TOPICS.keys()
    topics, offered = place.topic_types(), place.offered_services()
    if clone:
        topics |= OWN_TOPICS
    services = {service.name: service.type for service in place.services.values()}
    clients = NodeView([topic for topic in topics if topic not in given], place.heard(), offered)
    nodes = {**clone, ITSELF: NodeView([*OWN_TOPICS], services=rosapi.SERVICES), CLIENTS: clients}
    return GraphView(
        epoch(),
        topics,
        services={**offered, **services, **rosapi.SERVICES},
        actions=place.offered_actions(),
        nodes=nodes,
        names=names or NameScope(),
    )


def introspect(
    place: SharedPlace, service: str, arguments: bytes, names: NameScope | None = None, *, ros2: bool = False
) -> bytes | None:
    """Return the response of a rosapi service; None if the service is not one of rosapi.

    Parameters
    ----------
    place : Place
    service : str
        Name of the service, resolved.
    arguments : bytes
        Request as JSON.
    names : NameScope, optional
        Reads the names in the request.
    ros2 : bool
        Whether the client expects types as spelled in ROS 2.

    Raises
    ------
    InvalidInput
        The arguments are invalid, or name an unknown type.
    """
    if service not in rosapi.SERVICES:
        return None
    return rosapi.answer(service, arguments, view_of(place, names), ros2=ros2)
