"""Deduplication of plans by the paper's algorithm: greedy matching of each new plan against all stored segments.

From the first waypoint on, the algorithm seeks the longest stored segment that matches. If it has at least G waypoints,
it becomes a shared entry, for which the entry that contains it is split, and the new plan refers to it by its id;
waypoints without a match are stored. This counterpart of ``ppaas.plans.encoding.chunks`` keeps an index of all runs of
G waypoints in memory and only counts: it shows the ratio of the deduplication, and how splits of old entries add up.
"""

from bisect import bisect_left, insort
from collections.abc import Sequence


class GreedySplit:
    """Counts the waypoints that would be stored.

    Parameters
    ----------
    granularity : int
        G: number of waypoints of the shortest shared entry.

    Attributes
    ----------
    waypoints, kept : int
        Number of waypoints of all plans, and of stored ones.
    """

    def __init__(self, granularity: int) -> None:
        self.waypoints = self.kept = 0
        self._granularity = granularity
        self._kept: list[int] = []
        self._where: dict[int, int] = {}
        self._splits: list[int] = []
        self._recipes: list[list[tuple[int, int]]] = []

    def add(self, hashes: Sequence[int]) -> None:
        """Add a plan, given by the hashes of its waypoints."""
        self.waypoints += len(hashes)
        recipe, at, fresh = list[tuple[int, int]](), 0, 0
        while at < len(hashes):
            begin, length = self._longest(hashes, at)
            if length < self._granularity:
                at += 1
                continue
            self._keep(hashes[fresh:at], recipe)
            recipe.append((begin, begin + length))
            for split in (begin, begin + length):
                place = bisect_left(self._splits, split)
                if place == len(self._splits) or self._splits[place] != split:
                    insort(self._splits, split)
            at = fresh = at + length
        self._keep(hashes[fresh:], recipe)
        self._recipes.append(recipe)

    def ids_per_plan(self) -> float:
        """Return the mean number of entries that a plan refers to, after all splits."""
        parts = sum(
            1 + bisect_left(self._splits, end) - bisect_left(self._splits, begin + 1)
            for recipe in self._recipes
            for begin, end in recipe
        )
        return parts / max(1, len(self._recipes))

    def _longest(self, hashes: Sequence[int], at: int) -> tuple[int, int]:
        """Return begin and length of a stored match of the segment from ``at`` on; length 0 without a match."""
        window = hashes[at : at + self._granularity]
        begin = self._where.get(hash(tuple(window)), -1)
        if begin < 0 or len(window) < self._granularity:
            return 0, 0
        length, most = 0, min(len(hashes) - at, len(self._kept) - begin)
        while length < most and self._kept[begin + length] == hashes[at + length]:
            length += 1
        return begin, length

    def _keep(self, hashes: Sequence[int], recipe: list[tuple[int, int]]) -> None:
        if not hashes:
            return
        begin = len(self._kept)
        self._kept.extend(hashes)
        self.kept += len(hashes)
        recipe.append((begin, len(self._kept)))
        for first in range(begin, len(self._kept) - self._granularity + 1):
            self._where.setdefault(hash(tuple(self._kept[first : first + self._granularity])), first)
