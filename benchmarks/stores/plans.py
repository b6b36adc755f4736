"""Bench of a plan store as it fills: rates of writes, times of lookups, and bytes per plan, with baselines."""

import os
import sqlite3
import tempfile
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import cycle
from pathlib import Path
from time import process_time, sleep
from typing import TYPE_CHECKING, Any

import numpy as np

from benchmarks.stores import baselines
from benchmarks.stores.routes import MAP, VERSION, Routes, routes
from ppaas.clock import monotonic
from ppaas.errors import Conflict
from storage.plan_query import PlanStoreQuery
from storage.ports import Store
from storage.records import PlanRecord
from storage.urls.opening import open_store

if TYPE_CHECKING:
    from rich.progress import Progress

AT_ONCE = 1000
ONE_BY_ONE, LOOKUPS, READS = 1000, 2000, 500
PAGE, PAGES = bytes(4096), 1024
WRITERS = 8
"""Number of threads that write single plans at once, as a server does for robots."""
TOLERANCE = 0.25
SIZES = (1_000, 10_000, 100_000, 1_000_000)


@dataclass(frozen=True, slots=True)
class PlanStoreOptions:
    """Options of the bench.

    Parameters
    ----------
    plans : int
        Number of plans.
    folder : Path
        Folder for planned routes and temporary files.
    store : str, optional
        URL of the store; by default a temporary SQLite file.
    smooth : bool
        Whether to smooth the plans.
    seed : int
        Seed of the routes.
    rest : float
        Pause without writes before lookups are measured again [s]; 0 for none.
    warm : int
        Number of warm-up lookups after the pause.
    """

    plans: int
    folder: Path
    store: str | None = None
    smooth: bool = False
    seed: int = 1
    rest: float = 0.0
    warm: int = 0


@dataclass(frozen=True, slots=True)
class _Took:
    """Wall-clock time and CPU time of an operation [s]; the latter excludes waits for the disk and other processes."""

    seconds: float = 0.0
    processor: float = 0.0

    def __add__(self, other: "_Took") -> "_Took":
        return _Took(self.seconds + other.seconds, self.processor + other.processor)


def measure(options: PlanStoreOptions, progress: "Progress") -> dict[str, Any]:
    """Fill a store, and measure it at each of ``SIZES``.

    Raises
    ------
    Conflict
        The store has plans of an earlier run.
    """
    driven = routes(options.plans, options.seed, options.folder, progress)
    told: dict[str, Any] = {"store": options.store or "sqlite", "smooth": options.smooth, "sizes": []}
    told["yardsticks"] = baselines.measure(driven, options.plans, options.folder, progress, smooth=options.smooth)
    with tempfile.TemporaryDirectory(prefix="ppaas-bench-", dir=options.folder) as name:
        file = Path(name) / "plans.db"
        store = open_store(options.store or f"sqlite://{file}")
        try:
            if store.plan_statistics(MAP).plans:
                raise Conflict(f"the store already has plans of map {MAP!r}: give another store, or remove them")
            sizes = [size for size in SIZES if size < options.plans]
            for row in _fill(store, driven, [*sizes, options.plans], options, progress):
                told["sizes"].append(row | _bytes_a_plan(file, row["plans"]))
        finally:
            store.close()
    return told


def _fill(
    store: Store, driven: Routes, sizes: list[int], options: PlanStoreOptions, progress: "Progress"
) -> Iterator[dict[str, Any]]:
    task, kept, smooth = progress.add_task("keeping plans", total=sizes[-1]), 0, options.smooth
    for size in sizes:
        alone = min(ONE_BY_ONE, size // 20)
        in_bulk, bulk = 0, _Took()
        while kept < size - 2 * alone:
            batch = list(driven.records(kept, min(kept + AT_ONCE, size - 2 * alone), smooth=smooth))
            bulk += _took(lambda batch=batch: store.add_plans(batch))  # type: ignore[misc]
            in_bulk += len(batch)
            kept += len(batch)
            progress.update(task, completed=kept)
        singles = list(driven.records(kept, size - alone, smooth=smooth))
        together = list(driven.records(size - alone, size, smooth=smooth))
        rates = _one_by_one(store, singles, together, options.folder)
        kept = size
        yield (
            _state(store, driven, size, smooth)
            | rates
            | {
                "bulk_per_second": in_bulk / bulk.seconds,
                "bulk_per_processor_second": in_bulk / bulk.processor,
            }
            | (_rested(store, driven, size, options) if options.rest else {})
        )
    progress.remove_task(task)


def _one_by_one(store: Store, singles: list[PlanRecord], together: list[PlanRecord], folder: Path) -> dict[str, float]:
    """Write single plans, each acknowledged before the next: first from one thread, then from several.

    Before each plan of the first thread, a page is written and synced as a baseline for durable writes.
    """
    single, page = _Took(), _Took()
    with _synced_page(folder) as write_page:
        for each in singles:
            page += _took(write_page)
            single += _took(lambda each=each: store.add_plan(each))  # type: ignore[misc]
    with ThreadPoolExecutor(WRITERS) as threads:
        several = _took(lambda: list(threads.map(store.add_plan, together)))
    return {
        "single_per_second": len(singles) / single.seconds,
        "single_per_processor_second": len(singles) / single.processor,
        "pages_synced_per_second": len(singles) / page.seconds,
        "several_per_second": len(together) / several.seconds,
    }


@contextmanager
def _synced_page(folder: Path) -> Iterator[Callable[[], None]]:
    """Yield a function that overwrites one page of a file of constant size, and syncs it."""
    with tempfile.TemporaryFile(dir=folder, buffering=0) as file:
        file.write(PAGE * PAGES)
        os.fsync(file.fileno())
        places = cycle(range(0, len(PAGE) * PAGES, len(PAGE)))

        def write() -> None:
            os.pwrite(file.fileno(), PAGE, next(places))
            os.fdatasync(file.fileno())

        yield write


def _looked_for(store: Store, driven: Routes, size: int) -> dict[str, Any]:
    """Look up random plans with positions near their ends, and read some of them by id."""
    sought = list(_sought(driven, size, LOOKUPS, size))
    lookups = [
        _took(lambda record=record, off=off: _find(store, record, off))  # type: ignore[misc]
        for record, off in sought
    ]
    reads = [_took(lambda record=record: store.plan(record.id)) for record, _ in sought[:READS]]  # type: ignore[misc]
    return {
        "lookup_ms": _percentiles([each.seconds for each in lookups]),
        "lookup_processor_ms": _percentiles([each.processor for each in lookups]),
        "read_ms": _percentiles([each.seconds for each in reads]),
        "read_processor_ms": _percentiles([each.processor for each in reads]),
    }


def _sought(driven: Routes, size: int, count: int, seed: int) -> Iterator[tuple[PlanRecord, list[float]]]:
    """Yield random plans, and the offsets [m] from their ends at which they are looked up."""
    random = np.random.default_rng(seed)
    numbers = random.integers(0, size, count).tolist()
    offsets = random.uniform(-0.6 * TOLERANCE, 0.6 * TOLERANCE, (count, 4)).tolist()
    return ((driven.record(number), off) for number, off in zip(numbers, offsets, strict=True))


def _rested(store: Store, driven: Routes, size: int, options: PlanStoreOptions) -> dict[str, Any]:
    """Measure lookups after a pause without writes, in which a store may compact its data.

    Warm-up lookups come first, as the JVM of a store compiles hot code.
    """
    sleep(options.rest)
    for record, off in _sought(driven, size, options.warm, size + 1):
        _find(store, record, off)
    return {f"rested_{name}": told for name, told in _looked_for(store, driven, size).items()}


def _state(store: Store, driven: Routes, size: int, smooth: bool) -> dict[str, Any]:
    found = _looked_for(store, driven, size)
    for record in driven.records(0, 3, smooth=smooth):
        if store.plan(record.id) != record:
            raise Conflict(f"the store returned plan {record.id!r} with other content than was written")
    counts = store.plan_statistics(MAP)
    return {
        "plans": size,
        **found,
        "waypoints_a_plan": counts.waypoints / counts.plans,
        "kept_once": counts.waypoints / counts.kept,
        "entries": counts.entries,
        "data_bytes_a_plan": counts.bytes / counts.plans,
    }


def _find(store: Store, record: PlanRecord, off: list[float]) -> None:
    start = record.start[0] + off[0], record.start[1] + off[1]
    goal = record.goal[0] + off[2], record.goal[1] + off[3]
    if not store.find_plans(PlanStoreQuery(MAP, VERSION, start, goal, TOLERANCE)):
        raise Conflict(f"the store did not find plan {record.id!r} by its ends")


def _bytes_a_plan(file: Path, plans: int) -> dict[str, float]:
    """Return the size of the SQLite file per plan, with tables and indexes; empty if there is no file."""
    if not file.exists():
        return {}
    with sqlite3.connect(file) as connection:
        connection.execute("PRAGMA wal_checkpoint")
        pages, free, size = (
            connection.execute(f"PRAGMA {name}").fetchone()[0] for name in ("page_count", "freelist_count", "page_size")
        )
    connection.close()
    return {"file_bytes_a_plan": (pages - free) * size / plans}


def _percentiles(seconds: list[float]) -> dict[str, float]:
    middle, late = np.percentile(seconds, (50, 99)) * 1e3
    return {"p50": float(middle), "p99": float(late)}


def _took(work: Callable[[], object]) -> _Took:
    on_processor, began = process_time(), monotonic()
    work()
    return _Took(monotonic() - began, process_time() - on_processor)
