"""Part ``pairs``: maps of different buildings, and of places that look alike, which must not be merged."""

import itertools
from collections.abc import Callable
from functools import partial
from time import process_time
from typing import Any

import numpy as np

from benchmarks.harness.figures import Figure, PartResult
from benchmarks.mapping.office import LENGTH, office, route
from benchmarks.mapping.parts.mapped import mapped
from benchmarks.mapping.parts.merging import warm_up
from benchmarks.mapping.parts.part import SlamOptions, name_of
from benchmarks.mapping.simulated_drive import Segments, SimulatedDrive, simulate
from ppaas.errors import MapsNotMerged
from ppaas.mapping.merging.merge import merge
from ppaas.mapping.scan_log import ScanLog
from ppaas.mapping.serialization.mapping import Mapping
from robots.recordings.scan_logs import read_scan_log

WIDTH = 2.2
"""Width of the corridors [m]."""

NICHE = 0.3
"""Depth of the doors of a corridor [m]."""


def mirrored_office() -> SimulatedDrive:
    """Return the drive through the office, seen in a mirror."""
    walls, points = office(0), route()
    walls[:, (0, 2)] = LENGTH - walls[:, (0, 2)]
    points[:, 0] = LENGTH - points[:, 0]
    return simulate(walls, points, 5)


def bare_corridor(length: float, seed: int) -> SimulatedDrive:
    """Return a drive to and fro in a corridor without doors [m]."""
    ends = [(0.0, 0.0, 0.0, WIDTH), (length, 0.0, length, WIDTH)]
    sides = [(0.0, y, length, y) for y in (0.0, WIDTH)]
    return simulate(np.array([*ends, *sides]), _to_and_fro(10.0, length - 10.0), seed)


def corridor_with_doors(begin: float, end: float, seed: int) -> SimulatedDrive:
    """Return a drive between two places of an 80 m long corridor, with equal doors every 5 m on both sides [m]."""
    walls = [(0.0, 0.0, 0.0, WIDTH), (80.0, 0.0, 80.0, WIDTH)]
    for y, out in ((0.0, -NICHE), (WIDTH, NICHE)):
        walls += _doors(y, y + out)
    return simulate(np.array(walls), _to_and_fro(begin, end), seed)


def _doors(wall: float, back: float) -> list[tuple[float, float, float, float]]:
    segments = []
    for left in np.arange(2.0, 80.0, 5.0).tolist():
        right = left + 1.0
        segments += [
            (left - 4.0 if left > 2.0 else 0.0, wall, left, wall), (left, wall, left, back),
            (left, back, right, back), (right, back, right, wall),
        ]  # fmt: skip
    return [*segments, (78.0, wall, 80.0, wall)]


def _to_and_fro(begin: float, end: float) -> Segments:
    return np.array([(begin, WIDTH / 2.0), (end, WIDTH / 2.0), (begin + 2.0, WIDTH / 2.0)])


WORLDS: dict[str, Callable[[], SimulatedDrive]] = {
    "office 0": lambda: simulate(office(0), route(), 0),
    "mirrored office": mirrored_office,
    "corridor of 90 m": lambda: bare_corridor(90.0, 13),
    "corridor of 110 m": lambda: bare_corridor(110.0, 14),
    "corridor with doors, part 1": lambda: corridor_with_doors(10.0, 45.0, 11),
    "corridor with doors, part 2": lambda: corridor_with_doors(35.0, 70.0, 12),
}
"""Drives by name; each two are of different buildings, or of places that look alike."""


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
