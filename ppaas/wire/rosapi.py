"""rosapi: answers about the topics, services, nodes and types of a robot's place, from a view of its graph.

Source: ``rosapi`` of ``RobotWebTools/rosbridge_suite``, of ROS 1 and of ROS 2. As there, names begin with a slash, and
an unknown name has an empty type and empty lists. The parameter services are not here; a node of the clone serves them.

Types in responses are spelled as in ROS 1, or as in ROS 2 for a client that spells the type of the service so. What
only ROS 2 has is spelled as there.
"""

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import msgspec

from ppaas.decoding import from_json
from ppaas.errors import MalformedMessage, UnknownType
from ppaas.messages import decode, encode, message_type, message_types, rosapi, service_type, type_name
from ppaas.messages.base.message import Empty, Message, ServiceType
from ppaas.messages.base.std_msgs import Time
from ppaas.messages.registry import service_types
from ppaas.wire.actions import actions, known_actions, part_of_action, type_of_action
from ppaas.wire.arguments import as_object
from ppaas.wire.names import NameScope, ros1_type, ros2_type
from ppaas.wire.typedefs import full_text, typedefs

ROS_VERSION = 2
"""Answer to a client that wants to know which spellings it may use: this question is of ROS 2."""

DISTRIBUTION = "ppaas"
"""Name of the distribution of ROS, which it is none of."""


@dataclass(frozen=True, slots=True)
class NodeView:
    """Topics and services of a node, without leading slashes."""

    publishes: Collection[str] = ()
    subscribes: Collection[str] = ()
    services: Collection[str] = ()


@dataclass(frozen=True, slots=True)
class GraphView:
    """View of a graph: topics and services with their types as spelled in ROS 1, and nodes; no leading slashes.

    ``actions`` are those without topics, with their types, ``package/Name``. ``now`` is the time since the epoch [s],
    ``names`` reads the names in requests.
    """

    now: float
    topics: Mapping[str, str] = field(default_factory=dict)
    services: Mapping[str, str] = field(default_factory=dict)
    actions: Mapping[str, str] = field(default_factory=dict)
    nodes: Mapping[str, NodeView] = field(default_factory=dict)
    names: NameScope = field(default_factory=NameScope)

    def bare(self, name: str) -> str:
        """Return a name in a request in the form of this view; unchanged if it is none, as nothing has it."""
        try:
            return self.names.resolve(name)
        except MalformedMessage:
            return name


def answer(service: str, arguments: bytes, view: GraphView, *, ros2: bool = False) -> bytes:
    """Return the response of one of ``SERVICES``; arguments and response are JSON.

    Parameters
    ----------
    service : str
    arguments : bytes
    view : GraphView
    ros2 : bool
        Whether types in the response are spelled as in ROS 2.

    Raises
    ------
    MalformedMessage
        The arguments do not match the request of the service.
    UnknownType
        The requested type is unknown, or not a type name.
    """
    kind, respond = _RESPONSES[service]
    response = respond(view, decode(kind.request, as_object(arguments, kind.request)))
    return encode(_in_ros2(response, _KINDS[service]) if ros2 and service in _KINDS else response)


def _in_ros2(response: Message, kind: Literal["msg", "srv"]) -> Message:
    """Return a response with its types spelled as in ROS 2."""
    if isinstance(response, rosapi.TypeResponse):
        return rosapi.TypeResponse(ros2_type(response.type, kind) if response.type else "")
    assert isinstance(response, rosapi.TopicsResponse | rosapi.TopicsAndRawTypesResponse)
    return msgspec.structs.replace(response, types=[ros2_type(name, kind) for name in response.types])


PARAMETER_SERVICES = frozenset(f"rosapi/{verb}_param" for verb in ("get", "set", "has", "delete", "search"))
"""Services of the clone whose request names a parameter."""


def without_namespace(arguments: bytes, names: NameScope) -> bytes:
    """Return the request of a service of parameters, JSON, with the name of the parameter without a namespace."""
    try:
        request = from_json(arguments, dict[str, msgspec.Raw])
        name = from_json(request["name"], str)
    except (KeyError, msgspec.DecodeError, UnicodeError):
        return arguments  # the clone says what is wrong
    bare = names.without_namespace(name)
    return arguments if bare == name else msgspec.json.encode(request | {"name": bare})


def parameter_names_in_ros2(response: bytes) -> bytes:
    """Return a response of ``rosapi/get_param_names``, JSON, with names as in ROS 2: ``/node:name``."""
    names = decode(rosapi.GetParamNamesResponse, response).names
    return encode(rosapi.GetParamNamesResponse([f"/{name[1:].replace('/', ':', 1)}" for name in names]))


def _slashed(names: Collection[str]) -> list[str]:
    return [f"/{name}" for name in sorted(names)]


def _of_type(things: Mapping[str, str], kind: str) -> list[str]:
    wanted = ros1_type(kind)
    return _slashed([name for name, known in things.items() if known == wanted])


def _nodes(view: GraphView, has: Callable[[NodeView], Collection[str]], name: str) -> list[str]:
    wanted = view.bare(name)
    return _slashed([node for node, about in view.nodes.items() if wanted in has(about)])


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
    return rosapi.TypeResponse(view.topics.get(view.bare(request.topic), ""))


def _publishers(view: GraphView, request: rosapi.TopicRequest) -> rosapi.PublishersResponse:
    return rosapi.PublishersResponse(_nodes(view, lambda node: node.publishes, request.topic))


def _subscribers(view: GraphView, request: rosapi.TopicRequest) -> rosapi.SubscribersResponse:
    return rosapi.SubscribersResponse(_nodes(view, lambda node: node.subscribes, request.topic))


def _services(view: GraphView, _request: Message) -> rosapi.ServicesResponse:
    return rosapi.ServicesResponse(_slashed(view.services))


def _services_for_type(view: GraphView, request: rosapi.TypeRequest) -> rosapi.ServicesResponse:
    return rosapi.ServicesResponse(_of_type(view.services, request.type))


def _service_type(view: GraphView, request: rosapi.ServiceRequest) -> rosapi.TypeResponse:
    return rosapi.TypeResponse(view.services.get(view.bare(request.service), ""))


def _service_providers(view: GraphView, request: rosapi.ServiceRequest) -> rosapi.ServiceProvidersResponse:
    return rosapi.ServiceProvidersResponse(_providers(view, request.service))


def _service_node(view: GraphView, request: rosapi.ServiceRequest) -> rosapi.ServiceNodeResponse:
    return rosapi.ServiceNodeResponse(next(iter(_providers(view, request.service)), ""))


def _all_nodes(view: GraphView, _request: Message) -> rosapi.NodesResponse:
    return rosapi.NodesResponse(_slashed(view.nodes))


def _node_details(view: GraphView, request: rosapi.NodeRequest) -> rosapi.NodeDetailsResponse:
    node = view.nodes.get(view.bare(request.node), NodeView())
    return rosapi.NodeDetailsResponse(_slashed(node.subscribes), _slashed(node.publishes), _slashed(node.services))


def _action_servers(view: GraphView, _request: Message) -> rosapi.GetActionServersResponse:
    return rosapi.GetActionServersResponse(_slashed([*actions(view.topics), *view.actions]))


def _action_type(view: GraphView, request: rosapi.ActionRequest) -> rosapi.TypeResponse:
    name = view.bare(request.action)
    if name in view.actions:
        return rosapi.TypeResponse(ros2_type(view.actions[name], "action"))
    return rosapi.TypeResponse(type_of_action(name, view.topics))


# -- types, time -------------------------------------------------------------------------------------------------------


def _message_details(_view: GraphView, request: rosapi.TypeRequest) -> rosapi.DetailsResponse:
    return rosapi.DetailsResponse(typedefs(message_type(request.type)))


def _request_details(_view: GraphView, request: rosapi.TypeRequest) -> rosapi.DetailsResponse:
    return rosapi.DetailsResponse(typedefs(service_type(request.type).request))


def _response_details(_view: GraphView, request: rosapi.TypeRequest) -> rosapi.DetailsResponse:
    return rosapi.DetailsResponse(typedefs(service_type(request.type).response))


def _goal_details(_view: GraphView, request: rosapi.TypeRequest) -> rosapi.DetailsResponse:
    return rosapi.DetailsResponse(typedefs(part_of_action(request.type, "Goal")))


def _result_details(_view: GraphView, request: rosapi.TypeRequest) -> rosapi.DetailsResponse:
    return rosapi.DetailsResponse(typedefs(part_of_action(request.type, "Result")))


def _feedback_details(_view: GraphView, request: rosapi.TypeRequest) -> rosapi.DetailsResponse:
    return rosapi.DetailsResponse(typedefs(part_of_action(request.type, "Feedback")))


def _interfaces(_view: GraphView, _request: Message) -> rosapi.InterfacesResponse:
    services = service_types()
    of_services = {type_name(part) for name in services for part in service_type(name)[1:] if part is not Empty}
    messages = [ros2_type(name, "msg") for name in message_types() if name not in of_services]
    return rosapi.InterfacesResponse([*messages, *(ros2_type(name, "srv") for name in services), *known_actions()])


def _ros_version(_view: GraphView, _request: Message) -> rosapi.GetROSVersionResponse:
    return rosapi.GetROSVersionResponse(ROS_VERSION, DISTRIBUTION)


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
    "rosapi/action_type": (rosapi.ActionType, _action_type),
    "rosapi/message_details": (rosapi.MessageDetails, _message_details),
    "rosapi/service_request_details": (rosapi.ServiceRequestDetails, _request_details),
    "rosapi/service_response_details": (rosapi.ServiceResponseDetails, _response_details),
    "rosapi/action_goal_details": (rosapi.ActionGoalDetails, _goal_details),
    "rosapi/action_result_details": (rosapi.ActionResultDetails, _result_details),
    "rosapi/action_feedback_details": (rosapi.ActionFeedbackDetails, _feedback_details),
    "rosapi/interfaces": (rosapi.Interfaces, _interfaces),
    "rosapi/get_ros_version": (rosapi.GetROSVersion, _ros_version),
    "rosapi/get_time": (rosapi.GetTime, _time),
}
_KINDS: dict[str, Literal["msg", "srv"]] = {
    "rosapi/topics": "msg",
    "rosapi/topics_and_raw_types": "msg",
    "rosapi/topic_type": "msg",
    "rosapi/service_type": "srv",
}
"""Services with types in their response, and of what these are."""

SERVICES: Mapping[str, str] = {name: kind.name for name, (kind, _) in _RESPONSES.items()}
"""Services that ``answer`` serves, and their types."""
