"""What Cassandra and its driver say, as ``Unavailable`` with a text that says what to do."""

from collections.abc import Iterator
from contextlib import contextmanager

from cassandra import (
    AuthenticationFailed,
    DriverException,
    InvalidRequest,
    OperationTimedOut,
    ReadTimeout,
    Unauthorized,
    WriteTimeout,
)
from cassandra import Unavailable as TooFewReplicas
from cassandra.cluster import NoHostAvailable
from cassandra.connection import ConnectionException
from cassandra.protocol import ErrorMessage

from ppaas.errors import Unavailable

_REFUSED = "user or password are refused: correct them in the URL"
_LATE = "no answer in time: look whether its nodes are overloaded; what was being written may or may not be kept"

_ADVICE: tuple[tuple[type[Exception] | tuple[type[Exception], ...], str], ...] = (
    ((OperationTimedOut, WriteTimeout, ReadTimeout), _LATE),
    (TooFewReplicas, "too few of its nodes are up for the wanted consistency: start them, or ask for less in the URL"),
    (AuthenticationFailed, _REFUSED),
    (Unauthorized, "the user lacks a permission: grant it"),
    (InvalidRequest, "the keyspace is not as this release made it: restore it, or give another"),
)


@contextmanager
def driver_errors(place: object) -> Iterator[None]:
    """Turn what the driver raises inside the block into ``Unavailable``."""
    try:
        yield
    except (NoHostAvailable, DriverException, ErrorMessage, ConnectionException, OSError) as error:
        raise Unavailable(f"{place}: {_advice(error)}") from error


def _advice(error: Exception) -> str:
    if isinstance(error, NoHostAvailable):
        return _no_host(error)
    advice = next((text for kinds, text in _ADVICE if isinstance(error, kinds)), type(error).__name__)
    return f"{advice} ({error})"


def _no_host(error: NoHostAvailable) -> str:
    errors = list(error.errors.values()) if isinstance(error.errors, dict) else []
    if any(isinstance(one, AuthenticationFailed) for one in errors):
        return _REFUSED
    first = f" ({errors[0]})" if errors else ""
    return f"no node answers: start Cassandra, or correct the hosts and the port in the URL{first}"
