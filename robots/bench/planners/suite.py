"""All that ``docs/performance.md`` tells of planners, measured in one run."""

import asyncio
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.progress import Progress

from ppaas.errors import InvalidInput
from ppaas.maps.generate import warehouse
from ppaas.planners import planner_names
from robots.bench.planners import compare, field, grids, lengths, scaling, scenario
from robots.bench.planners.timing import cpus

ROS_MAPS = ("warehouse.yaml", "depot.yaml", "tb3_sandbox.yaml", "willow_costmap.pgm")

COMPARED = ("warehouse.yaml", "willow_costmap.pgm")
"""Of these, on which peers are measured too."""

Told = list[dict[str, Any]]


@dataclass(frozen=True, slots=True)
class Options:
    """What to measure.

    Parameters
    ----------
    data : Path, optional
        Folder with real maps, ``ros/`` and ``movingai/``; without it only grids that are made up.
    only : tuple of str
        Parts; none of them means all.
    quick : bool
        Small grids and few queries: to see that it runs, not to compare.
    """

    data: Path | None = None
    only: tuple[str, ...] = ()
    quick: bool = False

    @property
    def size(self) -> int:
        """Edge of the grids that are made up."""
        return 256 if self.quick else 4096

    @property
    def threads(self) -> list[int]:
        """Numbers of threads."""
        return sorted({1, cpus()})


def measure(options: Options, progress: Progress) -> Iterator[tuple[str, Told]]:
    """Measure part by part; yield each with what was measured.

    Raises
    ------
    InvalidInput
        The folder of maps is none.
    PPaaSError
        Something cannot be measured.
    """
    if options.data is not None and not options.data.is_dir():
        raise InvalidInput(f"--data is a folder with real maps, and {str(options.data)!r} is none")
    for name, part in PARTS.items():
        if not options.only or name in options.only:
            yield name, part(options, progress)


def _fields(options: Options, progress: Progress) -> Told:
    made = [make(options.size) for make in grids.KINDS.values()] + [grids.maze(options.size, 4)]
    real = [grids.from_file(path) for path in _ros_maps(options)]
    return [field.measure(grid, None, options.threads, progress) for grid in made + real]


def _scenarios(options: Options, progress: Progress) -> Told:
    files = sorted((options.data / "movingai").glob("*/*.scen")) if options.data else []
    limit = 20 if options.quick else None
    return [
        {"map": scenario.map_beside(file).stem, **scenario.measure(file, None, planner, limit, progress)}
        for file in files
        for planner in compare.OURS
        if planner in planner_names()
    ]


def _comparisons(options: Options, progress: Progress) -> Told:
    size = options.size
    made = [grids.empty(size // 2), grids.random(size // 2, 20.0), grids.random(size, 20.0)]
    real = [grids.from_file(path) for path in _ros_maps(options) if path.name in COMPARED]
    return [compare.measure(grid, None, options.threads, (), progress) for grid in made + real]


def _scaling(options: Options, progress: Progress) -> Told:
    sizes = scaling.sizes_up_to(512 if options.quick else scaling.LARGEST)
    return [scaling.measure(scaling.KINDS_SHOWN, sizes, options.threads, progress)]


def _lengths(options: Options, progress: Progress) -> Told:
    map_, points = (warehouse(seed=1), 3) if options.quick else (lengths.default_map(), lengths.POINTS)
    return [asyncio.run(lengths.measure(map_, min(2, cpus()), progress, points))]


def _ros_maps(options: Options) -> list[Path]:
    if options.data is None:
        return []
    return [path for path in (options.data / "ros" / name for name in ROS_MAPS) if path.exists()]


PARTS: dict[str, Callable[[Options, Progress], Told]] = {
    "fields": _fields,
    "comparisons": _comparisons,
    "scaling": _scaling,
    "lengths": _lengths,
    "scenarios": _scenarios,
}
