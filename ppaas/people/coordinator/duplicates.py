"""Duplicates: two identities that are one person, whom robots see at two positions since they disagree where they are.

Two robots that see a person each, while neither sees the other's although nothing hides it, see the same person
if the difference between both stays the same.
"""

import math
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ppaas.people.coordinator.people_table import PeopleTable, PersonRecord

FARTHEST = 2.5
"""Largest distance between two identities that can be one person [m]."""
SAME = 0.35
"""Distance within which two people cannot stand [m]."""
LASTS = 1.0
"""Time for which the difference must stay the same [s]."""
LEAST = 3
"""Number of cycles in which it must have been seen."""
DOUBTFUL = 3.0
"""The same time if another pair would explain as much [s]."""
EQUAL = 0.3
"""Distance within which two differences are equal [m]."""
STEADY = 0.25
"""Largest standard deviation of the difference [m]."""
WALKED = 0.5
"""Distance that one must have walked, unless the robots are that uncertain or another pair confirms it: the difference
between two people who stand stays the same, too [m]."""
CLOSE = 0.35
"""Distance at which one person can appear to robots that know where they are, apart from 0.7 of both deviations [m]."""
MOST_PAIRS = 10
"""Pairs that are examined in a cycle, the nearest first."""

Contradict = Callable[[Sequence[tuple[int, int]]], Sequence[bool]]
"""Called with pairs of rows of people; for each, whether some robot of either should see the other, too."""


@dataclass(slots=True)
class Agreement:
    """Difference between two identities over time.

    Parameters
    ----------
    since : float
        Time of its first value [s].
    x, y : float
        Mean: the position of the younger identity minus the older's [m].
    squares : float
        Sum of the squared distances from the mean [m²].
    count : int
        Number of values.
    robots : pair of frozenset of str
        The robots that see the older and the younger identity.
    support : int
        Number of pairs of identities, with this one, that the same error of the robots explains.
    began : (x, y)
        Position of the older identity at the time of the first value [m].
    walked : float
        Largest distance of the older identity from there [m].
    usual : bool
        Whether the deviations of the robots explain the difference.
    """

    since: float
    x: float = 0.0
    y: float = 0.0
    squares: float = 0.0
    count: int = 0
    robots: tuple[frozenset[str], frozenset[str]] = (frozenset(), frozenset())
    support: int = 0
    began: tuple[float, float] = (0.0, 0.0)
    walked: float = 0.0
    usual: bool = False

    def add(self, x: float, y: float) -> None:
        """Add a difference [m]."""
        self.count += 1
        off_x, off_y = x - self.x, y - self.y
        self.x, self.y = self.x + off_x / self.count, self.y + off_y / self.count
        self.squares += off_x * (x - self.x) + off_y * (y - self.y)

    @property
    def deviation(self) -> float:
        """Standard deviation [m]."""
        return math.sqrt(self.squares / max(self.count, 1))

    def confirms(self, other: "Agreement") -> bool:
        """Return whether another pair, of the same robots, has the same difference."""
        (a, b), (c, d) = self.robots, other.robots
        same = not a.isdisjoint(c) and not b.isdisjoint(d) and math.hypot(self.x - other.x, self.y - other.y) < EQUAL
        swapped = not a.isdisjoint(d) and not b.isdisjoint(c)
        return same or (swapped and math.hypot(self.x + other.x, self.y + other.y) < EQUAL)


class Duplicates:
    """Watches pairs of identities until they are certainly one person."""

    def __init__(self) -> None:
        self._pairs: dict[tuple[int, int], Agreement] = {}

    def find(self, table: PeopleTable, now: float, contradict: Contradict) -> list[tuple[int, int]]:
        """Return the pairs of ids that are one person, the older id first.

        Parameters
        ----------
        table : PeopleTable
        now : float
            [s]
        contradict : callable
            See `Contradict`.
        """
        watched: dict[tuple[int, int], Agreement] = {}
        pairs = {(a, b): (table.positions[b] - table.positions[a]).tolist() for a, b in _near(table)}
        apart = [pair for pair, off in pairs.items() if math.hypot(*off) > SAME]
        different = {pair for pair, clash in zip(apart, contradict(apart), strict=True) if not clash}
        for (a, b), off in pairs.items():
            if (a, b) in different:
                continue
            one, other = table.rows[a], table.rows[b]
            x, y = table.positions[a].tolist()
            agreement = self._pairs.get((one.id, other.id)) or Agreement(now, began=(x, y))
            agreement.add(*off)
            agreement.walked = max(agreement.walked, math.dist(agreement.began, (x, y)))
            agreement.usual = math.hypot(*off) <= CLOSE + 0.7 * math.hypot(one.deviation, other.deviation)
            agreement.robots = frozenset(one.seen_by), frozenset(other.seen_by)
            watched[one.id, other.id] = agreement
        self._pairs = watched
        for agreement in watched.values():
            agreement.support = sum(agreement.confirms(other) for other in watched.values())
        found = [pair for pair, agreement in watched.items() if self._is_certain(pair, agreement, now)]
        return _disjoint(sorted(found, key=lambda pair: -watched[pair].support))

    def forget(self, robots: Collection[str]) -> None:
        """Start over with all pairs that these robots see: their offsets have changed."""
        self._pairs = {
            pair: agreement for pair, agreement in self._pairs.items()
            if all(side.isdisjoint(robots) for side in agreement.robots)
        }  # fmt: skip

    def move_times(self, seconds: float) -> None:
        """Add a time [s] to all times."""
        for agreement in self._pairs.values():
            agreement.since += seconds

    def _is_certain(self, pair: tuple[int, int], agreement: Agreement, now: float) -> bool:
        """Return whether a pair is one person: the difference lasts, and no other pair of either explains more."""
        if now - agreement.since < LASTS or agreement.count < LEAST or agreement.deviation > STEADY:
            return False
        if not (agreement.usual or agreement.walked >= WALKED or agreement.support > 1):
            return False
        others = [each for ids, each in self._pairs.items() if ids != pair and not set(ids).isdisjoint(pair)]
        if all(agreement.support > other.support for other in others):
            return True
        best = all(agreement.support >= other.support for other in others)
        clearer = all(agreement.deviation < 0.5 * other.deviation for other in others)
        return best and clearer and now - agreement.since >= DOUBTFUL


def _near(table: PeopleTable) -> Iterator[tuple[int, int]]:
    """Yield pairs of rows that are near each other and seen by different robots, the nearest first, older id first."""
    seen = [row for row, person in enumerate(table.rows) if person.seen_by]
    if len(seen) < 2:
        return
    at = table.positions[seen]
    x, y = at[:, 0, np.newaxis] - at[:, 0], at[:, 1, np.newaxis] - at[:, 1]
    square = x * x + y * y
    i, k = np.nonzero(np.triu(square < FARTHEST**2, 1))
    count = 0
    for n in np.argsort(square[i, k], kind="stable").tolist():
        a, b = sorted((seen[i[n]], seen[k[n]]), key=lambda row: table.rows[row].id)
        if not _share(table.rows[a], table.rows[b]):
            yield a, b
            count += 1
            if count == MOST_PAIRS:
                return


def _share(one: PersonRecord, other: PersonRecord) -> bool:
    return not one.seen_by.keys().isdisjoint(other.seen_by)


def _disjoint(pairs: list[tuple[int, int]]) -> list[tuple[int, int]]:
    """Return pairs without those that contain an id of an earlier pair."""
    taken: set[int] = set()
    kept = []
    for pair in pairs:
        if taken.isdisjoint(pair):
            kept.append(pair)
            taken |= set(pair)
    return kept
