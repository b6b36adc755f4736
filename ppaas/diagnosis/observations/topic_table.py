"""Table of the topics of a robot: what came on each while the robot was watched, and since its container started."""

from collections import deque
from collections.abc import Mapping

import msgspec

from ppaas.diagnosis.observations.arrivals import WINDOW, Arrivals, gap_and_burst, lateness, unstamped
from ppaas.diagnosis.observations.facts import TopicFacts
from ppaas.diagnosis.observations.traffic import TopicCount, Traffic
from ppaas.nodes import topics

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
    traffic : Traffic
    now : float
        Monotonic time at which the watch begins [s].
    """

    def __init__(self, traffic: Traffic, now: float) -> None:
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
