"""Map of a point cloud: an octomap, and a slice of it as the grid that robots drive on.

A cell is occupied if points are in it between two heights above the floor. It is free if the floor was seen in it, or
if a ray from a known place of the sensor passed through it at these heights. Small gaps of free space are closed. If no
floor was seen, or if a person gives a free place, the space that is enclosed by obstacles is free.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput, InvalidMap
from ppaas.imports.maps.clouds.distinct import DENSE as DENSE_VOLUME
from ppaas.imports.maps.clouds.distinct import distinct
from ppaas.imports.maps.clouds.ground import CloudFloor, find_floor, flat_floor
from ppaas.imports.maps.clouds.octomap_file import free_columns
from ppaas.imports.maps.clouds.point_cloud import Coordinates, PointCloud
from ppaas.imports.maps.clouds.rays import seen_through
from ppaas.imports.maps.common.enclosed import closed_gaps, enclosed
from ppaas.imports.maps.common.imported_map import (
    MOST_CELLS,
    ImportedMap,
    MapOptions,
    grid_around,
    grid_of,
    report_cells,
)
from ppaas.imports.report import ImportReport
from ppaas.maps.grid import FREE, GridInfo, GridMap
from ppaas.maps.octree import OcTree, octree_of_voxels

RESOLUTIONS = (0.05, 0.1, 0.2, 0.25, 0.5, 1.0, 2.0, 5.0)
"""Resolutions from which one is chosen [m]."""

PREFERRED_CELLS = 1 << 24
"""Largest number of cells if the resolution is chosen."""

LEAST_PER_CELL = 3.0
"""Least mean number of points of a cell if the resolution is chosen."""

DENSE = 8.0
"""Mean number of points of a cell from which one alone is noise."""

LEAST_FREE = 0.02
"""Part of the cells with points below which the seen floor is not enough to drive on."""

MOST_FREE_VOXELS = 1 << 21
"""Largest number of free voxels of the octomap that are written."""


@dataclass(frozen=True, slots=True)
class _Slice:
    """Cells of the points of a cloud, and their heights above the floor."""

    info: GridInfo
    cells: NDArray[np.int64]
    floor: CloudFloor


def map_of_cloud(cloud: PointCloud, options: MapOptions, report: ImportReport) -> ImportedMap:
    """Return the map of a cloud.

    Raises
    ------
    InvalidMap
        The map would have too many cells, or no free one.
    InvalidInput
        The free place that a person gave is not within walls.
    """
    low, high = options.heights
    if not low < high:
        raise InvalidInput(f"--heights needs a lower and a higher number of metres, not {low:g},{high:g}")
    info = _geometry(cloud, options, report)
    cells = _cells(cloud.points, info)
    if options.floor is None:
        floor = find_floor(cloud.points, info, cloud.ground)
        kind = "flat" if floor.is_flat else "terrain, mean"
        report.translated("floor", f"{kind} height {floor.level:.2f} m, which becomes 0; --floor Z chooses another")
    else:
        floor = flat_floor(cloud.points, options.floor)
        report.translated("floor", f"height {floor.level:.2f} m as given, which becomes 0")
    sliced = _Slice(info, cells, floor)
    occupied = _occupied(sliced, options, report)
    free = _free(cloud, sliced, occupied, options, report)
    grid = grid_of(info, free, occupied)
    report_cells(report, grid)
    return ImportedMap(grid, _octomap(sliced, grid, options, report))


def _geometry(cloud: PointCloud, options: MapOptions, report: ImportReport) -> GridInfo:
    points = cloud.points
    low, high = points[:, :2].min(axis=0).astype(np.float64), points[:, :2].max(axis=0).astype(np.float64)
    given = options.resolution or (None if cloud.octree is None else cloud.octree.resolution)
    if given is not None:
        return grid_around(low - given, high + given, given)
    extent = np.maximum(high - low, 0.01)
    for resolution in RESOLUTIONS:
        if np.prod(extent / resolution + 3) > PREFERRED_CELLS:
            continue
        info = grid_around(low - resolution, high + resolution, resolution)
        used = np.zeros(info.width * info.height, np.bool_)
        used[_cells(points, info)] = True
        per_cell = len(points) / used.sum()
        if per_cell >= LEAST_PER_CELL:
            break
    else:
        if np.prod(extent / resolution) > MOST_CELLS:
            raise InvalidMap(f"the cloud is {extent[0]:.0f} × {extent[1]:.0f} m large: cut it, or choose --resolution")
        info = grid_around(low - resolution, high + resolution, resolution)
        per_cell = LEAST_PER_CELL
    report.translated("resolution", f"{resolution:g} m, by the density of the points ({per_cell:.1f} in a cell)")
    return info


def _cells(points: Coordinates, info: GridInfo) -> NDArray[np.int64]:
    """Return the index of the cell of each point, row by row."""
    columns = ((points[:, 0] - np.float32(info.origin.x)) / np.float32(info.resolution)).astype(np.int64)
    rows = ((points[:, 1] - np.float32(info.origin.y)) / np.float32(info.resolution)).astype(np.int64)
    np.clip(columns, 0, info.width - 1, out=columns)
    np.clip(rows, 0, info.height - 1, out=rows)
    return rows * info.width + columns


def _occupied(sliced: _Slice, options: MapOptions, report: ImportReport) -> NDArray[np.bool_]:
    low, high = options.heights
    heights, info = sliced.floor.heights, sliced.info
    within = (heights > low) & (heights <= high)
    counts = np.bincount(sliced.cells[within], minlength=info.width * info.height)
    present = np.bincount(sliced.cells, minlength=info.width * info.height)
    least = 2 if len(heights) / max(1, (present > 0).sum()) >= DENSE else 1
    occupied = counts >= least
    alone = int(((counts > 0) & ~occupied).sum())
    report.translated("obstacles", f"{int(within.sum())} points from {low:g} to {high:g} m above the floor")
    above, below = int((heights > high).sum()), int((heights < -low).sum())
    if above:
        report.without_effect("points above", f"{above} are higher than {high:g} m: robots drive under them")
    if below:
        report.without_effect("points below", f"{below} are more than {low:g} m below the floor")
    if alone:
        report.without_effect("points alone", f"{alone} cells have one point among many: noise")
    return np.asarray(occupied.reshape(info.shape))


# -- free space --------------------------------------------------------------------------------------------------------


def _free(
    cloud: PointCloud, sliced: _Slice, occupied: NDArray[np.bool_], options: MapOptions, report: ImportReport
) -> NDArray[np.bool_]:
    info, low = sliced.info, options.heights[0]
    free = np.zeros(info.width * info.height, np.bool_)
    free[sliced.cells[np.abs(sliced.floor.heights) <= low]] = True
    seen = free.reshape(info.shape) & ~occupied
    report.translated("free space", f"{int(seen.sum())} cells in which the floor was seen")
    if cloud.origins:
        through = seen_through(cloud.points, cloud.origins, sliced.floor, info, options.heights) & ~occupied
        report.translated("free space", f"{int((through & ~seen).sum())} more cells through which rays passed")
        seen |= through
    if cloud.octree is not None:
        level = sliced.floor.level
        empty = free_columns(cloud.octree, info, level + low, level + options.heights[1]) & ~occupied
        report.translated("free space", f"{int((empty & ~seen).sum())} more cells of free voxels")
        seen |= empty
    if options.start is not None:
        inside = enclosed(occupied, info, options.start)
        report.translated("--start", f"{int(inside.sum())} cells within the walls around it are free")
        return inside
    if seen.sum() >= LEAST_FREE * len(distinct(sliced.cells, info.width * info.height)) and seen.any():
        return closed_gaps(seen, occupied)
    inside = enclosed(occupied, info)
    if not inside.any():
        raise InvalidMap(
            "the cloud shows no floor and no space within walls: give a free place with --start X,Y, other --heights, "
            "or a coarser --resolution that closes gaps of the walls"
        )
    report.translated("free space", f"the floor was not seen: {int(inside.sum())} cells within walls are free")
    return inside


# -- octomap -----------------------------------------------------------------------------------------------------------


def _octomap(sliced: _Slice, grid: GridMap, options: MapOptions, report: ImportReport) -> OcTree:
    """Return the octomap, with heights above the floor; space above free cells is free as high as the slice."""
    edge = grid.info.resolution
    layers = np.floor(sliced.floor.heights / np.float32(edge)).astype(np.int64)
    lowest, count = int(layers.min()), grid.info.width * grid.info.height
    volume = (int(layers.max()) - lowest + 1) * count
    codes = distinct((layers - lowest) * count + sliced.cells, volume)
    occupied = np.ones(len(codes), np.bool_)
    free_cells = np.flatnonzero(grid.data == FREE)
    top = int(options.heights[1] / edge)
    if volume <= DENSE_VOLUME and len(free_cells) * top <= MOST_FREE_VOXELS:
        known = np.zeros((volume // count, count), np.bool_)
        known[max(1 - lowest, 0) : top - lowest, free_cells] = True
        known.ravel()[codes] = True
        is_occupied = np.zeros(volume, np.bool_)
        is_occupied[codes] = True
        codes = np.flatnonzero(known)
        occupied = is_occupied[codes]
    voxels = _voxels(codes, count, grid.info, lowest)
    voxels[:, :2] += np.rint(np.array(grid.info.origin[:2]) / edge).astype(np.int64)
    tree = octree_of_voxels(edge, voxels, occupied)
    filled = int(occupied.sum())
    report.translated("octomap", f"{filled} occupied and {len(occupied) - filled} free voxels of {edge:g} m")
    return tree


def _voxels(codes: NDArray[np.int64], count: int, info: GridInfo, lowest: int) -> NDArray[np.int64]:
    cells = codes % count
    return np.stack((cells % info.width, cells // info.width, codes // count + lowest), axis=1)
