"""``ppaas bench plans``: speed and size of the Path Plan Database as it fills."""

import argparse
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ppaas.bounded import whole
from robots.cli.benches import Measured

if TYPE_CHECKING:
    from rich.progress import Progress

HELP = "the Path Plan Database as it fills: rates of writes, times of lookups, bytes per plan"

Row = dict[str, str]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument(
        "--plans", type=whole(100, 10_000_000), default=100_000, metavar="N", help="number of plans (%(default)s)"
    )
    parser.add_argument("--store", metavar="URL", help="store of the plans (a temporary SQLite file)")
    parser.add_argument("--smooth", action="store_true", help="smooth the plans: fewer waypoints are on the grid")
    parser.add_argument("--seed", type=int, default=1, help="seed of the plans (%(default)s)")
    parser.add_argument(
        "--rest", type=whole(0, 600), default=0, metavar="S",
        help="measure lookups again after a pause of S seconds without writes",
    )  # fmt: skip
    parser.add_argument(
        "--warm", type=whole(0, 1_000_000), default=0, metavar="N",
        help="warm-up lookups after the pause, for the compiler of a store's JVM",
    )  # fmt: skip
    parser.add_argument("--cache", type=Path, metavar="FOLDER", help="folder for the planned routes")


def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
    """Return the results, and their table."""
    from benchmarks.stores import plans  # noqa: PLC0415 - ``ppaas bench --help`` loads this

    options = plans.PlanStoreOptions(
        arguments.plans,
        arguments.cache or _cache(),
        arguments.store,
        arguments.smooth,
        arguments.seed,
        arguments.rest,
        arguments.warm,
    )
    options.folder.mkdir(parents=True, exist_ok=True)
    told = plans.measure(options, progress)
    return Measured(told, rows_of(told))


def rows_of(told: dict[str, Any]) -> list[Row]:
    """Return a row for each size, and one for each baseline."""
    rows = [
        {
            "plans": f"{size['plans']:,}",
            "in bulk /s": f"{size['bulk_per_second']:,.0f}",
            "/s of a core": f"{size['bulk_per_processor_second']:,.0f}",
            "one by one /s": f"{size['single_per_second']:,.0f}",
            "a page synced /s": f"{size['pages_synced_per_second']:,.0f}",
            "by 8 at a time /s": f"{size['several_per_second']:,.0f}",
            "lookup p50 ms": f"{size['lookup_ms']['p50']:.2f}",
            "p99": f"{size['lookup_ms']['p99']:.2f}",
            **_after_rest(size),
            "read p50 ms": f"{size['read_ms']['p50']:.2f}",
            "bytes a plan": f"{size.get('file_bytes_a_plan', size['data_bytes_a_plan']):,.0f}",
            "waypoints ÷ kept": f"{size['kept_once']:.1f}",
        }
        for size in told["sizes"]
    ]
    others = told["yardsticks"]
    raw = {"plans": f"raw, {others['plans']:,}", "in bulk /s": f"{others['raw_sqlite_per_second']:,.0f}"}
    raw["bytes a plan"] = f"{others['raw_bytes_a_plan']:,.0f}; zlib {others['zlib_bytes_a_plan']:,.0f}"
    greedy = {"plans": f"greedy split, {others['plans']:,}", "waypoints ÷ kept": f"{others['greedy_kept_once']:.1f}"}
    return [dict.fromkeys(rows[0], "") | row for row in (*rows, raw, greedy)]


def _after_rest(size: dict[str, Any]) -> Row:
    found = size.get("rested_lookup_ms")
    return {"after a rest p50 / p99": f"{found['p50']:.2f} / {found['p99']:.2f}"} if found else {}


def _cache() -> Path:
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "ppaas"
