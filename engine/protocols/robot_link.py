"""The robot link: what passes between an endpoint and a container.

The container dials; its ``Hello`` is what *ready* means. Whatever must arrive carries a sequence number, is kept by
the endpoint until the container acknowledges it, and is sent again to the container that takes its place.
"""

import msgspec


class TopicInfo(msgspec.Struct, frozen=True):
    """A topic of the clone: its ROS type, and whether its last message is kept for who comes later."""

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


class Refusal(msgspec.Struct, frozen=True):
    """An error on its way to another process."""

    slug: str
    text: str


# -- container → endpoint ----------------------------------------------------------------------------------------------


class Hello(msgspec.Struct, tag="hello"):
    """The container is up; ``applied`` is the last sequence number that its checkpoint knows of."""

    container: str
    secret: str
    pid: int
    applied: int
    topics: list[TopicInfo]
    services: list[ServiceInfo]
    nodes: list[NodeInfo]


class ContainerFailed(msgspec.Struct, tag="failed"):
    """The container cannot be what it was asked to be; another try would end the same way."""

    container: str
    secret: str
    refusal: Refusal


class TopicAdded(msgspec.Struct, tag="declared"):
    """A node has begun to publish a topic that ``Hello`` did not tell of."""

    topic: TopicInfo
    node: str


class TopicRemoved(msgspec.Struct, tag="undeclared"):
    """A topic that was declared at run time is no more; whoever hears it will hear it again should it come back."""

    name: str


class NodesChanged(msgspec.Struct, tag="offers"):
    """Nodes have come or gone since ``Hello``: those that are here now, and their services. Topics stay known."""

    services: list[ServiceInfo]
    nodes: list[NodeInfo]


class Published(msgspec.Struct, tag="published"):
    """A message of a topic, as JSON, for all who hear it or for the client that asked last for a latched one."""

    topic: str
    payload: bytes
    client: int | None = None


class ServiceAnswer(msgspec.Struct, tag="answer"):
    """The response to a call, as JSON, or why there is none."""

    call: int
    payload: bytes = b""
    refusal: Refusal | None = None


class Ack(msgspec.Struct, tag="ack"):
    """Everything up to this sequence number was taken and checkpointed."""

    sequence: int


class ContainerBeat(msgspec.Struct, tag="beat"):
    """The container lives, though it may have nothing to say; ``busy`` if it works for a goal."""

    busy: bool


class MessageRefused(msgspec.Struct, tag="refused"):
    """A message that the clone does not take, for the client that sent it; the sequence is that of ``Deliver``."""

    client: int
    topic: str
    refusal: Refusal
    sequence: int = 0


FromContainer = (
    Hello
    | ContainerFailed
    | TopicAdded
    | TopicRemoved
    | NodesChanged
    | Published
    | ServiceAnswer
    | Ack
    | ContainerBeat
    | MessageRefused
)

# -- endpoint → container ----------------------------------------------------------------------------------------------


class Deliver(msgspec.Struct, tag="deliver"):
    """A message for a topic, as JSON. Sequence 0: it may be lost; above: it must arrive."""

    topic: str
    payload: bytes
    client: int
    sequence: int = 0


class Subscribe(msgspec.Struct, tag="subscribe"):
    """Send what is published on a topic; if it is sent already and latched, its last message, to this client."""

    topic: str
    client: int


class Unsubscribe(msgspec.Struct, tag="unsubscribe"):
    """Send it no more."""

    topic: str


class ServiceCall(msgspec.Struct, tag="call"):
    """Call a service of the clone; the request is JSON."""

    call: int
    service: str
    payload: bytes


class Shutdown(msgspec.Struct, tag="stop"):
    """Checkpoint, and end."""


ToContainer = Deliver | Subscribe | Unsubscribe | ServiceCall | Shutdown
