"""Entries of the path plan database in Cassandra: stretches that plans share, each kept once under a hash of itself."""

import math
import threading
from collections import OrderedDict
from collections.abc import Iterable, Mapping

from ppaas.clock import Clock, epoch, monotonic
from ppaas.errors import Unavailable
from ppaas.plans.codes import entry_id, poses_of, unpack
from storage.cassandra_plan_rows import Part, read_parts
from storage.cassandra_session import CassandraSession

GRACE = 24 * 3600.0
"""Seconds that an entry is kept after it was written last, though no plan refers to it: a plan may be about to."""

MOST_KNOWN = 1 << 17
MOST_CACHED = 1 << 14


class CassandraEntries:
    """Writes entries before the plans that refer to them, and reads them.

    An entry is never changed, so whoever writes it first or again writes the same. What this process wrote within half
    of ``GRACE`` it does not write again; what nobody wrote for longer than that and no plan refers to is swept away.

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
        self._known: OrderedDict[bytes, float] = OrderedDict()
        self._cached: OrderedDict[bytes, bytes] = OrderedDict()

    def keep(self, entries: Mapping[bytes, bytes]) -> None:
        """Keep entries; when it returns all are there."""
        since = self._clock() - GRACE / 2.0
        with self._lock:
            new = [(data, number) for number, data in entries.items() if self._known.get(number, -math.inf) < since]
        self._session.write_each("UPDATE plan_entries SET data = ? WHERE id = ?", new)
        now = self._clock()
        with self._lock:
            for _, number in new:
                self._known[number] = now
                self._known.move_to_end(number)
            while len(self._known) > MOST_KNOWN:
                self._known.popitem(last=False)

    def parts(self, recipe: bytes, depth: int) -> list[Part]:
        """Return the parts of a recipe that are waypoints."""
        parts = read_parts(recipe)
        for _ in range(depth):
            inner = self._data([part.entry for part in parts])
            parts = [one for part in parts for one in read_parts(inner[part.entry])]
        return parts

    def referred(self, recipe: bytes, depth: int) -> set[bytes]:
        """Return the entries to which a recipe refers, be it by others."""
        parts = read_parts(recipe)
        found = {part.entry for part in parts}
        for _ in range(depth):
            inner = self._data([part.entry for part in parts])
            parts = [one for part in parts for one in read_parts(inner[part.entry])]
            found |= {part.entry for part in parts}
        return found

    def poses(self, scope: bytes, parts: Iterable[Part]) -> bytes:
        """Return the poses of parts, as they were given.

        Raises
        ------
        Unavailable
            An entry is missing or damaged.
        """
        numbers = [part.entry for part in parts]
        data = self._data(numbers)
        codes = {number: unpack(data[number]) for number in data}
        for number, code in codes.items():
            if entry_id(scope, code) != number:
                raise Unavailable(f"entry {number.hex()} of a plan is damaged: restore it from a backup")
        return b"".join(poses_of(codes[number]).astype("<f8").tobytes() for number in numbers)

    def sweep(self, referred: set[bytes], grace: float = GRACE) -> int:
        """Remove entries to which no plan refers and which nobody wrote for a while; return how many.

        Parameters
        ----------
        referred : set of bytes
            Entries to which any plan refers.
        grace : float
            [s]
        """
        before = (epoch() - grace) * 1e6
        rows = self._session.rows("SELECT id, WRITETIME(data) AS written FROM plan_entries")
        old = [(row.written, row.id) for row in rows if row.written < before and row.id not in referred]
        # Whoever writes one of them again meanwhile does so later than it was written last: that one stays.
        self._session.write_each("DELETE FROM plan_entries USING TIMESTAMP ? WHERE id = ?", old)
        return len(old)

    def _data(self, numbers: Iterable[bytes]) -> dict[bytes, bytes]:
        wanted = dict.fromkeys(numbers)
        with self._lock:
            found = {number: self._cached[number] for number in wanted if number in self._cached}
        missing = [(number,) for number in wanted if number not in found]
        for (number,), rows in zip(
            missing, self._session.rows_each("SELECT data FROM plan_entries WHERE id = ?", missing), strict=True
        ):
            if not rows:
                raise Unavailable(f"entry {number.hex()} of a plan is missing: restore it from a backup")
            found[number] = rows[0].data
        self._remember(found)
        return found

    def _remember(self, found: Mapping[bytes, bytes]) -> None:
        with self._lock:
            self._cached.update(found)
            while len(self._cached) > MOST_CACHED:
                self._cached.popitem(last=False)
