"""Topics that clients of a place advertise and the clone does not know: they live as long as who advertises them.

Messages on them go from client to client at the endpoint, and reach no container.
"""

from dataclasses import dataclass, field

from ppaas.errors import Conflict, MalformedMessage, NotFound, QuotaExceeded

MAX_TOPICS = 200
"""Topics that the clients of one place may advertise."""

MAX_LATCHED_BYTES = 32 << 20
"""Bytes of their last messages that one place keeps."""

Advertiser = tuple[int, str | None]
"""A client, and the id of its advertisement."""


@dataclass(slots=True)
class _Topic:
    type: str
    latched: dict[Advertiser, bool] = field(default_factory=dict)
    last: bytes | None = None


class ClientTopics:
    """What the clients of one place advertise."""

    def __init__(self) -> None:
        self._topics: dict[str, _Topic] = {}
        self._latched_bytes = 0

    def __contains__(self, topic: str) -> bool:
        """Tell whether some client advertises a topic."""
        return topic in self._topics

    def type_of(self, topic: str) -> str | None:
        """Return the type of a topic; None if nobody advertises it."""
        known = self._topics.get(topic)
        return known.type if known is not None else None

    def types(self) -> dict[str, str]:
        """Return the topics and their types, as ROS 1 spells them."""
        return {name: topic.type for name, topic in self._topics.items()}

    def advertise(self, topic: str, kind: str, advertiser: Advertiser, *, latch: bool) -> None:
        """Establish a topic, or register one more who advertises it.

        Raises
        ------
        Conflict
            It is there with another type.
        QuotaExceeded
            There are too many.
        """
        known = self._topics.get(topic)
        if known is None:
            if len(self._topics) >= MAX_TOPICS:
                raise QuotaExceeded(f"the clients of a robot may advertise {MAX_TOPICS} topics: unadvertise some first")
            known = self._topics[topic] = _Topic(kind)
        check_type(topic, known.type, kind)
        known.latched[advertiser] = latch

    def unadvertise(self, topic: str, advertiser: Advertiser) -> None:
        """Take an advertisement back; without an id, all of that client's. The topic goes with the last.

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
        """Take back all that a client advertised."""
        for name in [name for name, topic in self._topics.items() if _is_of(topic, client)]:
            self.unadvertise(name, (client, None))

    def drop(self, topic: str) -> None:
        """Give a name up to the clone."""
        known = self._topics.pop(topic, None)
        if known is not None:
            self._keep(known, None)

    def take(self, topic: str, payload: bytes, *, latch: bool) -> None:
        """Take a message; the last one is kept where the message, or some advertiser of the topic, asks for it.

        Raises
        ------
        MalformedMessage
            It is no object.
        QuotaExceeded
            Too much is kept.
        """
        if not payload.startswith(b"{"):
            raise MalformedMessage(f"a message is an object; {topic!r} got something else")
        known = self._topics[topic]
        if latch or any(known.latched.values()):
            self._keep(known, payload)

    def _keep(self, topic: _Topic, payload: bytes | None) -> None:
        size = self._latched_bytes - len(topic.last or b"") + len(payload or b"")
        if payload is not None and size > MAX_LATCHED_BYTES:
            raise QuotaExceeded(f"latched messages of a robot's clients may have {MAX_LATCHED_BYTES >> 20} MiB")
        topic.last, self._latched_bytes = payload, size

    def latched(self, topic: str) -> bytes | None:
        """Return the last message of a topic, if it is kept."""
        known = self._topics.get(topic)
        return known.last if known is not None else None


def check_type(topic: str, has: str, wanted: str) -> None:
    """Compare the type of a topic with the one that a client gives it.

    Raises
    ------
    Conflict
        They are not the same.
    """
    if has != wanted:
        raise Conflict(f"topic {topic!r} carries {has}, not {wanted}")


def _is_of(topic: _Topic, client: int) -> bool:
    return any(advertiser[0] == client for advertiser in topic.latched)
