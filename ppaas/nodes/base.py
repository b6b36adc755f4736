"""What a node is, and what its home gives it.

A node does no I/O and starts no thread. It is told of messages, calls and timers, one at a time, and answers through
its ``Context``. So one class runs in a cloud container, in a robot's local node manager, and in a test.
"""

from abc import ABC
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import ClassVar, NamedTuple, Protocol, TypeVar

from ppaas.errors import NotFound, PPaaSError
from ppaas.messages.message import Lazy, Message, ServiceType

T = TypeVar("T")

Payload = Message | Lazy
Reply = Callable[[Payload | PPaaSError], None]

DEFAULT_DEPTH = 10
"""Messages of a topic that wait for a slow client."""


class Topic(NamedTuple):
    """A topic with its type and its delivery policy.

    ``ppaas.nodes.topics`` is the table of all topics that a clone defines.

    Parameters
    ----------
    name : str
    type : type of Message
    latched : bool
        Its last message is sent to later subscribers.
    published_once : bool
        A message leaves its container only after a checkpoint is stored that contains the event it reports. So no
        container that restores an earlier checkpoint publishes it again.
    stream : bool
        The next message replaces the one before, so messages to a node may be dropped. On any other topic they must
        arrive: they are acknowledged, and sent again if a container is lost.
    depth : int
        Messages that wait for a slow client, the newest (keep last), unless its subscription has a ``queue_length``.
    expiry : float
        Age at which a waiting message is discarded instead of sent to a client [s].
    lasting : bool
        Messages to a client are not dropped to save memory, and are sent again after it reconnects.
    robot_only : bool
        Only the robot publishes it, not its operators: only the robot can measure it.
    shared : bool
        The container sends it to the other robots on the map.
    local : bool
        Not sent to the cloud while a node on the robot subscribes to it.
    many_publishers : bool
        A node on the robot that publishes it also has to receive what the cloud and clients publish on it.
    """

    name: str
    type: type[Message]
    latched: bool = False
    published_once: bool = False
    stream: bool = False
    depth: int = DEFAULT_DEPTH
    expiry: float = float("inf")
    lasting: bool = False
    robot_only: bool = False
    shared: bool = False
    local: bool = False
    many_publishers: bool = False


class Service(NamedTuple):
    """A service that a node offers."""

    name: str
    type: ServiceType


class Job(Protocol):
    """Work under way off the node's thread."""

    def cancel(self) -> None:
        """Ask it to stop; ``done`` is still called, with what it raises."""
        ...


class Timer(Protocol):
    """A timer under way."""

    def stop(self) -> None:
        """Fire no more."""
        ...


class Context(Protocol):
    """What a home gives each of its nodes."""

    def now(self) -> float:
        """Return seconds since the epoch, for stamps."""
        ...

    def publish(self, topic: str, message: Payload) -> None:
        """Publish on a topic that the node declared."""
        ...

    def declare(self, node: "Node", topic: Topic) -> None:
        """Let a node publish a topic that its class does not name, until ``undeclare``.

        Raises
        ------
        Conflict
            The name is taken.
        """
        ...

    def undeclare(self, node: "Node", name: str) -> None:
        """End a topic that this node declared; nothing more is published on it."""
        ...

    def is_heard(self, topic: str) -> bool:
        """Tell whether anybody hears a topic now: a node, or somebody outside."""
        ...

    def start(
        self,
        work: Callable[[Callable[[], bool]], T],
        done: Callable[[T | PPaaSError], None],
    ) -> Job:
        """Run ``work(cancelled)`` off the node's thread; ``done`` gets its result on the node's thread."""
        ...

    def every(self, period: float, callback: Callable[[], None]) -> Timer:
        """Call back every ``period`` seconds, on the node's thread."""
        ...


@dataclass(frozen=True, slots=True)
class Checkpoint:
    """What a node needs to go on elsewhere: its own JSON."""

    node: str
    state: bytes


@dataclass(frozen=True, slots=True)
class Demands:
    """What a node that may live in either home wants of it, as its class declares.

    Parameters
    ----------
    compute : float
        What it keeps busy while its robot drives, in cores of a Raspberry Pi 4.
    time_critical : bool
        A late answer is as bad as none: no link should lie between it and the robot.
    rates : dict of str to float
        What comes to it from the robot's sensors, by topic [bytes/s].
    """

    compute: float
    time_critical: bool = False
    rates: Mapping[str, float] = field(default_factory=dict)


class Node(ABC):
    """A capability with topics, services and parameters.

    Parameters
    ----------
    context : Context
        Of the home it lives in.
    """

    name: ClassVar[str]
    subscribes: ClassVar[tuple[Topic, ...]] = ()
    publishes: ClassVar[tuple[Topic, ...]] = ()
    services: ClassVar[tuple[Service, ...]] = ()
    demands: ClassVar[Demands | None] = None
    """None: it stays in the cloud."""

    def __init__(self, context: Context) -> None:
        self.context = context

    @property
    def busy(self) -> bool:
        """Tell whether it works for a goal: its robot is not idle, though nobody may say anything meanwhile."""
        return False

    def start(self) -> None:
        """Begin: the node is connected now, and may publish."""

    def on_message(self, topic: str, message: Payload) -> None:
        """Take a message of a topic that the node subscribes to."""

    def on_call(self, service: str, request: Message, reply: Reply) -> None:
        """Take a call of a service that the node offers; ``reply`` may be called now or later, once."""
        reply(NotFound("service", service))

    def checkpoint(self) -> bytes | None:
        """Return what the node needs to go on elsewhere, as JSON, or None if it needs nothing."""
        return None

    def restore(self, state: bytes) -> None:
        """Go on from what ``checkpoint`` returned, in this home or another."""
