"""A session with Cassandra: statements prepared once, errors told as ours."""

import itertools
import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any

from cassandra.cluster import ResponseFuture, ResultSet, Session
from cassandra.concurrent import execute_concurrent_with_args
from cassandra.query import BatchStatement, BatchType, PreparedStatement

from ppaas.clock import monotonic
from ppaas.errors import Unavailable
from storage.cassandra.connection.address import CassandraAddress
from storage.cassandra.connection.cluster import RECONNECT, connect, is_applied
from storage.cassandra.connection.errors import driver_errors

AT_ONCE = 128
"""Queries that are under way at a time where many are asked."""

GROUPS_AT_ONCE = 32
"""Groups of rows that are under way at a time where many are written: they keep a node busy, and on one that is slow
they are written before it gives up on the last."""

PAGE = 128
"""Rows of other partitions that are asked for together."""

NO_LIMIT = 2**31 - 1

MAX_BATCH_ROWS, MAX_BATCH_BYTES = 10, 4 << 10
"""Rows, and bytes of them, that are sent together, about; of more partitions, and of 5 KiB, Cassandra warns."""

Write = tuple[str, Sequence[Any]]
"""A statement and its values."""


def most(limit: int | None) -> int:
    """Return a limit of 1 or more as CQL takes it."""
    return NO_LIMIT if limit is None else limit


class CassandraSession:
    """A session with the keyspace of an address, safe to use from several threads.

    It connects when something is asked for the first time, and outlives its nodes: what is asked while they are away
    fails, and once one is back it is found again.
    """

    def __init__(self, address: CassandraAddress) -> None:
        self._address = address
        self._opening = threading.Lock()
        self._opened: Session | None = None
        self._closed = False
        self._failed: tuple[float, Unavailable] | None = None
        self._preparing = threading.Lock()
        self._prepared: dict[str, PreparedStatement] = {}

    def close(self) -> None:
        """Let go of the connections."""
        self._closed = True
        with self._opening:
            if self._opened is not None:
                self._opened.cluster.shutdown()

    def rows(self, cql: str, *values: Any) -> Iterator[Any]:
        """Yield the rows of a query, fetched page by page."""
        with driver_errors(self._address):
            yield from self._execute(cql, values)

    def row(self, cql: str, *values: Any) -> Any:
        """Return the first row of a query, or None."""
        with driver_errors(self._address):
            return self._execute(cql, values).one()

    def write(self, cql: str, *values: Any) -> None:
        """Write, whatever was there."""
        with driver_errors(self._address):
            self._execute(cql, values)

    def write_if(self, cql: str, *values: Any) -> bool:
        """Write if the statement's condition holds; tell whether it did. No other can come in between."""
        with driver_errors(self._address):
            return is_applied(self._execute(cql, values))

    def write_batch(self, writes: Iterable[Write]) -> None:
        """Write all or, in the end, nothing; others may see a part of it for a moment."""
        with driver_errors(self._address):
            self._execute_batch(writes)

    def write_batch_if(self, writes: Iterable[Write]) -> bool:
        """Write all to one partition if the conditions of all hold, else nothing; tell whether they did."""
        with driver_errors(self._address):
            return is_applied(self._execute_batch(writes))

    def write_each(self, cql: str, rows: Iterable[Sequence[Any]]) -> None:
        """Write many rows, each for itself; the first error ends it."""
        self.write_unlogged((), ((cql, row) for row in rows))

    def write_batches(self, groups: Iterable[Sequence[Write]], rows: Iterable[Write] = ()) -> None:
        """Write many groups, each as ``write_batch`` does, and rows, each for itself; the first error ends it."""
        with driver_errors(self._address):
            self._send(itertools.chain(map(self._batch, groups), map(self._unlogged_batch, _small_groups(rows))))

    def write_unlogged(self, groups: Iterable[Sequence[Write]], rows: Iterable[Write] = ()) -> None:
        """Write many rows, each for itself, those of a group in one message; the first error ends it.

        What a group has for one partition comes together.
        """
        with driver_errors(self._address):
            self._send(map(self._unlogged_batch, itertools.chain(groups, _small_groups(rows))))

    def rows_each(self, cql: str, keys: Iterable[Sequence[Any]]) -> list[list[Any]]:
        """Return the rows of a query for each of many keys, asked for at once."""
        with driver_errors(self._address):
            session, statement = self._session(), self._statement(cql)
            results = execute_concurrent_with_args(session, statement, list(keys), AT_ONCE, raise_on_first_error=True)
            return [list(result.result_or_exc) for result in results]

    def query_async(self, cql: str, *values: Any) -> Callable[[], list[Any]]:
        """Ask for the rows of a query, and return what waits for them: something else can be done meanwhile."""
        with driver_errors(self._address):
            future = self._session().execute_async(self._statement(cql), values)

        def answer() -> list[Any]:
            with driver_errors(self._address):
                return list(future.result())

        return answer

    def partitions(self, table: str, key: str) -> list[str]:
        """Return the keys of the partitions of a table in which there is anything, sorted."""
        keys = sorted(row[0] for row in self.rows(f"SELECT DISTINCT {key} FROM {table}"))
        found = self.rows_each(f"SELECT {key} FROM {table} WHERE {key} = ? LIMIT 1", [(one,) for one in keys])
        return [one for one, rows in zip(keys, found, strict=True) if rows]

    # -- internals -----------------------------------------------------------------------------------------------------

    def _execute(self, cql: str, values: Sequence[Any]) -> ResultSet:
        return self._session().execute(self._statement(cql), values)

    def _execute_batch(self, writes: Iterable[Write]) -> ResultSet:
        return self._session().execute(self._batch(writes))

    def _send(self, batches: Iterable[BatchStatement]) -> None:
        """Have so many written at a time that a node is kept busy."""
        under_way: deque[ResponseFuture] = deque()
        for batch in batches:
            if len(under_way) == GROUPS_AT_ONCE:
                under_way.popleft().result()
            under_way.append(self._session().execute_async(batch))
        for future in under_way:
            future.result()

    def _batch(self, writes: Iterable[Write], kind: BatchType = BatchType.LOGGED) -> BatchStatement:
        batch = BatchStatement(kind)
        for cql, values in writes:
            batch.add(self._statement(cql), values)
        return batch

    def _unlogged_batch(self, writes: Iterable[Write]) -> BatchStatement:
        return self._batch(writes, BatchType.UNLOGGED)

    def _statement(self, cql: str) -> PreparedStatement:
        session = self._session()
        if cql not in self._prepared:
            with self._preparing:
                statement = session.prepare(cql)
                # What is written twice is as if written once, but for what asks what was there before.
                statement.is_idempotent = " IF " not in cql
                self._prepared[cql] = statement
        return self._prepared[cql]

    def _session(self) -> Session:
        if self._closed:
            raise Unavailable(f"{self._address}: the store is closed")
        if self._opened is None:
            with self._opening:
                if self._opened is None:
                    self._opened = self._open()
        return self._opened

    def _open(self) -> Session:
        """Connect; who asks right after that failed is told so at once, and does not wait for the same again."""
        if self._failed is not None and monotonic() < self._failed[0]:
            raise self._failed[1]
        try:
            with driver_errors(self._address):
                return connect(self._address)
        except Unavailable as error:
            self._failed = monotonic() + RECONNECT, error
            raise


def _small_groups(rows: Iterable[Write]) -> Iterator[list[Write]]:
    """Yield rows, some at a time: as many as Cassandra takes without a warning."""
    group: list[Write] = []
    size = 0
    for row in rows:
        mine = sum(len(value) for value in row[1] if isinstance(value, bytes))
        if group and (len(group) == MAX_BATCH_ROWS or size + mine > MAX_BATCH_BYTES):
            yield group
            group, size = [], 0
        group.append(row)
        size += mine
    if group:
        yield group
