"""rosapi at a robot's place: what its clone and its clients offer, told to any of its clients."""

from engine.service.links.place_link import PlaceLink
from ppaas.clock import epoch
from ppaas.wire import rosapi
from ppaas.wire.rosapi import GraphView, NodeView

ITSELF = "rosapi"
CLIENTS = "rosbridge_websocket"
"""The node that all clients together appear as, as with rosbridge."""


def view_of(place: PlaceLink) -> GraphView:
    """Return what there is to talk to at a place.

    A client need not advertise what the clone knows; so what the clone takes and none of its nodes gives counts as
    published by the clients.
    """
    clone = {node.name: NodeView(node.publishes, node.subscribes, node.services) for node in place.nodes.values()}
    given = {topic for node in clone.values() for topic in node.publishes}
    topics, offered = place.topic_types(), place.client_services.types()
    services = {service.name: service.type for service in place.services.values()}
    clients = NodeView([topic for topic in topics if topic not in given], place.heard(), offered)
    nodes = {**clone, ITSELF: NodeView(services=rosapi.SERVICES), CLIENTS: clients}
    return GraphView(epoch(), topics, {**offered, **services, **rosapi.SERVICES}, nodes)


def introspect(place: PlaceLink, service: str, arguments: bytes) -> bytes | None:
    """Answer a call of a service that tells what there is; None if this service does something else.

    Raises
    ------
    InvalidInput
        The arguments are not those of the service, or name a type that is not known.
    """
    return rosapi.answer(service, arguments, view_of(place)) if service in rosapi.SERVICES else None
