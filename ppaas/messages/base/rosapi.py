"""``rosapi``: introspection of topics, services, nodes and types, and access to parameters.

Services of ROS 1 and of ROS 2, where the package is ``rosapi_msgs``. ``GetParam``, ``SetParam`` and ``DeleteParam``
respond as newer versions of rosapi do, with ``successful`` and ``reason``. Older clients ignore these fields.
"""

from msgspec import field

from ppaas.messages.base.message import Empty, Message, ServiceType, UInt8
from ppaas.messages.base.std_msgs import Time


class TypeDef(Message):
    """``rosapi/TypeDef``: the fields of a message; the array length is −1 for no array and 0 for any length."""

    type: str
    fieldnames: list[str]
    fieldtypes: list[str]
    fieldarraylen: list[int]
    examples: list[str]
    constnames: list[str] = field(default_factory=list)
    constvalues: list[str] = field(default_factory=list)


# -- requests ----------------------------------------------------------------------------------------------------------


class TypeRequest(Message):
    """A request that names a type."""

    type: str


class TopicRequest(Message):
    """A request that names a topic."""

    topic: str


class ServiceRequest(Message):
    """A request that names a service."""

    service: str


class ActionRequest(Message):
    """A request that names an action."""

    action: str


class NodeRequest(Message):
    """A request that names a node."""

    node: str


class ParamRequest(Message):
    """A request that names a parameter."""

    name: str


class GetParamRequest(Message):
    """``rosapi/GetParam`` request; ``default`` is the JSON to return if the parameter does not exist."""

    name: str
    default: str = ""


class SetParamRequest(Message):
    """``rosapi/SetParam`` request: the value is JSON."""

    name: str
    value: str


# -- responses ---------------------------------------------------------------------------------------------------------


class TopicsResponse(Message):
    """``rosapi/Topics`` response."""

    topics: list[str]
    types: list[str]


class TopicsAndRawTypesResponse(Message):
    """``rosapi/TopicsAndRawTypes`` response."""

    topics: list[str]
    types: list[str]
    typedefs_full_text: list[str]


class TopicsForTypeResponse(Message):
    """``rosapi/TopicsForType`` response."""

    topics: list[str]


class TypeResponse(Message):
    """``rosapi/TopicType``, ``ServiceType`` and ``ActionType`` response; empty if there is nothing of that name."""

    type: str


class ServicesResponse(Message):
    """``rosapi/Services`` and ``rosapi/ServicesForType`` response."""

    services: list[str]


class NodesResponse(Message):
    """``rosapi/Nodes`` response."""

    nodes: list[str]


class NodeDetailsResponse(Message):
    """``rosapi/NodeDetails`` response."""

    subscribing: list[str]
    publishing: list[str]
    services: list[str]


class PublishersResponse(Message):
    """``rosapi/Publishers`` response."""

    publishers: list[str]


class SubscribersResponse(Message):
    """``rosapi/Subscribers`` response."""

    subscribers: list[str]


class ServiceProvidersResponse(Message):
    """``rosapi/ServiceProviders`` response."""

    providers: list[str]


class ServiceNodeResponse(Message):
    """``rosapi/ServiceNode`` response; empty if no node offers the service."""

    node: str


class GetActionServersResponse(Message):
    """``rosapi/GetActionServers`` response."""

    action_servers: list[str]


class DetailsResponse(Message):
    """Response of ``rosapi/MessageDetails`` and its service variants: the definition of a type and its nested types."""

    typedefs: list[TypeDef]


class InterfacesResponse(Message):
    """``rosapi_msgs/Interfaces`` response."""

    interfaces: list[str]


class GetROSVersionResponse(Message):
    """``rosapi_msgs/GetROSVersion`` response."""

    version: UInt8
    distro: str


class GetTimeResponse(Message):
    """``rosapi/GetTime`` response."""

    time: Time


class GetParamResponse(Message):
    """``rosapi/GetParam`` response: the value is JSON."""

    value: str
    successful: bool = True
    reason: str = ""


class ParamChangedResponse(Message):
    """``rosapi/SetParam`` and ``rosapi/DeleteParam`` response."""

    successful: bool = True
    reason: str = ""


class HasParamResponse(Message):
    """``rosapi/HasParam`` response."""

    exists: bool


class SearchParamResponse(Message):
    """``rosapi/SearchParam`` response; empty if the parameter does not exist."""

    global_name: str


class GetParamNamesResponse(Message):
    """``rosapi/GetParamNames`` response."""

    names: list[str]


# -- services ----------------------------------------------------------------------------------------------------------

Topics = ServiceType("rosapi/Topics", Empty, TopicsResponse)
TopicsAndRawTypes = ServiceType("rosapi/TopicsAndRawTypes", Empty, TopicsAndRawTypesResponse)
TopicsForType = ServiceType("rosapi/TopicsForType", TypeRequest, TopicsForTypeResponse)
TopicType = ServiceType("rosapi/TopicType", TopicRequest, TypeResponse)
Publishers = ServiceType("rosapi/Publishers", TopicRequest, PublishersResponse)
Subscribers = ServiceType("rosapi/Subscribers", TopicRequest, SubscribersResponse)
Services = ServiceType("rosapi/Services", Empty, ServicesResponse)
ServicesForType = ServiceType("rosapi/ServicesForType", TypeRequest, ServicesResponse)
TypeOfService = ServiceType("rosapi/ServiceType", ServiceRequest, TypeResponse)
ServiceProviders = ServiceType("rosapi/ServiceProviders", ServiceRequest, ServiceProvidersResponse)
ServiceNode = ServiceType("rosapi/ServiceNode", ServiceRequest, ServiceNodeResponse)
Nodes = ServiceType("rosapi/Nodes", Empty, NodesResponse)
NodeDetails = ServiceType("rosapi/NodeDetails", NodeRequest, NodeDetailsResponse)
GetActionServers = ServiceType("rosapi/GetActionServers", Empty, GetActionServersResponse)
MessageDetails = ServiceType("rosapi/MessageDetails", TypeRequest, DetailsResponse)
ServiceRequestDetails = ServiceType("rosapi/ServiceRequestDetails", TypeRequest, DetailsResponse)
ServiceResponseDetails = ServiceType("rosapi/ServiceResponseDetails", TypeRequest, DetailsResponse)
ActionType = ServiceType("rosapi/ActionType", ActionRequest, TypeResponse)
ActionGoalDetails = ServiceType("rosapi/ActionGoalDetails", TypeRequest, DetailsResponse)
ActionResultDetails = ServiceType("rosapi/ActionResultDetails", TypeRequest, DetailsResponse)
ActionFeedbackDetails = ServiceType("rosapi/ActionFeedbackDetails", TypeRequest, DetailsResponse)
Interfaces = ServiceType("rosapi/Interfaces", Empty, InterfacesResponse)
GetROSVersion = ServiceType("rosapi/GetROSVersion", Empty, GetROSVersionResponse)
GetTime = ServiceType("rosapi/GetTime", Empty, GetTimeResponse)
GetParam = ServiceType("rosapi/GetParam", GetParamRequest, GetParamResponse)
SetParam = ServiceType("rosapi/SetParam", SetParamRequest, ParamChangedResponse)
DeleteParam = ServiceType("rosapi/DeleteParam", ParamRequest, ParamChangedResponse)
HasParam = ServiceType("rosapi/HasParam", ParamRequest, HasParamResponse)
SearchParam = ServiceType("rosapi/SearchParam", ParamRequest, SearchParamResponse)
GetParamNames = ServiceType("rosapi/GetParamNames", Empty, GetParamNamesResponse)

SERVICES = (
    Topics, TopicsAndRawTypes, TopicsForType, TopicType, Publishers, Subscribers, Services, ServicesForType,
    TypeOfService, ServiceProviders, ServiceNode, Nodes, NodeDetails, GetActionServers, MessageDetails,
    ServiceRequestDetails, ServiceResponseDetails, ActionType, ActionGoalDetails, ActionResultDetails,
    ActionFeedbackDetails, Interfaces, GetROSVersion, GetTime, GetParam, SetParam, DeleteParam, HasParam, SearchParam,
    GetParamNames,
)  # fmt: skip
