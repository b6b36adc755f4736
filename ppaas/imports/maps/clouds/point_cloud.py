"""Point clouds as all readers return them, and the limits that they check before memory is taken."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidMap
from ppaas.imports.report import ImportReport
from ppaas.maps.octree import OcTree

MOST_POINTS = 50_000_000
"""Largest number of points of a cloud."""

FAR = 10_000.0
"""Coordinates beyond it are those of a projection of the Earth, and become relative to a point of the cloud [m]."""

Coordinates = NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class ScanOrigin:
    """Place of the sensor of a part of the points.

    Parameters
    ----------
    place : tuple of float
        x, y, z, as the points have them.
    begin, end : int
        First point, and the one after the last.
    """

    place: tuple[float, float, float]
    begin: int
    end: int


@dataclass(frozen=True, slots=True)
class PointCloud:
    """Points, of which none has a coordinate that is not finite.

    Parameters
    ----------
    points : (n, 3) float32 array
        x, y, z from the offset.
    offset : (3,) float64 array
        x, y, z in the file of the point 0, 0, 0.
    origins : tuple of ScanOrigin
        Places of the sensor, if the file has them.
    ground : (n,) bool array, optional
        Points that the file calls ground.
    projection : str, optional
        Coordinate system of the file: WKT, or an authority with a code as ``EPSG:25832``.
    octree : OcTree, optional
        Octree of which the points are the occupied voxels; its free leaves were seen to be free.
    """

    points: Coordinates
    offset: NDArray[np.float64]
    origins: tuple[ScanOrigin, ...] = ()
    ground: NDArray[np.bool_] | None = None
    projection: str | None = None
    octree: OcTree | None = None


def check_count(declared: int, kind: str) -> None:
    """Raise ``InvalidMap`` if the header of a file states no points or too many of them."""
    if declared < 1:
        raise InvalidMap(f"the {kind} has no points")
    if declared > MOST_POINTS:
        raise InvalidMap(f"the {kind} states {declared} points, and at most {MOST_POINTS} are read: thin it first")


def check_size(needed: int, size: int, kind: str) -> None:
    """Raise ``InvalidMap`` if a file is shorter than its header states."""
    if needed > size:
        raise InvalidMap(f"the {kind} is truncated: its header states {needed} bytes of points, and it has {size}")


def cloud_of(
    columns: tuple[NDArray[np.generic], NDArray[np.generic], NDArray[np.generic]], report: ImportReport
) -> PointCloud:
    """Return the cloud of columns x, y and z; points that are not finite are dropped and reported.

    Raises
    ------
    InvalidMap
        No point is finite.
    """
    finite = np.isfinite(columns[0]) & np.isfinite(columns[1]) & np.isfinite(columns[2])
    count = int(finite.sum())
    if not count:
        raise InvalidMap("all points of the cloud have a coordinate that is not finite")
    if count < len(finite):
        columns = (columns[0][finite], columns[1][finite], columns[2][finite])
        report.without_effect("points", f"{len(finite) - count} without finite coordinates: no echo")
    offset = offset_of(np.array([column.min() for column in columns], np.float64))
    points = np.empty((count, 3), np.float32)
    for axis, column in enumerate(columns):
        np.subtract(column, offset[axis], out=points[:, axis], casting="unsafe")
    report.taken("points", f"{count}")
    return PointCloud(points, offset)


def offset_of(low: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the offset of a cloud with these least coordinates: 0 unless they are those of the Earth."""
    far = np.abs(low[:2]).max() > FAR
    return np.array([*(np.floor(low[:2] / 100.0) * 100.0), 0.0]) if far else np.zeros(3)
