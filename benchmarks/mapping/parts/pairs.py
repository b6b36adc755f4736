"""Part ``pairs``: maps of different buildings, and of places that look alike, which must not be merged."""

import itertools
from collections.abc import Callable
from functools import partial
from time import process_time
from typing import Any

from benchmarks.harness.figures import Figure
from benchmarks.harness.parts import PartResult
from benchmarks.mapping.parts.mapped import mapped
from benchmarks.mapping.parts.merge_worlds import WORLDS
from benchmarks.mapping.parts.merging import warm_up
from benchmarks.mapping.parts.part import SlamOptions, name_of
from ppaas.errors import MapsNotMerged
from ppaas.mapping.merging.merge import merge
from ppaas.mapping.scan_log import ScanLog
from ppaas.mapping.serialization.mapping import Mapping
from robots.recordings.scan_logs import read_scan_log


def measure(options: SlamOptions) -> PartResult:
    """Try to merge each two of the simulated worlds; with ``all_pairs``, of the logs, too, and in both directions."""
    warm_up()
    logs: dict[str, Callable[[], ScanLog]] = {name: partial(_simulated, name) for name in WORLDS}
    if options.all_pairs:
        logs |= {name_of(log): partial(read_scan_log, log) for log in (*options.logs, *options.recorded())}
    maps = {name: mapped(options.folder, name, read).mapping for name, read in logs.items()}
    choose = itertools.permutations if options.all_pairs else itertools.combinations
    results = [tried(one, other, maps) for one, other in choose(maps, 2)]
    false = sum(result["merged"] for result in results)
    note = f"of {len(results)} pairs; the longest took {max(result['cpu_s'] for result in results):.0f} s of CPU"
    figure = Figure("pairs", "false merges among different buildings", false, "", limit=0.0, note=note)
    return PartResult([figure], list(map(row, results)), results)


def tried(one: str, other: str, maps: dict[str, Mapping]) -> dict[str, Any]:
    """Return the result of a merge of two maps."""
    begin, why = process_time(), ""
    try:
        merge(maps[one], maps[other])
    except MapsNotMerged as error:
        why = str(error)
    return {"different": [one, other], "merged": not why, "cpu_s": round(process_time() - begin, 2), "why": why}


def row(result: dict[str, Any]) -> dict[str, str]:
    """Return the row of the table for a result."""
    one, other = result["different"]
    merged = "yes" if result["merged"] else "no"
    return {
        "first": one,
        "second": other,
        "merged": merged,
        "cpu s": f"{result['cpu_s']:.1f}",
        "refused": result["why"],
    }


def _simulated(name: str) -> ScanLog:
    return WORLDS[name]().log
