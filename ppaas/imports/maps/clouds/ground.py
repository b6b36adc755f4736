"""Floor of a point cloud: one height, or the ground of a terrain, above which robots drive.

A floor is flat if enough of the cloud's area has points at one height: then the lowest such height is taken, so that a
ceiling is none, and the first of several storeys is. Otherwise the ground is found cell by cell: the lowest points of
cells that stand out by more than slopes do are roofs, trees and vehicles, and the ground below them is interpolated.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.imports.maps.clouds.distinct import distinct
from ppaas.imports.maps.clouds.point_cloud import Coordinates
from ppaas.maps.grid import GridInfo

BAND = 0.05
"""Height of a bin of the histogram of heights [m]."""

LEAST_SHARE = 0.4
"""Part of the known area that a flat floor has."""

LEAST_OF_MOST = 0.5
"""Part of the area of the largest level at which a lower one is a floor too."""

GROUND_CELL = 1.0
"""Least edge of the cells in which the ground of a terrain is found [m]."""

STEEPEST = 0.5
"""Slope of the ground above which it is taken for something on it [m/m]."""

ROUGH = 0.3
"""Height by which ground may stand out of its surroundings beyond its slope [m]."""

NEAR = (0.25, 0.12)
"""Heights within which points are those of the ground, from a first to a better ground [m]."""

WINDOWS = (1, 2, 4, 8)
"""Radii of the windows in which things on the ground are found [cells]."""

_Field = NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class CloudFloor:
    """Heights of the floor.

    Parameters
    ----------
    level : float
        Height of the floor in the cloud, or the mean one of a terrain [m].
    heights : (n,) float32 array
        Height of each point above the floor [m].
    is_flat : bool
    """

    level: float
    heights: NDArray[np.float32]
    is_flat: bool


def find_floor(points: Coordinates, info: GridInfo, ground: NDArray[np.bool_] | None = None) -> CloudFloor:
    """Return the floor of a cloud.

    Parameters
    ----------
    points : (n, 3) float32 array
    info : GridInfo
        Grid around the points, not turned.
    ground : (n,) bool array, optional
        Points that are known to be ground.
    """
    if ground is None:
        level, share = _flat_level(points, info)
        if share >= LEAST_SHARE:
            return flat_floor(points, level)
        ground = np.ones(len(points), np.bool_)
    return _terrain(points, info, ground)


def flat_floor(points: Coordinates, level: float) -> CloudFloor:
    """Return a flat floor at a height [m]."""
    return CloudFloor(level, points[:, 2] - np.float32(level), is_flat=True)


def _flat_level(points: Coordinates, info: GridInfo) -> tuple[float, float]:
    """Return the height of the lowest large level, and its part of the known area."""
    size = 4.0 * info.resolution
    width = int(info.width / 4) + 1
    columns = ((points[:, 0] - np.float32(info.origin.x)) / np.float32(size)).astype(np.int32)
    rows = ((points[:, 1] - np.float32(info.origin.y)) / np.float32(size)).astype(np.int32)
    cells = rows * width + columns
    low, high = np.percentile(points[:: max(1, len(points) // 100_000), 2], (0.1, 99.9))
    bins = max(1, min(int((high - low) / BAND) + 1, 4000))
    band = np.clip((points[:, 2] - np.float32(low)) / np.float32(BAND), -1, bins).astype(np.int32)
    inside = (band >= 0) & (band < bins)
    count = int(cells.max()) + 1
    pairs = distinct(band[inside].astype(np.int64) * count + cells[inside], bins * count)
    area = np.bincount(pairs // count, minlength=bins).astype(np.float64)
    known = len(distinct(cells, count))
    wide = np.convolve(area, np.ones(3), "same")  # a floor is as thick as its noise
    best = int(np.flatnonzero(wide >= LEAST_OF_MOST * wide.max())[0])
    while best + 1 < bins and wide[best + 1] > wide[best]:
        best += 1
    near = np.abs(points[:, 2] - np.float32(low + (best + 0.5) * BAND)) <= 1.5 * BAND
    return float(np.median(points[near, 2])), float(min(wide[best], known) / known)


# -- ground of a terrain -----------------------------------------------------------------------------------------------


def _terrain(points: Coordinates, info: GridInfo, ground: NDArray[np.bool_]) -> CloudFloor:
    cell = max(GROUND_CELL, 4.0 * info.resolution)
    shape = int(info.height * info.resolution / cell) + 1, int(info.width * info.resolution / cell) + 1
    local = (points[:, :2] - np.array([info.origin.x, info.origin.y], np.float32)) / np.float32(cell)
    lowest = _lowest(local[ground], points[ground, 2], shape)
    surface = _filled(_without_things(lowest, cell))
    index = local[:, 1].astype(np.int64) * shape[1] + local[:, 0].astype(np.int64)
    # The lowest point of a cell on a slope is below its middle: centre the ground on the points near it.
    for band in (STEEPEST * cell + ROUGH, *NEAR):
        heights = points[:, 2] - _between(surface, local)
        near = ground & (np.abs(heights) < band)
        count = np.bincount(index[near], minlength=shape[0] * shape[1])
        total = np.bincount(index[near], heights[near].astype(np.float64), minlength=shape[0] * shape[1])
        lift = np.where(count > 0, total / np.maximum(count, 1), np.nan).reshape(shape).astype(np.float32)
        surface = surface + _filled(lift)
    heights = points[:, 2] - _between(surface, local)
    return CloudFloor(float(np.mean(surface)), heights, is_flat=False)


def _lowest(local: NDArray[np.float32], heights: NDArray[np.float32], shape: tuple[int, int]) -> _Field:
    lowest = np.full(shape[0] * shape[1], np.inf, np.float32)
    index = local[:, 1].astype(np.int64) * shape[1] + local[:, 0].astype(np.int64)
    np.minimum.at(lowest, index, heights)
    found = lowest.reshape(shape)
    found[~np.isfinite(found)] = np.nan
    return found


def _without_things(lowest: _Field, cell: float) -> _Field:
    """Return the lowest heights of cells without those that stand on the ground, which are NaN."""
    ground = lowest.copy()
    for radius in WINDOWS:
        known = np.where(np.isnan(ground), np.float32(np.inf), ground)
        eroded = _window(known, radius, np.minimum, np.float32(np.inf))
        opened = _window(np.where(np.isinf(eroded), -np.inf, eroded), radius, np.maximum, np.float32(-np.inf))
        ground[ground - opened > STEEPEST * radius * cell + ROUGH] = np.nan
    return ground


def _window(field: _Field, radius: int, combine: np.ufunc, outside: np.float32) -> _Field:
    """Return the minimum or maximum of each cell's square of cells."""
    for axis in (0, 1):
        padded = np.pad(
            field, [(radius, radius) if each == axis else (0, 0) for each in (0, 1)], constant_values=outside
        )
        size = field.shape[axis]
        field = combine.reduce([padded.take(np.arange(at, at + size), axis) for at in range(2 * radius + 1)])
    return field


def _filled(field: _Field) -> _Field:
    """Return a field whose unknown cells have the mean of the known ones around them, from near to far."""
    field = field.copy()
    if np.isnan(field).all():
        return np.zeros_like(field)
    while (unknown := np.isnan(field)).any():
        padded = np.pad(field, 1, constant_values=np.nan)
        around = np.stack([
            padded[row : row + field.shape[0], column : column + field.shape[1]]
            for row in range(3) for column in range(3) if (row, column) != (1, 1)
        ])  # fmt: skip
        count = (~np.isnan(around)).sum(axis=0)
        total = np.nansum(around, axis=0)
        reached = unknown & (count > 0)
        field[reached] = (total[reached] / count[reached]).astype(np.float32)
    return field


def _between(surface: _Field, local: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the heights of a surface at places, between the centres of its cells."""
    height, width = surface.shape
    x = np.clip(local[:, 0] - np.float32(0.5), 0, width - 1)
    y = np.clip(local[:, 1] - np.float32(0.5), 0, height - 1)
    column, row = x.astype(np.int32), y.astype(np.int32)
    right, upper = np.minimum(column + 1, width - 1), np.minimum(row + 1, height - 1)
    x, y = x - column, y - row
    lower = surface[row, column] * (1 - x) + surface[row, right] * x
    higher = surface[upper, column] * (1 - x) + surface[upper, right] * x
    return np.asarray(lower * (1 - y) + higher * y, np.float32)
