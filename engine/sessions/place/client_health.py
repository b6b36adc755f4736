"""Health of the connections of a place: who is connected, what was dropped for them, and what was refused."""

from collections import deque
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Protocol

from ppaas.bounded import BoundedDict
from ppaas.clock import Clock, monotonic
from ppaas.diagnosis.observations.facts import LinkFacts
from ppaas.errors import PPaaSError

MOST_TOPICS = 32
"""Largest number of topics whose last refusal is kept."""

MOST_TEXT = 400
"""Length of the reason of a refusal that is kept [characters]."""

REFUSAL_AGE = 60.0
"""Time for which a refusal or a dropped message counts [s]."""

CONNECT_AGE = 300.0
"""Time for which a connection counts [s]."""

MOST_CONNECTS = 32
"""Largest number of connections of earlier sessions that are kept."""


class ClientQueue(Protocol):
    """Messages that wait for a client."""

    @property
    def connected(self) -> bool:
        """Whether a socket is attached now."""
        ...

    @property
    def connected_at(self) -> Iterable[float]:
        """Monotonic times at which sockets were attached [s]."""
        ...

    @property
    def dropped(self) -> int:
        """Number of messages that were dropped, because the client reads too slowly."""
        ...

    @property
    def dropped_at(self) -> float:
        """Monotonic time of the last one [s]."""
        ...

    def __len__(self) -> int: ...


@dataclass(frozen=True, slots=True)
class _Client:
    role: str
    queue: ClientQueue


class ClientHealth:
    """Connections of the clients of one place.

    Parameters
    ----------
    clock : callable
        Returns monotonic time [s].
    """

    def __init__(self, clock: Clock = monotonic) -> None:
        self._clock = clock
        self._clients: dict[int, _Client] = {}
        self._past: deque[float] = deque(maxlen=MOST_CONNECTS)
        self._refused: BoundedDict[str, tuple[float, str]] = BoundedDict(MOST_TOPICS)

    def joined(self, client: int, role: str, queue: ClientQueue) -> None:
        """Note a client with its role, ``robot`` or ``operator``."""
        self._clients[client] = _Client(role, queue)

    def left(self, client: int) -> None:
        """Forget a client; the connections of a robot count on."""
        gone = self._clients.pop(client, None)
        if gone is not None and gone.role == "robot":
            self._past.extend(gone.queue.connected_at)

    def refused(self, client: int, topic: str, error: PPaaSError) -> None:
        """Note that an operation of a client was refused, if the client is the robot."""
        known = self._clients.get(client)
        if known is not None and known.role == "robot":
            self._refused[topic] = self._clock(), str(error)[:MOST_TEXT]

    def facts(
        self, hearers: Mapping[str, set[int]], client_topics: Mapping[str, str], round_trip: float | None
    ) -> LinkFacts:
        """Return the facts of the diagnosis.

        Parameters
        ----------
        hearers : mapping of str to set of int
            Clients that subscribe to each topic.
        client_topics : mapping of str to str
            Types of the topics that clients advertise.
        round_trip : float, optional
            Time between a ping to the robot and its answer [s].
        """
        robots = {number: client.queue for number, client in self._clients.items() if client.role == "robot"}
        connects = (*self._past, *(at for queue in robots.values() for at in queue.connected_at))
        now = self._clock()
        return LinkFacts(
            robots=sum(queue.connected for queue in robots.values()),
            operators=sum(each.role != "robot" and each.queue.connected for each in self._clients.values()),
            round_trip=round_trip,
            dropped=sum(queue.dropped for queue in robots.values() if now - queue.dropped_at <= REFUSAL_AGE),
            waiting=sum(len(queue) for queue in robots.values()),
            connects=sum(now - at <= CONNECT_AGE for at in connects),
            subscribed=tuple(sorted(topic for topic, numbers in hearers.items() if numbers & robots.keys())),
            client_topics=dict(client_topics),
            refused={topic: text for topic, (at, text) in self._refused.items() if now - at <= REFUSAL_AGE},
        )
