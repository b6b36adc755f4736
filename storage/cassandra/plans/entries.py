"""Entries of the path plan database in Cassandra: what plans refer to, each kept once under a hash of itself."""

import math
import threading
from collections import OrderedDict
from collections.abc import Callable, Iterable, Iterator, Mapping

from ppaas.clock import Clock, epoch, monotonic
from ppaas.errors import Unavailable
from ppaas.plans.encoding.codes import entry_id, unpack
from storage.cassandra.connection.session import PAGE, CassandraSession
from storage.cassandra.plans.last_written import LastWritten
from storage.cassandra.plans.rows import ids_in, ids_on

GRACE = 24 * 3600.0
"""Seconds that an entry is kept after it was written last, though no plan refers to it: a plan may be about to."""

MAX_KNOWN = 1 << 17
MAX_CACHED = 1 << 14

_DATA = "SELECT data FROM plan_entries WHERE id = ?"
_WRITTEN = "SELECT id, WRITETIME(data) AS written FROM plan_entries WHERE id IN ?"
_WRITE = "INSERT INTO plan_entries (id, data) VALUES (?, ?)"


class CassandraEntries:
    """Writes entries before the plans that refer to them, and reads them.

    An entry is never changed, so whoever writes it first or again writes the same. What was written within half of
    ``GRACE`` is not written again; what nobody wrote for longer than that and no plan refers to is swept away.

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
        self._known = LastWritten[bytes](MAX_KNOWN)
        self._cached: OrderedDict[bytes, bytes] = OrderedDict()

    def keep(self, entries: Mapping[bytes, bytes], packing: Callable[[bytes], bytes]) -> set[bytes]:
        """Keep entries as they are packed; when it returns all are there. Return the ids of those that are new."""
        now = self._clock()
        since = now - GRACE / 2.0
        new = self._known.late(entries, since)
        if not new:
            return set()
        written = {number: now - age for number, age in self._ages(new)}
        late = [number for number in new if written.get(number, -math.inf) < since]
        self._session.write_each(_WRITE, ((number, packing(entries[number])) for number in late))
        self._known.note(written | dict.fromkeys(late, now))
        return {number for number in late if number not in written}

    def segment_ids(self, recipes: Iterable[bytes]) -> list[list[bytes]]:
        """Return the ids of the stretches in each of some recipes."""
        read = [ids_in(recipe) for recipe in recipes]
        sheets = self.data(one for ids, on_sheets in read if on_sheets for one in ids)
        return [
            [one for sheet in ids for one in ids_on(sheets[sheet])] if on_sheets else ids for ids, on_sheets in read
        ]

    def data(self, numbers: Iterable[bytes]) -> dict[bytes, bytes]:
        """Return entries as they are kept; ``Unavailable`` if one is missing."""
        wanted = dict.fromkeys(numbers)
        with self._lock:
            found = {number: self._cached[number] for number in wanted if number in self._cached}
        missing = [(number,) for number in wanted if number not in found]
        if not missing:
            return found
        for (number,), rows in zip(missing, self._session.rows_each(_DATA, missing), strict=True):
            if not rows:
                raise Unavailable(f"entry {number.hex()} of a plan is missing: restore it from a backup")
            found[number] = rows[0].data
        self._remember(found)
        return found

    def _ages(self, numbers: list[bytes]) -> Iterator[tuple[bytes, float]]:
        """Yield of entries that are there how long ago they were written last [s]."""
        groups = [(numbers[at : at + PAGE],) for at in range(0, len(numbers), PAGE)]
        now = epoch()
        for rows in self._session.rows_each(_WRITTEN, groups):
            for row in rows:
                yield row.id, max(0.0, now - row.written / 1e6)

    def _remember(self, found: Mapping[bytes, bytes]) -> None:
        with self._lock:
            self._cached.update(found)
            while len(self._cached) > MAX_CACHED:
                self._cached.popitem(last=False)


def code_of(scope: bytes, number: bytes, data: bytes) -> bytes:
    """Return the code of a stretch of a version of a map, of what is kept; ``Unavailable`` if it is damaged."""
    code = unpack(data)
    if entry_id(scope, code) != number:
        raise Unavailable(f"entry {number.hex()} of a plan is damaged: restore it from a backup")
    return code
