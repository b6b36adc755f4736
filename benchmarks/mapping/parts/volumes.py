"""Part ``volume``: insertion of point clouds into a 3D map on one and two threads, beside OctoMap's own algorithm."""

from typing import Any

from benchmarks.harness.figures import Figure, PartResult
from benchmarks.mapping import volume
from benchmarks.mapping.parts.part import SlamOptions

IMAGES = 12
"""Number of clouds."""

LIMITS = {1: 1.1e6, 2: 2.0e6}
"""Least rates by the number of threads [points/s]."""

EQUAL_LIMIT = 99.9
"""Least part of the voxels whose occupancy is that of OctoMap [%]."""


def measure(options: SlamOptions) -> PartResult:
    """Insert depth images of the folder of data; else scans of a simulated hall, of which few share voxels."""
    depth = None if options.data is None or not (options.data / "depth").is_dir() else options.data / "depth"
    clouds = volume.hall_clouds(IMAGES) if depth is None else volume.depth_clouds(depth, IMAGES)
    results = volume.measure(clouds)
    figures = [figure for result in results for figure in figures_of(result, bars=depth is not None)]
    return PartResult(figures, list(map(row, results)), results)


def figures_of(result: dict[str, Any], *, bars: bool) -> list[Figure]:
    """Return the rate, which has a bar on depth images, and how many voxels are equal."""
    note = f"{result['points']:,} points; {result['points_per_cpu_s']:,} a second of CPU"
    if "threads" not in result:
        rate = result["points_per_cpu_s"]
        return [Figure("volume", "insertion: baseline", rate, "points/s", yardstick=True, note=result["method"])]
    threads = result["threads"]
    # One thread is measured by its CPU time, which other work on the computer does not change.
    rate = result["points_per_cpu_s" if threads == 1 else "points_per_s"]
    limit = LIMITS[threads] if bars else None
    name = f"insertion, {threads} thread" + ("s" if threads > 1 else "")
    figures = [Figure("volume", name, rate, "points/s", limit=limit, floor=True, note=note)]
    if threads == 1:
        equal = round(100.0 * result["equal_occupancy"], 4)
        note = f"of {result['voxels']:,}, as OctoMap inserts the same points"
        figures.append(
            Figure("volume", "voxels of equal occupancy", equal, "%", limit=EQUAL_LIMIT, floor=True, note=note)
        )
    return figures


def row(result: dict[str, Any]) -> dict[str, str]:
    """Return the row of the table for a result."""
    return {
        "method": result["method"],
        "threads": str(result.get("threads", 1)),
        "points": f"{result['points']:,}",
        "points/s": f"{result['points_per_s']:,}",
        "points/s of CPU": f"{result['points_per_cpu_s']:,}",
        "equal occupancy": f"{100.0 * result['equal_occupancy']:.3f} %" if "equal_occupancy" in result else "",
    }
