"""Traffic of a clone: messages, bytes and refusals of each topic since its container started.

It is counted all the time, also while nobody watches the robot, so it must cost next to nothing.
"""

from dataclasses import dataclass, field

from ppaas.bounded_dict import BoundedDict

MOST_TOPICS = 256
"""Largest number of topics that are counted; clients choose the names that are refused."""

MOST_SENDERS = 8
"""Largest number of senders of a topic that are distinguished."""

MOST_TEXT = 400
"""Length of the reason of a refusal that is kept [characters]."""


@dataclass(slots=True)
class TopicCount:
    """Messages of one topic.

    Parameters
    ----------
    count, size : int
        Messages, and their size in total [bytes].
    last : float
        Monotonic time of the last message [s].
    refused : int
        Messages that the clone refused.
    refused_at : float
        Monotonic time of the last refusal [s].
    refusal : str
        Its reason.
    senders : set of int
        Numbers of the clients that sent messages.
    """

    count: int = 0
    size: int = 0
    last: float = float("-inf")
    refused: int = 0
    refused_at: float = float("-inf")
    refusal: str = ""
    senders: set[int] = field(default_factory=set)


class Traffic:
    """Counts the messages that a container receives over its robot link."""

    def __init__(self) -> None:
        self.topics: BoundedDict[str, TopicCount] = BoundedDict(MOST_TOPICS)

    def note(self, topic: str, size: int, sender: int, now: float) -> None:
        """Count a message of ``size`` bytes that a client sent and that arrived at monotonic time ``now`` [s]."""
        count = self.topics.get(topic)
        if count is None:
            count = self.topics[topic] = TopicCount()
        count.count += 1
        count.size += size
        count.last = now
        if sender not in count.senders and len(count.senders) < MOST_SENDERS:
            count.senders.add(sender)

    def refuse(self, topic: str, reason: str, now: float) -> None:
        """Count the refusal, at monotonic time ``now`` [s], of a message that was noted before."""
        count = self.topics.get(topic)
        if count is not None:
            count.refused += 1
            count.refused_at = now
            count.refusal = reason[:MOST_TEXT]
