"""Baselines of the plan store bench: raw plans in SQLite, zlib, and the paper's greedy deduplication.

From the first waypoint on, the paper's algorithm seeks the longest stored segment that matches. If it has at least G
waypoints, it becomes a shared entry, for which the entry that contains it is split, and the new plan refers to it by
its id; waypoints without a match are stored. This counterpart of ``ppaas.plans.encoding.chunks`` keeps an index of all
runs of G waypoints in memory and only counts: it shows the ratio of the deduplication, and how splits of old entries
add up.
"""

import sqlite3
import tempfile
import zlib
from bisect import bisect_left, insort
from collections.abc import Sequence
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from benchmarks.stores.routes import Routes
from ppaas.clock import monotonic
from ppaas.geometry import Poses
from ppaas.plans.encoding.chunks import words_of
from ppaas.plans.encoding.granularity import GRANULARITY
from ppaas.plans.encoding.kernels.chunks import hash_waypoints
from storage.plan_checks import array_of

if TYPE_CHECKING:
    from rich.progress import Progress


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


COMPARED = 2_000
"""Largest number of plans of the baselines."""

AT_ONCE = 1000
"""Number of plans of a transaction."""


def measure(driven: Routes, plans: int, folder: Path, progress: "Progress", *, smooth: bool) -> dict[str, float]:
    """Measure the baselines with the first plans of a fleet.

    Parameters
    ----------
    driven : Routes
    plans : int
        Number of plans of the bench; at most ``COMPARED`` of them are used.
    folder : Path
        Folder for a temporary database.
    progress : Progress
    smooth : bool
        Whether to smooth the plans.

    Returns
    -------
    dict
        Number of ``plans``; ``raw_sqlite_per_second`` and ``raw_bytes_a_plan`` of plans that are written as they are;
        ``zlib_bytes_a_plan`` if each is compressed; ``greedy_kept_once``, the ratio of all to stored waypoints of the
        greedy deduplication, and ``greedy_ids_a_plan``, the number of entries that a plan refers to.
    """
    count = min(COMPARED, plans)
    greedy = GreedySplit(GRANULARITY)
    raw = zipped = seconds = 0.0
    task = progress.add_task("baselines", total=count)
    with tempfile.TemporaryDirectory(dir=folder) as name, sqlite3.connect(Path(name) / "raw.db") as connection:
        connection.execute("PRAGMA journal_mode = WAL")
        connection.execute("CREATE TABLE plans (id TEXT PRIMARY KEY, poses BLOB)")
        records = driven.records(0, count, smooth=smooth)
        while batch := list(islice(records, AT_ONCE)):
            seconds += _insert(connection, [(record.id, record.poses) for record in batch])
            for record in batch:
                greedy.add(_hashes(array_of(record.poses)).tolist())
                raw += len(record.poses)
                zipped += len(zlib.compress(record.poses))
            progress.advance(task, len(batch))
    connection.close()
    progress.remove_task(task)
    return {
        "plans": count,
        "raw_sqlite_per_second": count / seconds,
        "raw_bytes_a_plan": raw / count,
        "zlib_bytes_a_plan": zipped / count,
        "greedy_kept_once": greedy.waypoints / greedy.kept,
        "greedy_ids_a_plan": greedy.ids_per_plan(),
    }


def _hashes(poses: Poses) -> NDArray[np.uint64]:
    """Return a hash of each pose, by which plans are cut too."""
    hashes = np.empty(len(poses), np.uint64)
    hash_waypoints(words_of(poses), hashes)
    return hashes


def _insert(connection: sqlite3.Connection, rows: list[tuple[str, bytes]]) -> float:
    """Write plans in one transaction; return the time [s]."""
    began = monotonic()
    with connection:
        connection.executemany("INSERT INTO plans VALUES (?, ?)", rows)
    return monotonic() - began
