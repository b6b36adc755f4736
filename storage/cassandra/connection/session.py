"""Session with a Cassandra keyspace: prepared statements, batches, and errors as ``Unavailable``."""

import itertools
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from cassandra import ConsistencyLevel
from cassandra.cluster import ResponseFuture, ResultSet, Session
from cassandra.concurrent import execute_concurrent_with_args
from cassandra.query import BatchStatement, BatchType, PreparedStatement

from ppaas.errors import Unavailable
from storage.cassandra.connection.address import CassandraAddress
from storage.cassandra.connection.cluster import is_applied
from storage.cassandra.connection.link import ClusterLink, driver_errors, is_silence

AT_ONCE = 128
"""Largest number of concurrent queries."""

GROUPS_AT_ONCE = 32
"""Largest number of concurrent batches: enough to keep a node busy, and few enough for a slow node to write the last
one before its timeout."""

PAGE = 128
"""Rows of different partitions that are queried at once."""

MAX_BATCH_ROWS, MAX_BATCH_BYTES = 10, 4 << 10
"""Approximate size of an unlogged batch [rows, bytes]. Cassandra warns of batches with more than 10 partitions, or of
more than 5 KiB."""

LARGEST_LIMIT = (1 << 31) - 1
"""Largest LIMIT of CQL."""

Write = tuple[str, Sequence[Any]]
"""A CQL statement and its values."""


class CassandraSession:
    """A session with the keyspace of an address. Thread-safe.

    It connects with the first request. Requests fail while all nodes are down, and succeed again once one is back, also
    under another address (``storage.cassandra.connection.link``).

    Parameters
    ----------
    address : CassandraAddress
    create : bool
        Whether to create the keyspace if it is missing.
    """

    def __init__(self, address: CassandraAddress, *, create: bool = True) -> None:
        self._address = address
        self._link = ClusterLink(address, create=create)

    def close(self) -> None:
        """Close the connections."""
        self._link.close()

    def rows(self, cql: str, *values: Any) -> Iterator[Any]:
        """Yield the rows of a query, fetched page by page."""
        with self._asking():
            yield from self._execute(cql, values)

    def rows_up_to(self, limit: int | None, cql: str, *values: Any) -> Iterator[Any]:
        """Yield at most ``limit`` rows of a query, all by default; CQL itself refuses ``LIMIT 0``."""
        if limit != 0:
            yield from self.rows(f"{cql} LIMIT ?", *values, LARGEST_LIMIT if limit is None else limit)

    def row(self, cql: str, *values: Any) -> Any:
        """Return the first row of a query, or None."""
        with self._asking():
            return self._execute(cql, values).one()

    def write(self, cql: str, *values: Any) -> None:
        """Execute an unconditional write."""
        with self._asking():
            self._execute(cql, values)

    def write_if(self, cql: str, *values: Any) -> bool:
        """Execute a lightweight transaction (compare-and-set); return whether it was applied."""
        with self._asking():
            return is_applied(self._execute(cql, values))

    def serial_rows(self, cql: str, *values: Any) -> Iterator[Any]:
        """Yield the rows of a query of one partition; it sees every conditional write of this data centre."""
        with self._asking():
            yield from self._execute_serial(cql, values, ConsistencyLevel.LOCAL_SERIAL)

    def serial_row(self, cql: str, *values: Any) -> Any:
        """Return the first row of a query, or None; it sees every conditional write of all data centres."""
        with self._asking():
            return self._execute_serial(cql, values, ConsistencyLevel.SERIAL).one()

    def serial_write_if(self, cql: str, *values: Any) -> bool:
        """Execute a lightweight transaction that all data centres agree on; return whether it was applied."""
        with self._asking():
            return is_applied(self._execute_serial(cql, values))

    def write_batch(self, writes: Iterable[Write]) -> None:
        """Execute a logged batch: eventually all writes or none are applied; readers may see a part meanwhile."""
        with self._asking():
            self._execute_batch(writes)

    def write_batch_if(self, writes: Iterable[Write]) -> bool:
        """Execute a conditional batch in one partition; return whether all conditions held and it was applied."""
        with self._asking():
            return is_applied(self._execute_batch(writes))

    def write_each(self, cql: str, rows: Iterable[Sequence[Any]]) -> None:
        """Write many independent rows; stop at the first error."""
        self.write_unlogged((), ((cql, row) for row in rows))

    def write_batches(self, groups: Iterable[Sequence[Write]], rows: Iterable[Write] = ()) -> None:
        """Write each group as a logged batch, and the rows independently; stop at the first error."""
        with self._asking():
            self._send(itertools.chain(map(self._batch, groups), map(self._unlogged_batch, _small_groups(rows))))

    def write_unlogged(self, groups: Iterable[Sequence[Write]], rows: Iterable[Write] = ()) -> None:
        """Write each group as an unlogged batch, and the rows independently; stop at the first error.

        The writes of a group to one partition are applied together.
        """
        with self._asking():
            self._send(map(self._unlogged_batch, itertools.chain(groups, _small_groups(rows))))

    def rows_each(self, cql: str, keys: Iterable[Sequence[Any]]) -> list[list[Any]]:
        """Return the rows of a query for each of many keys; the queries run concurrently."""
        with self._asking():
            session, statement = self._session(), self._statement(cql)
            results = execute_concurrent_with_args(session, statement, list(keys), AT_ONCE, raise_on_first_error=True)
            found = [list(result.result_or_exc) for result in results]
        if found:
            self._link.responded()
        return found

    def query_async(self, cql: str, *values: Any) -> Callable[[], list[Any]]:
        """Start a query; return a function that waits for its rows."""
        with self._asking():
            future = self._session().execute_async(self._statement(cql), values)

        def answer() -> list[Any]:
            with self._asking():
                return list(self._result(future))

        return answer

    def partitions(self, table: str, key: str) -> list[str]:
        """Return the keys of the non-empty partitions of a table, sorted."""
        keys = sorted(row[0] for row in self.rows(f"SELECT DISTINCT {key} FROM {table}"))
        found = self.rows_each(f"SELECT {key} FROM {table} WHERE {key} = ? LIMIT 1", [(one,) for one in keys])
        return [one for one, rows in zip(keys, found, strict=True) if rows]

    # -- internals -----------------------------------------------------------------------------------------------------

    def _execute(self, cql: str, values: Sequence[Any]) -> ResultSet:
        return self._result(self._session().execute_async(self._statement(cql), values))

    def _execute_serial(self, cql: str, values: Sequence[Any], level: int | None = None) -> ResultSet:
        statement = self._statement(cql).bind(values)
        statement.serial_consistency_level = ConsistencyLevel.SERIAL
        if level is not None:
            statement.consistency_level = level
        return self._result(self._session().execute_async(statement))

    def _execute_batch(self, writes: Iterable[Write]) -> ResultSet:
        return self._result(self._session().execute_async(self._batch(writes)))

    def _result(self, future: ResponseFuture) -> ResultSet:
        result = future.result()
        self._link.responded()
        return result

    def _send(self, batches: Iterable[BatchStatement]) -> None:
        """Execute batches, up to `GROUPS_AT_ONCE` of them concurrently."""
        under_way: deque[ResponseFuture] = deque()
        for batch in batches:
            if len(under_way) == GROUPS_AT_ONCE:
                self._result(under_way.popleft())
            under_way.append(self._session().execute_async(batch))
        for future in under_way:
            self._result(future)

    def _batch(self, writes: Iterable[Write], kind: BatchType = BatchType.LOGGED) -> BatchStatement:
        batch = BatchStatement(kind)
        for cql, values in writes:
            batch.add(self._statement(cql), values)
        return batch

    def _unlogged_batch(self, writes: Iterable[Write]) -> BatchStatement:
        return self._batch(writes, BatchType.UNLOGGED)

    def _statement(self, cql: str) -> PreparedStatement:
        return self._link.statement(cql)

    def _session(self) -> Session:
        return self._link.session()

    @contextmanager
    def _asking(self) -> Iterator[None]:
        """Turn errors of the driver in the block into ``Unavailable``; note whether they came from a node."""
        try:
            with driver_errors(self._address):
                yield
        except Unavailable as error:
            (self._link.unanswered if is_silence(error.__cause__) else self._link.responded)()
            raise


def _small_groups(rows: Iterable[Write]) -> Iterator[list[Write]]:
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
