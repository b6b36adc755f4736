"""Client topics: topics that clients of a place advertise and its clone does not have.

A topic exists while a client advertises it. Its messages pass from client to client at the endpoint and do not reach
the container.
"""

from dataclasses import dataclass, field

from engine.links.shared_place import check_type
from engine.sessions.place.message_completion import Complete, completion_of
from ppaas.errors import MalformedMessage, NotFound, QuotaExceeded
from ppaas.wire.own_topics import OWN_TOPICS

MAX_TOPICS = 200
"""Largest number of topics that the clients of one place may advertise."""

MAX_LATCHED_BYTES = 32 << 20
"""Total size of the latched messages of one place [bytes]."""

Advertiser = tuple[int, str | int | None]
"""Number of a client, and the id of its advertisement, if any."""


@dataclass(slots=True)
class _Topic:
    type: str
    complete: Complete | None
    latched: dict[Advertiser, bool] = field(default_factory=dict)
    last: bytes | None = None


class ClientTopics:
    """Topics that the clients of one place advertise."""

    def __init__(self) -> None:
        self._topics: dict[str, _Topic] = {}
        self._latched_bytes = 0

    def __contains__(self, topic: str) -> bool:
        """Return whether a client advertises a topic."""
        return topic in self._topics

    def type_of(self, topic: str) -> str | None:
        """Return the type of a topic; None if no client advertises it."""
        known = self._topics.get(topic)
        return known.type if known is not None else None

    def types(self) -> dict[str, str]:
        """Return the topics and their types, by the names of ROS 1."""
        return {name: topic.type for name, topic in self._topics.items()}

    def advertise(self, topic: str, kind: str, advertiser: Advertiser, *, latch: bool) -> None:
        """Create a topic, or add another advertiser to it.

        Raises
        ------
        Conflict
            The topic has another type.
        QuotaExceeded
            The clients of this place advertise too many topics.
        """
        known = self._topics.get(topic)
        if known is None:
            if len(self._topics.keys() - OWN_TOPICS.keys()) >= MAX_TOPICS:
                raise QuotaExceeded(
                    f"the clients of a robot may advertise at most {MAX_TOPICS} topics: unadvertise one first"
                )
            known = self._topics[topic] = _Topic(kind, completion_of(kind))
        check_type(topic, known.type, kind)
        known.latched[advertiser] = latch

    def unadvertise(self, topic: str, advertiser: Advertiser) -> None:
        """Withdraw an advertisement, or without an id all of a client's; the topic ends with its last advertisement.

        Raises
        ------
        NotFound
            The client does not advertise this topic.
        """
        known = self._topics.get(topic)
        client, identity = advertiser
        mine = [a for a in known.latched if a[0] == client and identity in (None, a[1])] if known is not None else []
        if known is None or not mine:
            raise NotFound("advertised topic", topic, [t for t, k in self._topics.items() if _is_of(k, client)])
        for one in mine:
            del known.latched[one]
        if not known.latched:
            self._keep(known, None)
            del self._topics[topic]

    def leave(self, client: int) -> None:
        """Withdraw all advertisements of a client."""
        for name in [name for name, topic in self._topics.items() if _is_of(topic, client)]:
            self.unadvertise(name, (client, None))

    def drop(self, topic: str) -> None:
        """Remove a topic whose name the clone now uses."""
        known = self._topics.pop(topic, None)
        if known is not None:
            self._keep(known, None)

    def take(self, topic: str, payload: bytes, *, latch: bool) -> bytes:
        """Take a message; latch it if the message itself or an advertiser of the topic requests that.

        Returns
        -------
        bytes
            The message, complete if the cloud knows its type.

        Raises
        ------
        MalformedMessage
            It is not a JSON object, or not a message of the topic's type.
        QuotaExceeded
            The latched messages of this place are too large.
        """
        if not payload.startswith(b"{"):
            raise MalformedMessage(f"the message on topic {topic!r} is not a JSON object")
        known = self._topics[topic]
        if known.complete is not None:
            payload = known.complete(payload)
        if latch or any(known.latched.values()):
            self._keep(known, payload)
        return payload

    def _keep(self, topic: _Topic, payload: bytes | None) -> None:
        size = self._latched_bytes - len(topic.last or b"") + len(payload or b"")
        if payload is not None and size > MAX_LATCHED_BYTES:
            raise QuotaExceeded(
                f"the latched messages of a robot's clients may take at most {MAX_LATCHED_BYTES >> 20} MiB"
            )
        topic.last, self._latched_bytes = payload, size

    def latched(self, topic: str) -> bytes | None:
        """Return the latched message of a topic, or None."""
        known = self._topics.get(topic)
        return known.last if known is not None else None


def _is_of(topic: _Topic, client: int) -> bool:
    return any(advertiser[0] == client for advertiser in topic.latched)
