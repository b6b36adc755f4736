"""Where plans pass: an index by squares of a map, which names some of the plans of each."""

import threading
from collections import OrderedDict
from collections.abc import Iterable, Sequence

from ppaas.clock import Clock, monotonic
from ppaas.plans.buckets import Place, squares_near, squares_touched
from storage.cassandra_plan_rows import PlanRow
from storage.cassandra_session import CassandraSession
from storage.plan_checks import array_of

PLANS_OF_SQUARE = 8
"""Plans that one process names in a square within ``WINDOW``: where many pass, they pass alike."""

WINDOW = 3600.0
"""[s]"""

MOST_SQUARES = 1 << 16
"""Squares of which a process knows how many plans it named."""

Square = tuple[bytes, int, int]


class Squares:
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
        self._named: OrderedDict[Square, tuple[int, float]] = OrderedDict()

    def add(self, rows: Iterable[PlanRow]) -> None:
        """Name plans in the squares that they pass, where not many are named already."""
        insert = "INSERT INTO plans_by_square (scope, x, y, created, id) VALUES (?, ?, ?, ?, ?)"
        named = []
        for row in rows:
            for x, y in squares_touched(array_of(row.record.poses)[:, :2]):
                if self._has_room((row.scope, x, y)):
                    named.append((row.scope, x, y, row.record.created + 0.0, row.record.id))
        self._session.write_each(insert, named)

    def remove(self, row: PlanRow) -> None:
        """Name a plan nowhere."""
        delete = "DELETE FROM plans_by_square WHERE scope = ? AND x = ? AND y = ? AND created = ? AND id = ?"
        record = row.record
        squares = squares_touched(array_of(record.poses)[:, :2])
        self._session.write_each(delete, [(row.scope, x, y, record.created + 0.0, record.id) for x, y in squares])

    def named(self, scope: bytes, place: Place, tolerance: float, limit: int) -> Sequence[str]:
        """Return the ids of plans that may pass within a tolerance of a place [m], the newest first of each square."""
        query = "SELECT id FROM plans_by_square WHERE scope = ? AND x = ? AND y = ? LIMIT ?"
        keys = [(scope, x, y, limit) for x, y in squares_near(place, tolerance)]
        return [row.id for rows in self._session.rows_each(query, keys) for row in rows]

    def _has_room(self, square: Square) -> bool:
        """Tell whether one more plan is named in a square, and count it."""
        now = self._clock()
        with self._lock:
            count, since = self._named.get(square, (0, now))
            if now - since > WINDOW:
                count, since = 0, now
            if count >= PLANS_OF_SQUARE:
                return False
            self._named[square] = count + 1, since
            self._named.move_to_end(square)
            while len(self._named) > MOST_SQUARES:
                self._named.popitem(last=False)
        return True
