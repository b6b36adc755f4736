"""Limit of open files of the web process, which bounds its connections."""

import logging
import resource

from endpoints.http.connection_table import FILES_PER_CONNECTION, ConnectionTable, default_limit

logger = logging.getLogger(__name__)

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
    """Return the table of connections for a limit of open files.

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
    return ConnectionTable(most, most_of_address)
