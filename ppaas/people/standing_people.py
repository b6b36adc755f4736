"""Standing people whom cameras do not see any more, for example since the robot is too near to see their torsos."""

import math
from collections.abc import Iterable

from ppaas.messages.people_coordination import SEEN, TrackedPerson

STANDING = 0.3
"""Speed below which a person counts as standing [m/s]."""

KEEP = 60.0
"""Time for which the position of a standing person is kept after they were last seen [s]."""

SAME = 0.5
"""Distance within which a person who is seen takes the place of one who is kept: it is the same person [m]."""


class StandingPeople:
    """Positions at which people stood when they were last seen.

    A camera does not see a person who is nearer than about 1 m, and the tracks of people who are not seen soon end. The
    positions alone do not prove that somebody is there: the caller checks that a laser sees legs.

    Parameters
    ----------
    most : int
        Largest number of positions; positions of people who were not seen for the longest time are forgotten first.
    """

    def __init__(self, most: int) -> None:
        self._most = most
        self._stood: dict[int, tuple[float, float, float]] = {}

    def take(self, people: Iterable[TrackedPerson], now: float) -> None:
        """Update the positions by the people of a message at ``now`` [s]."""
        for person in (each for each in people if each.state == SEEN):
            self._stood.pop(person.id, None)
            if math.hypot(person.velocity.x, person.velocity.y) < STANDING:
                self._stood[person.id] = now, person.position.x, person.position.y
        for number in list(self._stood)[: max(len(self._stood) - self._most, 0)]:
            del self._stood[number]

    def unseen(self, seen: Iterable[tuple[float, float]], now: float) -> tuple[tuple[float, float], ...]:
        """Return the positions x, y [m], except those near a person at ``seen`` [m] and those older than `KEEP`."""
        known = tuple(seen)
        return tuple(
            (x, y)
            for at, x, y in self._stood.values()
            if now - at <= KEEP and all(math.hypot(x - px, y - py) > SAME for px, py in known)
        )
