"""The connections to a Cassandra cluster, which are made again if its nodes move to other addresses.

The driver resolves host names once, when it connects, and later knows nodes by their IP addresses. It never finds a
cluster again whose nodes have all come back under other addresses, as restarted containers and pods do. So once no node
has responded for a while, the cluster is connected to again in the background, by the names in the URL. The new
connections replace the old ones when they work.
"""

import logging
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

from cassandra import (
    AuthenticationFailed,
    DriverException,
    InvalidRequest,
    OperationTimedOut,
    ReadFailure,
    ReadTimeout,
    Unauthorized,
    WriteTimeout,
)
from cassandra import Unavailable as TooFewReplicas
from cassandra.cluster import NoHostAvailable, Session
from cassandra.connection import ConnectionException
from cassandra.protocol import ErrorMessage
from cassandra.query import PreparedStatement

from ppaas.clock import Clock, monotonic
from ppaas.errors import InvalidInput, Unavailable
from storage.cassandra.connection.address import CassandraAddress
from storage.cassandra.connection.cluster import RECONNECT, connect
from storage.store_errors import unusable

logger = logging.getLogger(__name__)


# Errors of Cassandra and its driver become ``Unavailable`` with advice for the operator.

_REFUSED = "user or password is wrong: correct them in the URL"
_TOMBSTONES = 1
"""Code of a read that met more deleted rows than ``tombstone_failure_threshold`` (native protocol 5, error 0x1300)."""

_DELETED_ROWS = (
    "a query met too many deleted rows: run nodetool repair, then ALTER TABLE … WITH gc_grace_seconds = 3600 for the "
    "table that the log of Cassandra names, then nodetool compact for it on each node; afterwards set the former value"
)
_LATE = "timeout: check whether nodes are overloaded; a write may or may not have been applied"

_ADVICE: tuple[tuple[type[Exception] | tuple[type[Exception], ...], str], ...] = (
    ((OperationTimedOut, WriteTimeout, ReadTimeout), _LATE),
    (TooFewReplicas, "too few nodes are up for the consistency level: start them, or set a lower one in the URL"),
    (AuthenticationFailed, _REFUSED),
    (Unauthorized, "the user lacks a permission: grant it"),
    (InvalidRequest, "the schema of the keyspace is not that of this release: restore it, or use another keyspace"),
)


@contextmanager
def driver_errors(place: object) -> Iterator[None]:
    """Turn errors of the driver in the block into ``Unavailable``; ``place`` names the cluster in the message."""
    try:
        yield
    except (NoHostAvailable, DriverException, ErrorMessage, ConnectionException, OSError) as error:
        raise unusable(place, _advice(error)) from error


def is_silence(error: BaseException | None) -> bool:
    """Return whether an error means that no node responded, rather than that one responded with an error."""
    return isinstance(error, (NoHostAvailable, OperationTimedOut, ConnectionException, OSError))


def _advice(error: Exception) -> str:
    if isinstance(error, NoHostAvailable):
        return _no_host(error)
    if isinstance(error, ReadFailure) and _TOMBSTONES in (error.error_code_map or {}).values():
        return f"{_DELETED_ROWS} ({error})"
    advice = next((text for kinds, text in _ADVICE if isinstance(error, kinds)), type(error).__name__)
    return f"{advice} ({error})"


def _no_host(error: NoHostAvailable) -> str:
    errors = list(error.errors.values()) if isinstance(error.errors, dict) else []
    if any(isinstance(one, AuthenticationFailed) for one in errors):
        return _REFUSED
    first = f" ({errors[0]})" if errors else ""
    return f"no node responds: start Cassandra, or correct hosts and port in the URL{first}"


SILENCE = 3.0
"""Time without a response of any node after which the cluster is connected to again, and between two attempts [s]."""


class NodeSilence:
    """Measures for how long no node has responded. ``begin`` is called by one thread at a time.

    Parameters
    ----------
    clock : callable
        Monotonic seconds.
    """

    def __init__(self, clock: Clock = monotonic) -> None:
        self._clock = clock
        self._since: float | None = None

    def begin(self) -> bool:
        """Note a request without a response; return whether it is time to connect again."""
        now = self._clock()
        if self._since is None:
            self._since = now
        if now - self._since < SILENCE:
            return False
        self._since = now  # the next attempt waits as long
        return True

    def end(self) -> None:
        """Note a response."""
        self._since = None


@dataclass
class _Opened:
    """A session, and the statements that were prepared with it."""

    session: Session
    prepared: dict[str, PreparedStatement] = field(default_factory=dict)


class ClusterLink:
    """A session with a keyspace, opened with the first request. Thread-safe.

    Parameters
    ----------
    address : CassandraAddress
    create : bool
        Whether to create the keyspace if it is missing. It is never created while connecting again: the names in the
        URL may lead to an empty cluster by then.
    """

    def __init__(self, address: CassandraAddress, *, create: bool = True) -> None:
        self._address = address
        self._create = create
        self._opening = threading.Lock()
        self._preparing = threading.Lock()
        self._opened: _Opened | None = None
        self._closed = threading.Event()
        self._failed: tuple[float, Unavailable] | None = None
        self._silence = NodeSilence()
        self._silence_lock = threading.Lock()
        self._renewal: threading.Thread | None = None

    def session(self) -> Session:
        """Return the session.

        Raises
        ------
        Unavailable
            The cluster cannot be reached, or the link is closed.
        """
        return self._current().session

    def statement(self, cql: str) -> PreparedStatement:
        """Return a statement, prepared once a session."""
        opened = self._current()
        if cql not in opened.prepared:
            with self._preparing:
                statement = opened.session.prepare(cql)
                # Writes may be retried by the driver, except conditional ones.
                statement.is_idempotent = " IF " not in cql
                opened.prepared[cql] = statement
        return opened.prepared[cql]

    def responded(self) -> None:
        """Note that a node responded to a request."""
        self._silence.end()

    def unanswered(self) -> None:
        """Note that no node responded to a request; connect again in the background after ``SILENCE``."""
        with self._silence_lock:
            if self._opened is not None and self._renewal is None and self._silence.begin():
                self._renewal = threading.Thread(target=self._renew, name="cassandra-connect", daemon=True)
                self._renewal.start()

    def close(self) -> None:
        """Close the connections."""
        self._closed.set()
        with self._opening:
            if self._opened is not None:
                self._opened.session.cluster.shutdown()

    # -- internals -----------------------------------------------------------------------------------------------------

    def _current(self) -> _Opened:
        if self._closed.is_set():
            raise unusable(self._address, "the store is closed")
        if self._opened is None:
            with self._opening:
                if self._opened is None:
                    self._opened = _Opened(self._open())
        return self._opened

    def _open(self) -> Session:
        """Connect. Within `RECONNECT` of a failure, raise the same error again without another attempt."""
        if self._failed is not None and monotonic() < self._failed[0]:
            raise self._failed[1]
        try:
            with driver_errors(self._address):
                return connect(self._address, create=self._create)
        except Unavailable as error:
            self._failed = monotonic() + RECONNECT, error
            raise

    def _renew(self) -> None:
        try:
            with driver_errors(self._address):
                session = connect(self._address, create=False)
            self._replace(session)
        except (Unavailable, InvalidInput) as error:
            logger.warning("cannot connect to Cassandra again: %s", error)
        finally:
            with self._silence_lock:
                self._renewal = None

    def _replace(self, session: Session) -> None:
        """Use a session from now on. The former one is closed after the time limit of the requests that still run."""
        with self._opening:
            assert self._opened is not None
            former = session if self._closed.is_set() else self._opened.session
            if former is not session:
                self._opened = _Opened(session)
        if former is not session:
            logger.warning("connected to %s again, because no node had responded", self._address)
            self._closed.wait(self._address.timeout)
        former.cluster.shutdown()
