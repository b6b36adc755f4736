"""rosapi: answers about the topics, services, nodes and types of a robot's place, from a view of its graph.

Source: ``rosapi`` of ``RobotWebTools/rosbridge_suite``. As there, names begin with a slash, and an unknown name has an
empty type and empty lists. The parameter services are not here; a node of the clone serves them.
"""

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from typing import Any

from ppaas.errors import UnknownType
from ppaas.messages import decode, encode, message_type, rosapi, service_type
from ppaas.messages.message import Message, ServiceType
from ppaas.messages.std_msgs import Time
from ppaas.messages.typedefs import full_text, typedefs
from ppaas.wire.actions import actions
from ppaas.wire.arguments import as_object
from ppaas.wire.names import ros1_type


@dataclass(frozen=True, slots=True)
class NodeView:
    """Topics and services of a node, without leading slashes."""

    publishes: Collection[str] = ()
    subscribes: Collection[str] = ()
    services: Collection[str] = ()


@dataclass(frozen=True, slots=True)
class GraphView:
    """View of a graph: topics and services with their types as spelled in ROS 1, and nodes; no leading slashes.

    ``now`` is the time since the epoch [s].
    """

    now: float
    topics: Mapping[str, str] = field(default_factory=dict)
    services: Mapping[str, str] = field(default_factory=dict)
    nodes: Mapping[str, NodeView] = field(default_factory=dict)


def answer(service: str, arguments: bytes, view: GraphView) -> bytes:
    """Return the response of one of ``SERVICES``; arguments and response are JSON.

    Raises
    ------
    MalformedMessage
        The arguments do not match the request of the service.
    UnknownType
        The requested type is unknown, or not a type name.
    """
    kind, respond = _RESPONSES[service]
    return encode(respond(view, decode(kind.request, as_object(arguments, kind.request))))


def _slashed(names: Collection[str]) -> list[str]:
    return [f"/{name}" for name in sorted(names)]


def _bare(name: str) -> str:
    return name.removeprefix("/")


def _of_type(things: Mapping[str, str], kind: str) -> list[str]:
    wanted = ros1_type(kind)
    return _slashed([name for name, known in things.items() if known == wanted])


def _nodes(view: GraphView, has: Callable[[NodeView], Collection[str]], name: str) -> list[str]:
    return _slashed([node for node, about in view.nodes.items() if _bare(name) in has(about)])


def _providers(view: GraphView, service: str) -> list[str]:
    return _nodes(view, lambda node: node.services, service)


# -- topics, services, nodes -------------------------------------------------------------------------------------------


def _topics(view: GraphView, _request: Message) -> rosapi.TopicsResponse:
    names = sorted(view.topics)
    return rosapi.TopicsResponse(_slashed(names), [view.topics[name] for name in names])


def _topics_and_raw_types(view: GraphView, request: Message) -> rosapi.TopicsAndRawTypesResponse:
    listed = _topics(view, request)
    return rosapi.TopicsAndRawTypesResponse(listed.topics, listed.types, [_definition(kind) for kind in listed.types])


def _definition(kind: str) -> str:
    try:
        return full_text(message_type(kind))
    except UnknownType:
        return f"# the definition of {kind} is not known here"


def _topics_for_type(view: GraphView, request: rosapi.TypeRequest) -> rosapi.TopicsForTypeResponse:
    return rosapi.TopicsForTypeResponse(_of_type(view.topics, request.type))


def _topic_type(view: GraphView, request: rosapi.TopicRequest) -> rosapi.TypeResponse:
    return rosapi.TypeResponse(view.topics.get(_bare(request.topic), ""))


def _publishers(view: GraphView, request: rosapi.TopicRequest) -> rosapi.PublishersResponse:
    return rosapi.PublishersResponse(_nodes(view, lambda node: node.publishes, request.topic))


def _subscribers(view: GraphView, request: rosapi.TopicRequest) -> rosapi.SubscribersResponse:
    return rosapi.SubscribersResponse(_nodes(view, lambda node: node.subscribes, request.topic))


def _services(view: GraphView, _request: Message) -> rosapi.ServicesResponse:
    return rosapi.ServicesResponse(_slashed(view.services))


def _services_for_type(view: GraphView, request: rosapi.TypeRequest) -> rosapi.ServicesResponse:
    return rosapi.ServicesResponse(_of_type(view.services, request.type))


def _service_type(view: GraphView, request: rosapi.ServiceRequest) -> rosapi.TypeResponse:
    return rosapi.TypeResponse(view.services.get(_bare(request.service), ""))


def _service_providers(view: GraphView, request: rosapi.ServiceRequest) -> rosapi.ServiceProvidersResponse:
    return rosapi.ServiceProvidersResponse(_providers(view, request.service))


def _service_node(view: GraphView, request: rosapi.ServiceRequest) -> rosapi.ServiceNodeResponse:
    return rosapi.ServiceNodeResponse(next(iter(_providers(view, request.service)), ""))


def _all_nodes(view: GraphView, _request: Message) -> rosapi.NodesResponse:
    return rosapi.NodesResponse(_slashed(view.nodes))


def _node_details(view: GraphView, request: rosapi.NodeRequest) -> rosapi.NodeDetailsResponse:
    node = view.nodes.get(_bare(request.node), NodeView())
    return rosapi.NodeDetailsResponse(_slashed(node.subscribes), _slashed(node.publishes), _slashed(node.services))


def _action_servers(view: GraphView, _request: Message) -> rosapi.GetActionServersResponse:
    return rosapi.GetActionServersResponse(_slashed(actions(view.topics)))


# -- types, time -------------------------------------------------------------------------------------------------------


def _message_details(_view: GraphView, request: rosapi.TypeRequest) -> rosapi.DetailsResponse:
    return rosapi.DetailsResponse(typedefs(message_type(request.type)))


def _request_details(_view: GraphView, request: rosapi.TypeRequest) -> rosapi.DetailsResponse:
    return rosapi.DetailsResponse(typedefs(service_type(request.type).request))


def _response_details(_view: GraphView, request: rosapi.TypeRequest) -> rosapi.DetailsResponse:
    return rosapi.DetailsResponse(typedefs(service_type(request.type).response))


def _time(view: GraphView, _request: Message) -> rosapi.GetTimeResponse:
    return rosapi.GetTimeResponse(Time.of(view.now))


_RESPONSES: dict[str, tuple[ServiceType, Callable[[GraphView, Any], Message]]] = {
    "rosapi/topics": (rosapi.Topics, _topics),
    "rosapi/topics_and_raw_types": (rosapi.TopicsAndRawTypes, _topics_and_raw_types),
    "rosapi/topics_for_type": (rosapi.TopicsForType, _topics_for_type),
    "rosapi/topic_type": (rosapi.TopicType, _topic_type),
    "rosapi/publishers": (rosapi.Publishers, _publishers),
    "rosapi/subscribers": (rosapi.Subscribers, _subscribers),
    "rosapi/services": (rosapi.Services, _services),
    "rosapi/services_for_type": (rosapi.ServicesForType, _services_for_type),
    "rosapi/service_type": (rosapi.TypeOfService, _service_type),
    "rosapi/service_providers": (rosapi.ServiceProviders, _service_providers),
    "rosapi/service_node": (rosapi.ServiceNode, _service_node),
    "rosapi/nodes": (rosapi.Nodes, _all_nodes),
    "rosapi/node_details": (rosapi.NodeDetails, _node_details),
    "rosapi/action_servers": (rosapi.GetActionServers, _action_servers),
    "rosapi/message_details": (rosapi.MessageDetails, _message_details),
    "rosapi/service_request_details": (rosapi.ServiceRequestDetails, _request_details),
    "rosapi/service_response_details": (rosapi.ServiceResponseDetails, _response_details),
    "rosapi/get_time": (rosapi.GetTime, _time),
}
SERVICES: Mapping[str, str] = {name: kind.name for name, (kind, _) in _RESPONSES.items()}
"""Services that ``answer`` serves, and their types."""
