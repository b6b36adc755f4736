"""Suite of planner benches: all figures of planners in ``docs/performance.md``, measured in one run."""

import os
import platform
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Any

from rich.progress import Progress

from benchmarks.planners import compare, field, grids, index, path_lengths, peers, scaling, scenario
from benchmarks.planners.timing import cpus, within
from ppaas import __version__
from ppaas.errors import InvalidInput, InvalidPlanner, PlanTimeout
from ppaas.maps.generate import warehouse
from ppaas.planners import planner_names
from robots.cli import event_loop

ROS_MAPS = ("warehouse.yaml", "depot.yaml", "tb3_sandbox.yaml", "willow_costmap.pgm")

COMPARED = ("warehouse.yaml", "willow_costmap.pgm")
"""Maps on which peers are measured too."""

BESIDE = ("navfn", "tcod", "dijkstra3d")
"""Other implementations of a field, measured on every grid."""

PREPARED = ("hub_labels", "jps")
"""Planners that answer every query of a scenario."""
SAMPLED = ("dijkstra", "astar", "dstar_lite")
"""Other optimal planners, which answer `SAMPLE` queries spread over a scenario."""
PATIENCE = 60.0
"""Time limit of a planner to prepare the map of a scenario [s]."""
SAMPLE, QUICK_SAMPLE = 100, 10

INDEXED = "hub_labels"
"""Planner whose index is also built of generated grids."""
SCATTERED = (0.1, 0.2, 0.3, 0.5, 0.7, 1.0, 2.0)
"""Percentages of randomly blocked single cells, the worst case for an index."""
TILED = {"cities/Paris_1_512.map": 2, "cities/Boston_0_256.map": 4}
"""City maps, and the number of copies along each edge that make a grid of 1024²."""

Told = list[dict[str, Any]]


@dataclass(frozen=True, slots=True)
class PlannerSuiteOptions:
    """Options of the suite.

    Parameters
    ----------
    data : Path, optional
        Folder with real maps in ``ros/`` and ``movingai/``; without it, only generated grids are measured.
    only : tuple of str
        Names of parts; empty for all.
    quick : bool
        Whether to use small grids and few queries, as a check that all of it runs.
    """

    data: Path | None = None
    only: tuple[str, ...] = ()
    quick: bool = False

    @property
    def size(self) -> int:
        """Edge of generated grids [cells]."""
        return 256 if self.quick else 4096

    @property
    def threads(self) -> list[int]:
        """Numbers of threads."""
        return sorted({1, cpus()})


def measure(options: PlannerSuiteOptions, progress: Progress) -> Iterator[tuple[str, Told]]:
    """Measure part by part; yield each with its results.

    Raises
    ------
    InvalidInput
        The folder of maps does not exist.
    PPaaSError
        A part cannot be measured.
    """
    if options.data is not None and not options.data.is_dir():
        raise InvalidInput(f"--data must be a folder with real maps; {str(options.data)!r} is not a folder")
    yield "machine", [describe() | {"quick": options.quick}]
    for name, part in PARTS.items():
        if not options.only or name in options.only:
            yield name, part(options, progress)


def _fields(options: PlannerSuiteOptions, progress: Progress) -> Told:
    size, others = options.size, peers.beside(BESIDE)
    yet_to_make = [partial(make, size, grids.SEED) for make in grids.KINDS.values()]
    yet_to_make += [partial(grids.maze, size, 4), partial(grids.random, size // 2, 20.0)]
    yet_to_make += [partial(grids.from_file, path) for path in _ros_maps(options)]
    return [field.measure(make(), None, options.threads, progress, others=others) for make in yet_to_make]


def _scenarios(options: PlannerSuiteOptions, progress: Progress) -> Told:
    files = sorted((options.data / "movingai").glob("*/*.scen")) if options.data else []
    return [told for file in files for told in _scenario(file, options, progress)]


def _scenario(file: Path, options: PlannerSuiteOptions, progress: Progress) -> Iterator[dict[str, Any]]:
    """Run all queries with planners that prepare the map, and a sample with the others."""
    scene = scenario.read(file)
    for planner in (name for name in (*PREPARED, *SAMPLED) if name in planner_names()):
        most = QUICK_SAMPLE if options.quick else SAMPLE if planner in SAMPLED else len(scene.queries)
        asked = replace(scene, queries=scene.queries.spread(most))
        try:
            told = scenario.ask(planner, asked, progress, within(PATIENCE)) | {"of": len(scene.queries)}
        except PlanTimeout:
            told = {"left_out": {planner: f"its index takes longer than {PATIENCE:g} s"}}
        yield {"map": scene.name, **told}


def _comparisons(options: PlannerSuiteOptions, progress: Progress) -> Told:
    size = options.size
    made = [partial(grids.random, size // 2, 20.0), partial(grids.random, size, 20.0), partial(grids.empty, size // 2)]
    made += [partial(grids.from_file, path) for path in _ros_maps(options) if path.name in COMPARED]
    return [compare.measure(make(), None, options.threads, (), progress) for make in made]


def _scaling(options: PlannerSuiteOptions, progress: Progress) -> Told:
    sizes = scaling.sizes_up_to(512 if options.quick else scaling.LARGEST)
    return [scaling.measure(scaling.KINDS_SHOWN, sizes, options.threads, progress)]


def _lengths(options: PlannerSuiteOptions, progress: Progress) -> Told:
    map_, points = (warehouse(seed=1), 3) if options.quick else (path_lengths.default_map(), path_lengths.POINTS)
    return [event_loop.run(path_lengths.measure(map_, min(2, cpus()), progress, points))]


def _indexes(options: PlannerSuiteOptions, progress: Progress) -> Told:
    size = options.size // 4
    made = [partial(grids.random, size, percent) for percent in SCATTERED]
    made += [partial(grids.random, size // 2, percent) for percent in (10.0, 20.0, 30.0)]
    if options.data is not None:
        maps = [(options.data / "movingai" / name, copies) for name, copies in TILED.items()]
        made += [partial(_tiled, path, copies) for path, copies in maps if path.exists()]
    return [_index(make(), options, progress) for make in made]


def _index(grid: grids.Grid, options: PlannerSuiteOptions, progress: Progress) -> dict[str, Any]:
    queries = QUICK_SAMPLE if options.quick else index.QUERIES
    try:
        return index.measure(grid, INDEXED, options.threads, progress, queries)
    except InvalidPlanner as refused:
        return {"grid": grid.name, "left_out": {INDEXED: str(refused)}}


def _tiled(path: Path, copies: int) -> grids.Grid:
    return grids.tiled(grids.from_file(path), copies)


def _ros_maps(options: PlannerSuiteOptions) -> list[Path]:
    if options.data is None:
        return []
    return [path for path in (options.data / "ros" / name for name in ROS_MAPS) if path.exists()]


PARTS: dict[str, Callable[[PlannerSuiteOptions, Progress], Told]] = {
    "fields": _fields,
    "comparisons": _comparisons,
    "scaling": _scaling,
    "lengths": _lengths,
    "scenarios": _scenarios,
    "indexes": _indexes,
}


def describe() -> dict[str, Any]:
    """Return the kind of processor, the number of usable CPUs, the load by other processes, and versions."""
    from llvmlite import binding  # noqa: PLC0415 - only here, and not at the start of every command

    features = binding.get_host_cpu_features()
    return {
        "processor": f"{platform.machine()} ({binding.get_host_cpu_name()})",
        "avx512": bool(features.get("avx512f")),
        "cpus": cpus(),
        "load": os.getloadavg()[0],
        "system": platform.system(),
        "python": platform.python_version(),
        "numba": version("numba"),
        "numpy": version("numpy"),
        "ppaas": __version__,
    }
