"""Translation of errors of Cassandra and its driver into ``Unavailable`` with advice for the operator."""

from collections.abc import Iterator
from contextlib import contextmanager

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
from cassandra.cluster import NoHostAvailable
from cassandra.connection import ConnectionException
from cassandra.protocol import ErrorMessage

from storage.store_errors import unusable

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
