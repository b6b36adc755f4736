"""Table of open connections, limited in all and for one address, and by the files that the process may open."""

import ipaddress
import logging
import resource
from typing import Protocol

logger = logging.getLogger(__name__)

MAX_CONNECTIONS = 10_000
"""Largest number of connections of a cloud, unless the limit of open files is lower."""

RESERVED_FILES = 256
"""Number of open files that are not available to connections: of stores, machines and the log. At most a quarter."""

FILES_PER_CONNECTION = 2
"""Largest number of open files that a connection of a client takes: its socket, and the link to a container."""

REARM = 0.9
"""Share of a limit below which reaching it is logged again."""


def default_limit(files: int) -> int:
    """Return the default limit of connections for a limit of open files."""
    reserved = min(RESERVED_FILES, files // 4)
    return max(1, min(MAX_CONNECTIONS, (files - reserved) // FILES_PER_CONNECTION))


def address_key(host: str) -> str:
    """Return the address that connections are counted by: an IPv4 address, or the /64 network of an IPv6 address."""
    if ":" not in host:
        return host
    try:
        address = ipaddress.IPv6Address(host.partition("%")[0])
    except ValueError:
        return host
    mapped = address.ipv4_mapped
    return str(mapped) if mapped is not None else str(ipaddress.IPv6Network((int(address) >> 64 << 64, 64)))


class _Limit:
    """One limit, which logs when it is reached."""

    def __init__(self, most: int, option: str) -> None:
        self._most = most
        self._option = option
        self._logged = False

    def reached(self, count: int, whose: str) -> bool:
        """Return whether a further connection exceeds the limit; log it, once until there are fewer."""
        if count < self._most:
            self._logged = self._logged and count >= self._most * REARM
            return False
        if not self._logged:
            logger.warning(
                "%s: %d connections are open, the limit; those without a request are closed, then new ones refused. "
                "See %s",
                whose,
                self._most,
                self._option,
            )
            self._logged = True
        return True


class Evictable(Protocol):
    """Connection that may have to make room for another."""

    def make_room(self) -> None:
        """Close the connection, which waits for a request."""


class ConnectionTable:
    """Open connections by address. At a limit, the one that has waited longest for a request makes room.

    Parameters
    ----------
    most : int
        Largest number of connections.
    most_of_address : int, optional
        Largest number of connections from one address; by default half of ``most``, so that one address cannot keep
        out all others, and a fleet behind one address finds room.
    """

    def __init__(self, most: int = MAX_CONNECTIONS, most_of_address: int | None = None) -> None:
        self._open: dict[Evictable, _Address] = {}
        self._waiting: dict[Evictable, None] = {}
        self._addresses: dict[str, _Address] = {}
        self.limit(most, most_of_address)

    def __len__(self) -> int:
        """Return the number of open connections."""
        return len(self._open)

    def limit(self, most: int, most_of_address: int | None) -> None:
        """Admit another number of connections from now on; those beyond it stay open."""
        self._most_of_address = max(1, most // 2) if most_of_address is None else most_of_address
        self._limit = _Limit(most, "--max-connections")
        for address in self._addresses.values():
            address.limit = _Limit(self._most_of_address, "--max-connections-per-address")

    def admit(self, connection: Evictable, host: str) -> bool:
        """Add a new connection from an address; it waits for its first request.

        Returns
        -------
        bool
            False if it must be closed at once: a limit is reached, and no connection waits for a request.
        """
        key = address_key(host)
        known = self._addresses.get(key)
        if known is not None and known.limit.reached(known.count, key) and not self._evict(known.waiting):
            return False
        if self._limit.reached(len(self._open), "this cloud") and not self._evict(self._waiting):
            return False
        address = self._addresses.setdefault(key, _Address(key, self._most_of_address))
        address.count += 1
        self._open[connection] = address
        self.wait(connection)
        return True

    def wait(self, connection: Evictable) -> None:
        """Note that a connection waits for a request, so it may have to make room."""
        address = self._open.get(connection)
        if address is not None:
            self._waiting[connection] = address.waiting[connection] = None

    def serve(self, connection: Evictable) -> None:
        """Note that a connection has made a request."""
        address = self._open.get(connection)
        if address is not None:
            self._waiting.pop(connection, None)
            address.waiting.pop(connection, None)

    def leave(self, connection: Evictable) -> None:
        """Remove a connection that has ended."""
        self.serve(connection)
        address = self._open.pop(connection, None)
        if address is not None:
            address.count -= 1
            if not address.count:
                del self._addresses[address.key]

    def _evict(self, waiting: dict[Evictable, None]) -> bool:
        connection = next(iter(waiting), None)
        if connection is None:
            return False
        self.leave(connection)
        connection.make_room()
        return True


class _Address:
    """Connections of one address."""

    def __init__(self, key: str, most: int) -> None:
        self.key = key
        self.limit = _Limit(most, "--max-connections-per-address")
        self.count = 0
        self.waiting: dict[Evictable, None] = {}


# Limit of open files of the web process, which bounds its connections.

MAX_FILES = 1 << 20
"""Limit of open files that is enough for any cloud; a higher one makes some programs slow."""


def raise_file_limit() -> int:
    """Raise the limit of open files of this process to its hard limit; return the limit."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = MAX_FILES if hard == resource.RLIM_INFINITY else min(hard, MAX_FILES)
    if soft == resource.RLIM_INFINITY or soft >= wanted:
        return MAX_FILES if soft == resource.RLIM_INFINITY else soft
    try:
        resource.setrlimit(resource.RLIMIT_NOFILE, (wanted, hard))
    except (OSError, ValueError) as error:
        logger.warning("the limit of open files stays %d: %s", soft, error)
        return soft
    return wanted


def connection_table(files: int, most: int | None, most_of_address: int | None) -> ConnectionTable:
    """Return the table of connections for a limit of open files; see `connection_limits`."""
    return ConnectionTable(*connection_limits(files, most, most_of_address))


def connection_limits(files: int, most: int | None, most_of_address: int | None) -> tuple[int, int | None]:
    """Return the limits of connections for a limit of open files, in all and for one address.

    Parameters
    ----------
    files : int
        Limit of open files.
    most, most_of_address : int, optional
        Limits of connections that the administrator gave, in all and for one address.
    """
    possible = default_limit(files)
    if most is None:
        most = possible
        logger.info("up to %d connections, of %d open files (ulimit -n)", most, files)
    elif most * FILES_PER_CONNECTION > files:
        logger.warning(
            "--max-connections %d needs more open files than this process may have, %d: raise ulimit -n", most, files
        )
        most = min(most, possible)
    return most, most_of_address
