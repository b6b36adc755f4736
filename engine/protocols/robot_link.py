"""Robot link: messages between a container and the master, and between a container and each endpoint of its clients.

The container dials; it is *ready* when it sends ``Hello``. Messages that must arrive have a sequence number. The
other end keeps them until the container acknowledges them, and sends them again to a container that replaces it.
"""

import msgspec

from engine.protocols.address import EndpointAddress
from engine.protocols.refusals import Refusal
from engine.protocols.session_frames import SessionFromContainer, SessionToContainer
from engine.protocols.versions import UNSTATED, Protocols
from engine.specs.robot_report import StateReport
from ppaas.messages.health.stops import RobotStop

LINK_FACTS = "ppaas/link_facts"
"""Service of the container of a robot: the facts of the robot's connection, as JSON."""


class TopicInfo(msgspec.Struct, frozen=True):
    """A topic of the clone: its ROS type, and whether its last message is stored for later subscribers."""

    name: str
    type: str
    latched: bool


class ServiceInfo(msgspec.Struct, frozen=True):
    """A service of the clone and its ROS type."""

    name: str
    type: str


class NodeInfo(msgspec.Struct, frozen=True):
    """A node of the clone and the names of its topics and services."""

    name: str
    publishes: tuple[str, ...]
    subscribes: tuple[str, ...]
    services: tuple[str, ...]


# -- container → endpoint ----------------------------------------------------------------------------------------------


class ContainerBeat(msgspec.Struct, tag="beat", frozen=True):
    """Heartbeat of the container, once a second; the first is in its `Hello`.

    Parameters
    ----------
    busy : bool
        Whether it works on a goal.
    sockets : int
        Number of sockets of clients, at all endpoints.
    frames : int
        Number of frames of clients that were taken since the container started.
    round_trip : float, optional
        Round trip to the robot [s], once an endpoint has measured it.
    robot : bool
        Whether one of the sockets belongs to the robot itself.
    report : StateReport
        State of the robot.
    """

    busy: bool
    sockets: int = 0
    frames: int = 0
    round_trip: float | None = None
    robot: bool = False
    report: StateReport = StateReport()


class StopsInForce(msgspec.Struct, tag="stops", frozen=True):
    """Stops that hold the robot of the container: in its hello, and after each change.

    Parameters
    ----------
    stops : tuple of RobotStop
        Those of the last `SetStops`, or of the start of the container.
    requested : tuple of RobotStop
        Request of a client that the cloud does not have yet: one or none.
    unheard : bool
        Whether Move Base runs on the robot, or may, and the robot has not confirmed the stops.
    """

    stops: tuple[RobotStop, ...] = ()
    requested: tuple[RobotStop, ...] = ()
    unheard: bool = False


class Hello(msgspec.Struct, tag="hello"):
    """The container is ready; ``applied`` is the last sequence number in its checkpoint.

    ``place`` and ``generation`` come from `DialEndpoint`; empty and 0 on the link to the master. ``stops`` are None if
    the container has no robot. ``protocols`` are the ones that the container speaks.
    """

    container: str
    secret: str
    pid: int
    applied: int
    topics: list[TopicInfo]
    services: list[ServiceInfo]
    nodes: list[NodeInfo]
    place: str = ""
    generation: int = 0
    beat: ContainerBeat = ContainerBeat(busy=False)
    stops: StopsInForce | None = None
    protocols: Protocols = UNSTATED


class ContainerFailed(msgspec.Struct, tag="failed"):
    """The container cannot start with this spec; another attempt would fail in the same way."""

    container: str
    secret: str
    refusal: Refusal


class KernelsAwaited(msgspec.Struct, tag="kernels_awaited"):
    """The container waits for kernels that its machine compiles. Sent repeatedly, before ``Hello``."""

    container: str
    secret: str


class TopicAdded(msgspec.Struct, tag="declared"):
    """A node has begun to publish a topic that is not in ``Hello``."""

    topic: TopicInfo
    node: str


class TopicRemoved(msgspec.Struct, tag="undeclared"):
    """A topic of ``TopicAdded`` was removed. Its subscriptions stay, in case it is added again."""

    name: str


class NodesChanged(msgspec.Struct, tag="offers"):
    """The nodes of the clone have changed: all current nodes and services. Topics stay known."""

    services: list[ServiceInfo]
    nodes: list[NodeInfo]


class Published(msgspec.Struct, tag="published"):
    """A message of a topic, as JSON, for all subscribers; or a latched one, for the client that has just subscribed."""

    topic: str
    payload: bytes
    client: int | None = None


class MapReplaced(msgspec.Struct, tag="map_replaced"):
    """The map was replaced, and only its changes were published: clients that do not take those need the whole map."""


class ServiceAnswer(msgspec.Struct, tag="answer"):
    """The response to a call, as JSON, or its error."""

    call: int
    payload: bytes = b""
    refusal: Refusal | None = None


class Ack(msgspec.Struct, tag="ack"):
    """All messages up to this sequence number are processed and in a stored checkpoint."""

    sequence: int


class MessageRefused(msgspec.Struct, tag="refused"):
    """The clone refuses a message of a client; ``sequence`` is the number in ``Deliver``."""

    client: int
    topic: str
    refusal: Refusal
    sequence: int = 0


FromContainer = (
    Hello
    | ContainerFailed
    | KernelsAwaited
    | TopicAdded
    | TopicRemoved
    | NodesChanged
    | Published
    | MapReplaced
    | ServiceAnswer
    | Ack
    | ContainerBeat
    | MessageRefused
    | StopsInForce
    | SessionFromContainer
)

# -- endpoint → container ----------------------------------------------------------------------------------------------


class Deliver(msgspec.Struct, tag="deliver"):
    """A message for a topic, as JSON. With sequence 0 it may be lost; with any other it must arrive.

    ``trace`` is the ``traceparent`` of what it is sent for; empty for none.
    """

    topic: str
    payload: bytes
    client: int
    sequence: int = 0
    trace: str = ""


class SubscribeTopic(msgspec.Struct, tag="subscribe"):
    """Send the messages of a topic. If they are sent already and it is latched, send the last one to this client."""

    topic: str
    client: int


class UnsubscribeTopic(msgspec.Struct, tag="unsubscribe"):
    """Stop sending the messages of a topic."""

    topic: str


class ServiceCall(msgspec.Struct, tag="call"):
    """Call a service of the clone; the request is JSON.

    ``trace`` is the ``traceparent`` of what it is called for; empty for none.
    """

    call: int
    service: str
    payload: bytes
    trace: str = ""


class Shutdown(msgspec.Struct, tag="stop"):
    """Store a checkpoint, and exit; from an endpoint: only its link ends."""


class DialEndpoint(msgspec.Struct, tag="dial"):
    """Dial an endpoint, which carries sockets of clients of this place, until `LeaveEndpoint`.

    Parameters
    ----------
    endpoint : str
        Name of the endpoint.
    at : EndpointAddress
        Its addresses.
    place : str
        Name of the place, for the hello.
    generation : int
        Number of the container among the place's containers, for the hello: an endpoint serves none of an earlier one.
    secret : str
        Secret for the hello, by which the endpoint knows that place and generation are right.
    """

    endpoint: str
    at: EndpointAddress
    place: str
    generation: int
    secret: str


class LeaveEndpoint(msgspec.Struct, tag="leave"):
    """Dial an endpoint no more; it has ended, or carries no socket of the place."""

    endpoint: str


class SetStops(msgspec.Struct, tag="set_stops", frozen=True):
    """Hold the robot by these stops alone, or release it if there are none; only the master sends this."""

    stops: tuple[RobotStop, ...]


ToContainer = (
    Deliver
    | SubscribeTopic
    | UnsubscribeTopic
    | ServiceCall
    | Shutdown
    | DialEndpoint
    | LeaveEndpoint
    | SetStops
    | SessionToContainer
)
