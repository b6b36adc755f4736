"""Passage index: for each cell of a map, a sample of the plans that touch it."""

import itertools
import math
import threading
from collections import OrderedDict
from collections.abc import Container, Iterable, Sequence

from ppaas.clock import Clock, monotonic
from ppaas.plans.encoding.codes import poses_of
from ppaas.plans.encoding.index_cells import Position, cells_near, cells_touched
from storage.cassandra.connection.session import CassandraSession, Write
from storage.cassandra.plans.key_caches import BoundedCounts
from storage.cassandra.plans.rows import UnwrittenPlan
from storage.plan_checks import array_of

PLANS_PER_CELL = 8
"""Plans that one process adds to a cell within ``WINDOW``; where many plans pass, they are similar."""

WINDOW = 3600.0
"""Period after which a process recounts the plans of cells [s]."""

MAX_CELLS = 1 << 16
"""Largest number of cells for which a process counts the plans that it added."""

MAX_SEGMENTS = 1 << 15
"""Largest number of segments whose cells a process remembers."""

MapCell = tuple[bytes, int, int]
"""Scope of a map version, and x, y of a cell (``ppaas.plans.encoding.index_cells``)."""

_INSERT = "INSERT INTO plans_by_square (scope, x, y, created, id) VALUES (?, ?, ?, ?, ?)"
_DELETE = "DELETE FROM plans_by_square WHERE scope = ? AND x = ? AND y = ? AND created = ? AND id = ?"
_FIND = "SELECT id FROM plans_by_square WHERE scope = ? AND x = ? AND y = ? LIMIT ?"


class PassageIndex:
    """The index. Its plans may have been removed or replaced, so a reader checks each of them. Thread-safe.

    Parameters
    ----------
    session : CassandraSession
    clock : callable
        Monotonic seconds.
    """

    def __init__(self, session: CassandraSession, clock: Clock = monotonic) -> None:
        self._session = session
        self._clock = clock
        self._lock = threading.Lock()
        self._counts = BoundedCounts[MapCell](PLANS_PER_CELL, MAX_CELLS)
        self._full: set[bytes] = set()
        self._since = -math.inf
        self._touched: OrderedDict[bytes, list[tuple[int, int]]] = OrderedDict()

    def additions(self, rows: Iterable[UnwrittenPlan]) -> list[Write]:
        """Return writes that add plans to the cells that they touch, except cells with enough plans."""
        with self._lock:
            self._start_window()
            return [
                (_INSERT, (row.entry.scope, x, y, row.record.created + 0.0, row.record.id))
                for row in rows
                for x, y in self._cells_of(row, but=self._full)
                if self._counts.increase((row.entry.scope, x, y))
            ]

    def remove(self, row: UnwrittenPlan) -> None:
        """Remove a plan from all cells."""
        scope, record = row.entry.scope, row.record
        with self._lock:
            cells = self._cells_of(row)
        self._session.write_each(_DELETE, [(scope, x, y, record.created + 0.0, record.id) for x, y in cells])

    def clear(self, rows: Iterable[UnwrittenPlan]) -> None:
        """Remove all plans from the cells that these plans touch."""
        with self._lock:
            cells = {(row.entry.scope, x, y) for row in rows for x, y in self._cells_of(row)}
            for cell in cells:
                self._counts.forget(cell)
            self._full.clear()
        self._session.write_each("DELETE FROM plans_by_square WHERE scope = ? AND x = ? AND y = ?", cells)

    def plans_near(self, scope: bytes, place: Position, tolerance: float, limit: int) -> Sequence[str]:
        """Return the ids of plans that may pass within a tolerance [m] of a place, cell by cell, newest first."""
        keys = [(scope, x, y, limit) for x, y in cells_near(place, tolerance)]
        return [row.id for rows in self._session.rows_each(_FIND, keys) for row in rows]

    def _start_window(self) -> None:
        now = self._clock()
        if now - self._since > WINDOW:
            self._since = now
            self._counts.clear()
            self._full.clear()

    def _cells_of(self, row: UnwrittenPlan, but: Container[bytes] = ()) -> set[tuple[int, int]]:
        """Return the cells that a plan touches; if it has shared segments, the cells of its segments except ``but``."""
        if not row.segments:
            return cells_touched(array_of(row.record.poses)[:, :2])
        some = (self._touched_by(row.entry.scope, *each) for each in row.segments.items() if each[0] not in but)
        return set(itertools.chain.from_iterable(some))

    def _touched_by(self, scope: bytes, number: bytes, code: bytes) -> list[tuple[int, int]]:
        """Return the cells that a segment touches; record the segment as full if all of them have enough plans."""
        touched = self._touched.get(number)
        if touched is None:
            touched = self._touched[number] = list(cells_touched(poses_of(code)[:, :2]))
            if len(self._touched) > MAX_SEGMENTS:
                self._full.discard(self._touched.popitem(last=False)[0])
        if all(self._counts.is_full((scope, x, y)) for x, y in touched):
            self._full.add(number)
        return touched
