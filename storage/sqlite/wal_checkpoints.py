"""What was committed to an SQLite file's WAL is brought to the file beside those who write, and not by one of them.

Of a large file a checkpoint writes a thousand pages from all over it, and waits for the disk.
"""

import logging
import sqlite3
import threading
from collections.abc import Callable
from contextlib import closing

logger = logging.getLogger(__name__)

CHANGED_ROWS = 4096
"""Rows changed after which a checkpoint begins. A row changes about one page; the same pages change again and again, so
that one of many rows writes less than several of few."""


class Checkpoints:
    """Has a thread of its own bring commits to a file, once there are some.

    Whoever commits still does it where the WAL grows too long all the same (``PRAGMA wal_autocheckpoint``): that is how
    the WAL begins anew while others write all the time, and what becomes of a disk that fails is told to somebody.

    Parameters
    ----------
    connect : callable
        Opens a connection to the file.
    """

    def __init__(self, connect: Callable[[], sqlite3.Connection]) -> None:
        self._connect = connect
        self._lock = threading.Lock()
        self._changed = 0
        self._due = threading.Event()
        self._thread: threading.Thread | None = None
        self._closed = False

    def committed(self, rows: int) -> None:
        """Count rows that a commit changed."""
        with self._lock:
            self._changed += rows
            if self._changed < CHANGED_ROWS or self._closed:
                return
            self._changed = 0
            if self._thread is None:
                self._thread = threading.Thread(target=self._run, name="sqlite-checkpoints", daemon=True)
                self._thread.start()
        self._due.set()

    def close(self) -> None:
        """Return when no checkpoint runs, and none will."""
        with self._lock:
            self._closed = True
        self._due.set()
        if self._thread is not None:
            self._thread.join()

    def _run(self) -> None:
        while self._due.wait() and not self._closed:
            self._due.clear()
            try:
                with closing(self._connect()) as connection:
                    connection.execute("PRAGMA wal_checkpoint(PASSIVE)").fetchone()
            except sqlite3.Error as error:
                # Whoever finds the WAL too long is told what is wrong.
                logger.warning("commits were not brought to their file: %s", error)
