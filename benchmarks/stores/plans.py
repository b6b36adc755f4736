"""How a store of plans does as it fills: how fast it takes and finds them, and what they take, beside yardsticks."""

import os
import sqlite3
import tempfile
import zlib
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import cycle, islice
from pathlib import Path
from time import process_time, sleep
from typing import TYPE_CHECKING, Any

import numpy as np

from benchmarks.stores.greedy_split import GreedySplit
from benchmarks.stores.routes import MAP, VERSION, Routes, routes
from ppaas.clock import monotonic
from ppaas.errors import Conflict
from ppaas.plans.encoding.chunks import GRANULARITY, waypoint_hashes, words_of
from storage.plan_checks import array_of
from storage.plan_query import PlanSearch
from storage.ports import Store
from storage.records import PlanRecord
from storage.urls.opening import open_store

if TYPE_CHECKING:
    from rich.progress import Progress

AT_ONCE = 1000
ONE_BY_ONE, LOOKUPS, READS = 1000, 2000, 500
PAGE, PAGES = bytes(4096), 1024
WRITERS = 8
"""Threads that keep plans one by one at a time, as a server does for robots."""
TOLERANCE = 0.25
SIZES = (1_000, 10_000, 100_000, 1_000_000)
COMPARED = 2_000
"""Plans that are laid over each other as the paper has it, and kept raw, beside which the store is measured."""


@dataclass(frozen=True, slots=True)
class Options:
    """What is asked for: how many plans, of what kind, where they are kept; ``folder`` keeps planned routes.

    After ``rest`` seconds in which nothing is written plans are looked for once more, behind ``warm`` lookups that are
    not measured.
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
    """What something took [s]: by the clock, and of a processor alone, which waits for no disk and no neighbour."""

    seconds: float = 0.0
    processor: float = 0.0

    def __add__(self, other: "_Took") -> "_Took":
        return _Took(self.seconds + other.seconds, self.processor + other.processor)


def measure(options: Options, progress: "Progress") -> dict[str, Any]:
    """Fill a store, and tell at each of ``SIZES`` how it does.

    Raises
    ------
    Conflict
        The store has plans of an earlier run, which would be counted too.
    """
    driven = routes(options.plans, options.seed, options.folder, progress)
    told: dict[str, Any] = {"store": options.store or "sqlite", "smooth": options.smooth, "sizes": []}
    told["yardsticks"] = _yardsticks(driven, options, progress)
    with tempfile.TemporaryDirectory(prefix="ppaas-bench-", dir=options.folder) as name:
        file = Path(name) / "plans.db"
        store = open_store(options.store or f"sqlite://{file}")
        try:
            if store.plan_statistics(MAP).plans:
                raise Conflict(f"the store has plans of the map {MAP!r} already: give another, or remove them")
            sizes = [size for size in SIZES if size < options.plans]
            for row in _fill(store, driven, [*sizes, options.plans], options, progress):
                told["sizes"].append(row | _bytes_a_plan(file, row["plans"]))
        finally:
            store.close()
    return told


def _fill(
    store: Store, driven: Routes, sizes: list[int], options: Options, progress: "Progress"
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
    """Keep plans one at a time, each acknowledged for itself: first from one thread, then from several.

    Before each of the first a page is written in the folder and synced, the least that something that lasts takes.
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
    """Give what writes one of the pages of a file that does not grow, and syncs it."""
    with tempfile.TemporaryFile(dir=folder, buffering=0) as file:
        file.write(PAGE * PAGES)
        os.fsync(file.fileno())
        places = cycle(range(0, len(PAGE) * PAGES, len(PAGE)))

        def write() -> None:
            os.pwrite(file.fileno(), PAGE, next(places))
            os.fdatasync(file.fileno())

        yield write


def _looked_for(store: Store, driven: Routes, size: int) -> dict[str, Any]:
    """Look for some of the plans, near their ends, and read some of these."""
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
    """Yield some of the first plans, and how far off their ends they are looked for."""
    random = np.random.default_rng(seed)
    numbers = random.integers(0, size, count).tolist()
    offsets = random.uniform(-0.6 * TOLERANCE, 0.6 * TOLERANCE, (count, 4)).tolist()
    return ((driven.record(number), off) for number, off in zip(numbers, offsets, strict=True))


def _rested(store: Store, driven: Routes, size: int, options: Options) -> dict[str, Any]:
    """Do the same once nothing has been written for some time: a store may bring order into it until then.

    Some are looked for before, since a store may also compile what it does often.
    """
    sleep(options.rest)
    for record, off in _sought(driven, size, options.warm, size + 1):
        _find(store, record, off)
    return {f"rested_{name}": told for name, told in _looked_for(store, driven, size).items()}


def _state(store: Store, driven: Routes, size: int, smooth: bool) -> dict[str, Any]:
    found = _looked_for(store, driven, size)
    for record in driven.records(0, 3, smooth=smooth):
        if store.plan(record.id) != record:
            raise Conflict(f"the store gives another plan {record.id!r} than it was given")
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
    if not store.find_plans(PlanSearch(MAP, VERSION, start, goal, TOLERANCE)):
        raise Conflict(f"the store does not find plan {record.id!r}")


def _bytes_a_plan(file: Path, plans: int) -> dict[str, float]:
    """Return what the file takes for each plan, if there is one: tables, indexes and all."""
    if not file.exists():
        return {}
    with sqlite3.connect(file) as connection:
        connection.execute("PRAGMA wal_checkpoint")
        pages, free, size = (
            connection.execute(f"PRAGMA {name}").fetchone()[0] for name in ("page_count", "freelist_count", "page_size")
        )
    connection.close()
    return {"file_bytes_a_plan": (pages - free) * size / plans}


def _yardsticks(driven: Routes, options: Options, progress: "Progress") -> dict[str, float]:
    """Tell what others would make of some of the plans."""
    count = min(COMPARED, options.plans)
    greedy = GreedySplit(GRANULARITY)
    raw = zipped = seconds = 0.0
    task = progress.add_task("comparing", total=count)
    with tempfile.TemporaryDirectory(dir=options.folder) as name, sqlite3.connect(Path(name) / "raw.db") as connection:
        connection.execute("PRAGMA journal_mode = WAL")
        connection.execute("CREATE TABLE plans (id TEXT PRIMARY KEY, poses BLOB)")
        records = driven.records(0, count, smooth=options.smooth)
        while batch := list(islice(records, AT_ONCE)):
            rows = [(record.id, record.poses) for record in batch]
            seconds += _took(lambda rows=rows: _insert(connection, rows)).seconds  # type: ignore[misc]
            for record in batch:
                greedy.add(waypoint_hashes(words_of(array_of(record.poses))).tolist())
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


def _insert(connection: sqlite3.Connection, rows: list[tuple[str, bytes]]) -> None:
    with connection:
        connection.executemany("INSERT INTO plans VALUES (?, ?)", rows)


def _percentiles(seconds: list[float]) -> dict[str, float]:
    middle, late = np.percentile(seconds, (50, 99)) * 1e3
    return {"p50": float(middle), "p99": float(late)}


def _took(work: Callable[[], object]) -> _Took:
    on_processor, began = process_time(), monotonic()
    work()
    return _Took(monotonic() - began, process_time() - on_processor)
