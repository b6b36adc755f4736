"""Table of the topics of a robot: what came on each since it was watched, and since its container started."""

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field

import msgspec

from ppaas.bounded import BoundedDict
from ppaas.diagnosis.observations.arrivals import WINDOW, Arrivals, gap_and_burst, lateness, unstamped
from ppaas.diagnosis.observations.facts import TopicFacts
from ppaas.nodes import topics

# -- traffic of a clone ------------------------------------------------------------------------------------------------

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


class TrafficCounter:
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


# -- table of the topics of a robot ------------------------------------------------------------------------------------

ALWAYS = tuple(topic.name for topic in (topics.SCAN, topics.ODOM, topics.TF, topics.TF_STATIC, topics.CMD_VEL))
"""Topics that are listed even if nothing came on them."""

REFUSAL_AGE = 3.0
"""Time after the last refusal from which the messages of a topic count as accepted again [s]."""

Counts = dict[str, tuple[int, int, int]]
"""Messages, bytes and refusals by topic."""


class TopicTable:
    """Counts of a traffic in the last seconds.

    Parameters
    ----------
    traffic : TrafficCounter
    now : float
        Monotonic time at which the watch begins [s].
    """

    def __init__(self, traffic: TrafficCounter, now: float) -> None:
        self._traffic = traffic
        self._since = now
        self._past: deque[tuple[float, Counts]] = deque([(now, self._counts())])

    def _counts(self) -> Counts:
        return {name: (each.count, each.size, each.refused) for name, each in self._traffic.topics.items()}

    def look(self, now: float) -> None:
        """Remember the counts, which is to be done once a second, and forget those before the last `WINDOW` seconds."""
        self._past.append((now, self._counts()))
        while len(self._past) > 2 and now - self._past[1][0] >= WINDOW:
            self._past.popleft()

    def facts(self, now: float, arrivals: Mapping[str, Arrivals], types: Mapping[str, str]) -> list[TopicFacts]:
        """Return the facts of all topics on which something came, and of those that a robot needs.

        Parameters
        ----------
        now : float
            Monotonic time [s].
        arrivals : mapping of str to Arrivals
            Arrivals on the topics that are timed.
        types : mapping of str to str
            Types of the topics of the clone.
        """
        names = [*ALWAYS, *sorted(self._traffic.topics.keys() - set(ALWAYS))]
        return [self._fact(name, now, arrivals.get(name), types.get(name, "")) for name in names]

    def _fact(self, name: str, now: float, arrivals: Arrivals | None, kind: str) -> TopicFacts:
        total = self._traffic.topics.get(name, TopicCount())
        since, before = self._past[0]
        count, size, refused = before.get(name, (0, 0, 0))
        span = max(now - since, 1e-3)
        came, data = total.count - count, total.size - size
        facts = TopicFacts(
            name=name,
            type=kind,
            count=total.count,
            rate=came / span,
            bandwidth=data / span,
            size=data / came if came else total.size / max(total.count, 1),
            silence=now - total.last if total.count else None,
            senders=len(total.senders) if came else 0,
            refused=total.refused - refused if now - total.refused_at <= REFUSAL_AGE else 0,
            refused_count=total.refused,
            refusal=total.refusal,
        )
        return facts if arrivals is None else self._timed(facts, now, arrivals)

    def _timed(self, facts: TopicFacts, now: float, arrivals: Arrivals) -> TopicFacts:
        """Return the facts with the arrivals' facts; a node of the clone may publish the topic, too."""
        recent = arrivals.recent(now)
        if not recent:
            return facts
        gap, burst = gap_and_burst(recent, now)
        late, growth = lateness(recent)
        return msgspec.structs.replace(
            facts,
            count=max(facts.count, len(recent)),
            rate=len(recent) / max(min(now - self._since, WINDOW), 1e-3),
            silence=now - recent[-1].at,
            gap=gap,
            burst=burst,
            late=late,
            growth=growth,
            unstamped=unstamped(recent),
            backwards=arrivals.backwards(),
        )
