"""Entries of the path plan database in Cassandra: data that plans refer to, each stored once under a hash of itself."""

import math
import threading
from collections import OrderedDict
from collections.abc import Callable, Iterable, Iterator, Mapping

from ppaas.clock import Clock, epoch, monotonic
from ppaas.errors import Unavailable
from ppaas.plans.encoding.codes import entry_id, unpack
from storage.cassandra.connection.session import PAGE, CassandraSession
from storage.cassandra.plans.key_caches import LastWritten
from storage.cassandra.plans.rows import ids_in, ids_on

GRACE = 24 * 3600.0
"""Time for which an entry without references is kept after its last write [s]: its plan may be about to be written."""

MAX_KNOWN = 1 << 17
"""Largest number of entries whose last write a process remembers."""

MAX_CACHED = 1 << 14
"""Largest number of entries that a process caches."""

_DATA = "SELECT data FROM plan_entries WHERE id = ?"
_WRITTEN = "SELECT id, WRITETIME(data) AS written FROM plan_entries WHERE id IN ?"
_WRITE = "INSERT INTO plan_entries (id, data) VALUES (?, ?)"


class CassandraEntries:
    """Writes entries before the plans that refer to them, and reads them.

    An entry never changes, so concurrent or repeated writes are equal. An entry that was written within half of
    ``GRACE`` is not written again. The sweep removes entries without references that are older than ``GRACE``.

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

    def add(self, entries: Mapping[bytes, bytes], encode: Callable[[bytes], bytes]) -> set[bytes]:
        """Write entries, encoded by ``encode``, where they are missing or old; return the ids of those that are new."""
        now = self._clock()
        since = now - GRACE / 2.0
        unknown = self._known.older(entries, since)
        if not unknown:
            return set()
        written = {number: now - age for number, age in self._ages(unknown)}
        missing = [number for number in unknown if written.get(number, -math.inf) < since]
        self._session.write_each(_WRITE, ((number, encode(entries[number])) for number in missing))
        self._known.record(written | dict.fromkeys(missing, now))
        return {number for number in missing if number not in written}

    def segment_ids(self, recipes: Iterable[bytes]) -> list[list[bytes]]:
        """Return the ids of the segments in each recipe; long recipes refer to sheets, which are read here."""
        read = [ids_in(recipe) for recipe in recipes]
        sheets = self.data(one for ids, on_sheets in read if on_sheets for one in ids)
        return [
            [one for sheet in ids for one in ids_on(sheets[sheet])] if on_sheets else ids for ids, on_sheets in read
        ]

    def data(self, numbers: Iterable[bytes]) -> dict[bytes, bytes]:
        """Return the encoded entries by id; ``Unavailable`` if one is missing."""
        wanted = dict.fromkeys(numbers)
        with self._lock:
            found = {number: self._cached[number] for number in wanted if number in self._cached}
        missing = [(number,) for number in wanted if number not in found]
        if not missing:
            return found
        for (number,), rows in zip(missing, self._session.rows_each(_DATA, missing), strict=True):
            if not rows:
                raise Unavailable(f"entry {number.hex()} of a plan is missing: restore the keyspace from a backup")
            found[number] = rows[0].data
        self._remember(found)
        return found

    def _ages(self, numbers: list[bytes]) -> Iterator[tuple[bytes, float]]:
        """Yield id and time since the last write [s] of the existing entries."""
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
    """Return the code of a segment from its encoded entry; ``Unavailable`` if it is damaged."""
    code = unpack(data)
    if entry_id(scope, code) != number:
        raise Unavailable(f"entry {number.hex()} of a plan is damaged: restore the keyspace from a backup")
    return code
