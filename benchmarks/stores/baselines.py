"""Baselines of the plan store bench: raw plans in SQLite, zlib, and the paper's greedy deduplication."""

import sqlite3
import tempfile
import zlib
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from benchmarks.stores.greedy_split import GreedySplit
from benchmarks.stores.routes import Routes
from ppaas.clock import monotonic
from ppaas.geometry import Poses
from ppaas.plans.encoding.chunks import words_of
from ppaas.plans.encoding.granularity import GRANULARITY
from ppaas.plans.encoding.kernels.chunks import hash_waypoints
from storage.plan_checks import array_of

if TYPE_CHECKING:
    from rich.progress import Progress

COMPARED = 2_000
"""Largest number of plans of the baselines."""

AT_ONCE = 1000
"""Number of plans of a transaction."""


def measure(driven: Routes, plans: int, folder: Path, progress: "Progress", *, smooth: bool) -> dict[str, float]:
    """Measure the baselines with the first plans of a fleet.

    Parameters
    ----------
    driven : Routes
    plans : int
        Number of plans of the bench; at most ``COMPARED`` of them are used.
    folder : Path
        Folder for a temporary database.
    progress : Progress
    smooth : bool
        Whether to smooth the plans.

    Returns
    -------
    dict
        Number of ``plans``; ``raw_sqlite_per_second`` and ``raw_bytes_a_plan`` of plans that are written as they are;
        ``zlib_bytes_a_plan`` if each is compressed; ``greedy_kept_once``, the ratio of all to stored waypoints of the
        greedy deduplication, and ``greedy_ids_a_plan``, the number of entries that a plan refers to.
    """
    count = min(COMPARED, plans)
    greedy = GreedySplit(GRANULARITY)
    raw = zipped = seconds = 0.0
    task = progress.add_task("baselines", total=count)
    with tempfile.TemporaryDirectory(dir=folder) as name, sqlite3.connect(Path(name) / "raw.db") as connection:
        connection.execute("PRAGMA journal_mode = WAL")
        connection.execute("CREATE TABLE plans (id TEXT PRIMARY KEY, poses BLOB)")
        records = driven.records(0, count, smooth=smooth)
        while batch := list(islice(records, AT_ONCE)):
            seconds += _insert(connection, [(record.id, record.poses) for record in batch])
            for record in batch:
                greedy.add(_hashes(array_of(record.poses)).tolist())
                raw += len(record.poses)
                zipped += len(zlib.compress(record.poses))
            progress.advance(task, len(batch))
    connection.close()
    progress.remove_task(task)
    return {
        "plans": count,
        "raw_sqlite_per_second": count / seconds,
        "raw_bytes_a_plan": raw / count,
        "zlib_bytes_a_plan": zipped / count,
        "greedy_kept_once": greedy.waypoints / greedy.kept,
        "greedy_ids_a_plan": greedy.ids_per_plan(),
    }


def _hashes(poses: Poses) -> NDArray[np.uint64]:
    """Return a hash of each pose, by which plans are cut too."""
    hashes = np.empty(len(poses), np.uint64)
    hash_waypoints(words_of(poses), hashes)
    return hashes


def _insert(connection: sqlite3.Connection, rows: list[tuple[str, bytes]]) -> float:
    """Write plans in one transaction; return the time [s]."""
    began = monotonic()
    with connection:
        connection.executemany("INSERT INTO plans VALUES (?, ?)", rows)
    return monotonic() - began
