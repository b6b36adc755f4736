"""WAL checkpoints of an SQLite file in a background thread, so that commits do not have to run them.

The checkpoint of a large file writes a thousand pages scattered over it, and waits for the disk.
"""

import logging
import sqlite3
import threading
from collections.abc import Callable
from contextlib import closing

logger = logging.getLogger(__name__)

CHANGED_ROWS = 4096
"""Number of changed rows after which a checkpoint starts. A row changes about one page. Because the same pages change
repeatedly, one checkpoint of many rows writes fewer pages than several of few."""


class WalCheckpointer:
    """Runs checkpoints in a thread, once enough rows have changed.

    If the WAL grows too long nevertheless, a commit runs the checkpoint (``PRAGMA wal_autocheckpoint``). So the WAL
    starts again from its beginning even under constant writes, and a caller gets the error of a failing disk.

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
        """Add the number of rows that a commit changed."""
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
        """Stop the thread, after a running checkpoint."""
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
                # If it persists, a commit that finds the WAL too long raises it.
                logger.warning("WAL checkpoint failed: %s", error)
