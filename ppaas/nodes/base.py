"""Interfaces of nodes: topics, services, nodes, and the context that an executor provides to a node.

A node does no I/O and starts no thread. It handles messages, calls and timers one at a time, and acts through its
``Context``. So the same class runs in a container of the cloud, in the local node manager of a robot, and in a test.
"""

from abc import ABC
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, NamedTuple, Protocol, TypeVar

from ppaas.change_log import LogChange, LogEntry
from ppaas.errors import NotFound, PPaaSError
from ppaas.messages.base.message import Lazy, Message, ServiceType

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
    repeated : bool
        Although it is latched, a message that a slow connection cannot take may be dropped: another follows while
        somebody subscribes.
    local : bool
        Not sent to the cloud while a node on the robot subscribes to it.
    urgent : bool
        Messages to a client are sent before all others that wait for it.
    many_publishers : bool
        A node on the robot that publishes it also has to receive what the cloud and clients publish on it.
    merge : callable, optional
        Returns the message for later subscribers of a latched topic with many publishers, from the one that they would
        get and the next message. Without it, they get the last message.
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
    repeated: bool = False
    local: bool = False
    urgent: bool = False
    many_publishers: bool = False
    merge: Callable[[Any, Any], Any] | None = None


class Service(NamedTuple):
    """A service that a node offers."""

    name: str
    type: ServiceType


class Job(Protocol):
    """Work that runs outside the node's thread."""

    def cancel(self) -> None:
        """Request cancellation; ``done`` is still called, with the resulting error."""
        ...


class Timer(Protocol):
    """A running timer."""

    def stop(self) -> None:
        """Stop the timer."""
        ...


class Context(Protocol):
    """What an executor provides to a node: clock, topics, timers and jobs."""

    def now(self) -> float:
        """Return the time for stamps, in seconds since the epoch."""
        ...

    def elapsed(self) -> float:
        """Return monotonic seconds, for durations: the clock of the computer may be set."""
        ...

    def publish(self, topic: str, message: Payload) -> None:
        """Publish on a topic that the node declared."""
        ...

    def declare(self, node: "Node", topic: Topic) -> None:
        """Declare a topic that the node publishes in addition to its class's topics, until ``undeclare``.

        Raises
        ------
        Conflict
            A topic of that name exists.
        """
        ...

    def undeclare(self, node: "Node", name: str) -> None:
        """Remove a topic that this node declared; nothing more may be published on it."""
        ...

    def forget(self, topic: str) -> None:
        """Drop the last message of a latched topic, which is out of date."""
        ...

    def latch(self, topic: str, message: Payload) -> None:
        """Replace the last message of a latched topic for later subscribers; current ones do not get it."""
        ...

    def has_subscribers(self, topic: str) -> bool:
        """Return whether a node, or a subscriber outside the executor, subscribes to a topic."""
        ...

    def start(
        self,
        work: Callable[[Callable[[], bool]], T],
        done: Callable[[T | PPaaSError], None],
    ) -> Job:
        """Run ``work(cancelled)`` outside the node's thread; ``done`` gets its result in the node's thread."""
        ...

    def every(self, period: float, callback: Callable[[], None]) -> Timer:
        """Call back every ``period`` seconds, in the node's thread."""
        ...


@dataclass(frozen=True, slots=True)
class Checkpoint:
    """State of a node as JSON, from which it continues in another executor."""

    node: str
    state: bytes


@dataclass(frozen=True, slots=True)
class Demands:
    """Resources that a node needs, for the decision whether it runs in the cloud or on the robot.

    Parameters
    ----------
    compute : float
        CPU load while the robot drives, in cores of a Raspberry Pi 4.
    time_critical : bool
        Whether a late answer is useless, so that no network should separate the node from the robot.
    rates : dict of str to float
        Data rates of the robot's sensors that it subscribes to, by topic [bytes/s].
    """

    compute: float
    time_critical: bool = False
    rates: Mapping[str, float] = field(default_factory=dict)


class Node(ABC):
    """A node with topics, services and parameters.

    Parameters
    ----------
    context : Context
        Provided by the executor.
    """

    name: ClassVar[str]
    subscribes: ClassVar[tuple[Topic, ...]] = ()
    publishes: ClassVar[tuple[Topic, ...]] = ()
    services: ClassVar[tuple[Service, ...]] = ()
    demands: ClassVar[Demands | None] = None
    """Resources that the node needs; None if it always runs in the cloud."""
    keeps_log: ClassVar[bool] = False
    """Whether the node has a log beside its checkpoint."""

    def __init__(self, context: Context) -> None:
        self.context = context

    @property
    def busy(self) -> bool:
        """Whether the node works on a goal; its robot is then not idle, even if no client sends anything."""
        return False

    def start(self) -> None:
        """Called once the node is connected and may publish."""

    def on_message(self, topic: str, message: Payload) -> None:
        """Handle a message of a topic that the node subscribes to."""

    def on_call(self, service: str, request: Message, reply: Reply) -> None:
        """Handle a call of a service that the node offers; ``reply`` must be called once, now or later."""
        reply(NotFound("service", service))

    def checkpoint(self) -> bytes | None:
        """Return the state of the node as JSON, or None if it has none to keep."""
        return None

    def restore(self, state: bytes) -> None:
        """Continue from the result of ``checkpoint``, in this executor or another."""

    def carry_over(self, state: bytes) -> None:
        """Continue from a checkpoint that was made on another map, to which the robot has moved from there.

        What belongs to that map is left out, such as poses and goals on it; by default, nothing does.
        """
        self.restore(state)

    @property
    def has_log_change(self) -> bool:
        """Whether the log must be stored at once, because a crash now would lose much."""
        return False

    def log_change(self) -> LogChange | None:
        """Return the change of the node's log since the last call; None if there is none.

        A checkpoint is small and replaced as a whole; what grows is in the log.
        """
        return None

    def whole_log(self) -> LogChange | None:
        """Return a change that replaces the log by all its entries, for another executor; None if there is none."""
        return None

    def restore_log(self, entries: Sequence[LogEntry]) -> None:
        """Continue from the log, after ``restore``; the entries are sorted by number. A long log is read in a job."""
