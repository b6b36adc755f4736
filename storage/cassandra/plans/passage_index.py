"""Where plans pass: an index by cells of a map, which names some of the plans of each."""

import itertools
import math
import threading
from collections import OrderedDict
from collections.abc import Container, Iterable, Sequence

from ppaas.clock import Clock, monotonic
from ppaas.plans.encoding.codes import poses_of
from ppaas.plans.encoding.index_cells import Position, cells_near, cells_touched
from storage.cassandra.connection.session import CassandraSession, Write
from storage.cassandra.plans.bounded_counts import BoundedCounts
from storage.cassandra.plans.rows import PlanRow
from storage.plan_checks import array_of

PLANS_PER_CELL = 8
"""Plans that one process names in a cell within ``WINDOW``: where many pass, they pass alike."""

WINDOW = 3600.0
"""[s]"""

MAX_CELLS = 1 << 16
"""PassageIndex of which a process knows how many plans it named."""

MAX_SEGMENTS = 1 << 15
"""Stretches of which a process knows which cells they touch."""

MapCell = tuple[bytes, int, int]

_NAME = "INSERT INTO plans_by_square (scope, x, y, created, id) VALUES (?, ?, ?, ?, ?)"
_FORGET = "DELETE FROM plans_by_square WHERE scope = ? AND x = ? AND y = ? AND created = ? AND id = ?"
_NAMED = "SELECT id FROM plans_by_square WHERE scope = ? AND x = ? AND y = ? LIMIT ?"


class PassageIndex:
    """The index. What it names may be gone or lead elsewhere: whoever is named is looked at.

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
        self._named = BoundedCounts[MapCell](PLANS_PER_CELL, MAX_CELLS)
        self._full: set[bytes] = set()
        self._since = -math.inf
        self._touched: OrderedDict[bytes, list[tuple[int, int]]] = OrderedDict()

    def additions(self, rows: Iterable[PlanRow]) -> list[Write]:
        """Return what names plans in the cells that they pass, where not many are named already."""
        with self._lock:
            self._renew()
            return [
                (_NAME, (row.entry.scope, x, y, row.record.created + 0.0, row.record.id))
                for row in rows
                for x, y in self._cells_of(row, but=self._full)
                if self._named.take((row.entry.scope, x, y))
            ]

    def remove(self, row: PlanRow) -> None:
        """Name a plan nowhere."""
        scope, record = row.entry.scope, row.record
        with self._lock:
            cells = self._cells_of(row)
        self._session.write_each(_FORGET, [(scope, x, y, record.created + 0.0, record.id) for x, y in cells])

    def clear(self, rows: Iterable[PlanRow]) -> None:
        """Name no plan at all where some pass."""
        with self._lock:
            cells = {(row.entry.scope, x, y) for row in rows for x, y in self._cells_of(row)}
            for cell in cells:
                self._named.forget(cell)
            self._full.clear()
        self._session.write_each("DELETE FROM plans_by_square WHERE scope = ? AND x = ? AND y = ?", cells)

    def plans_near(self, scope: bytes, place: Position, tolerance: float, limit: int) -> Sequence[str]:
        """Return the ids of plans that may pass within a tolerance of a place [m], the newest first of each cell."""
        keys = [(scope, x, y, limit) for x, y in cells_near(place, tolerance)]
        return [row.id for rows in self._session.rows_each(_NAMED, keys) for row in rows]

    def _renew(self) -> None:
        """Begin to count anew, once the window is over."""
        now = self._clock()
        if now - self._since > WINDOW:
            self._since = now
            self._named.clear()
            self._full.clear()

    def _cells_of(self, row: PlanRow, but: Container[bytes] = ()) -> set[tuple[int, int]]:
        """Return the cells that a plan touches; of one with shared stretches those that these touch, but for some."""
        if not row.segments:
            return cells_touched(array_of(row.record.poses)[:, :2])
        some = (self._touched_by(row.entry.scope, *each) for each in row.segments.items() if each[0] not in but)
        return set(itertools.chain.from_iterable(some))

    def _touched_by(self, scope: bytes, number: bytes, code: bytes) -> list[tuple[int, int]]:
        """Return the cells that a stretch touches, and note if nothing is named there any more."""
        touched = self._touched.get(number)
        if touched is None:
            touched = self._touched[number] = list(cells_touched(poses_of(code)[:, :2]))
            if len(self._touched) > MAX_SEGMENTS:
                self._full.discard(self._touched.popitem(last=False)[0])
        if all(self._named.is_full((scope, x, y)) for x, y in touched):
            self._full.add(number)
        return touched
