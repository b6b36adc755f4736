"""Result of the import of a map: grid, octomap, zones and georeference, and the files of them."""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidMap, InvalidZones
from ppaas.geometry import Pose2D
from ppaas.imports.report import ImportReport
from ppaas.maps.formats.map_files import save_map
from ppaas.maps.georeference import GeoAnchor, with_anchor
from ppaas.maps.grid import FREE, OCCUPIED, UNKNOWN, GridInfo, GridMap
from ppaas.maps.octomap import binary_octomap
from ppaas.maps.octree import OcTree
from ppaas.zones.reading import geojson_of
from ppaas.zones.shapes import Polygon
from ppaas.zones.zone import LONGEST_NAME, MOST_POSITIONS, MOST_ZONES, KeepOut, Zone, ZoneSet, check_zone

MOST_CELLS = 1 << 26
"""Largest number of cells of an imported grid; a picture of a map has no more pixels."""


@dataclass(frozen=True, slots=True)
class MapOptions:
    """What a person may choose for the import of a map.

    Parameters
    ----------
    resolution : float, optional
        Edge of a cell [m]; that of the file, or one that suits it, if None.
    heights : tuple of float
        Lowest and highest height above the floor at which points are obstacles [m].
    floor : float, optional
        Height of the floor in the file [m]; found if None.
    up : str
        Axis of a cloud that points up: ``z``, or ``y`` as in files of cameras and telephones.
    unit : float
        Metres of a unit of a cloud.
    start : tuple of float, optional
        A free place, x, y in the frame of the map [m].
    anchor : GeoAnchor, optional
        Georeference of the map; that of the file if None.
    max_slope : float
        Largest slope on which robots drive, for rasters of heights [°].
    world : bytes, optional
        World file beside a picture.
    values : str, optional
        Meaning of the values of a raster: ``greys``, ``occupancies``, ``mask`` or ``heights``; found if None.
    projection : bytes, optional
        Projection file (``.prj``) beside a raster.
    """

    resolution: float | None = None
    heights: tuple[float, float] = (0.15, 1.5)
    floor: float | None = None
    up: str = "z"
    unit: float = 1.0
    start: tuple[float, float] | None = None
    anchor: GeoAnchor | None = None
    max_slope: float = 15.0
    values: str | None = None
    world: bytes | None = None
    projection: bytes | None = None


@dataclass(frozen=True, slots=True)
class ImportedMap:
    """Map of a foreign file.

    Parameters
    ----------
    grid : GridMap
    octomap : OcTree, optional
        Of a cloud, with heights above the floor.
    zones : ZoneSet
    anchor : GeoAnchor, optional
        Georeference.
    """

    grid: GridMap
    octomap: OcTree | None = None
    zones: ZoneSet = field(default_factory=ZoneSet)
    anchor: GeoAnchor | None = None

    def anchored(self, anchor: GeoAnchor | None) -> "ImportedMap":
        """Return the map with a georeference, if one is given."""
        return self if anchor is None else replace(self, anchor=anchor)


@dataclass(frozen=True, slots=True)
class ImportedFiles:
    """Files of an imported map, as ``ppaas map publish`` takes them."""

    yaml: bytes
    image: bytes
    octomap: bytes | None
    zones: bytes | None


def files_of(imported: ImportedMap, image_name: str) -> ImportedFiles:
    """Return the files of an imported map; the YAML names the image ``image_name``."""
    record, image = save_map(imported.grid, image_name)
    if imported.anchor is not None:
        record = with_anchor(record, imported.anchor)
    octomap = None if imported.octomap is None else binary_octomap(imported.octomap)
    return ImportedFiles(record, image, octomap, geojson_of(imported.zones) if imported.zones.zones else None)


# -- grids and zones of imports ----------------------------------------------------------------------------------------


def check_cells(width: float, height: float, resolution: float) -> None:
    """Raise ``InvalidMap`` if a grid of this size in cells would be too large."""
    if not (width >= 1 and height >= 1 and width * height <= MOST_CELLS):
        raise InvalidMap(
            f"the map would have {width:.0f} × {height:.0f} cells of {resolution:g} m, and at most {MOST_CELLS} are "
            "allowed: choose a larger --resolution"
        )


def grid_around(low: NDArray[np.float64], high: NDArray[np.float64], resolution: float) -> GridInfo:
    """Return the geometry of a grid around a rectangle [m], whose origin is a multiple of the resolution.

    Raises
    ------
    InvalidMap
        It would have too many cells.
    """
    first = np.floor(low / resolution + 1e-6)
    last = np.ceil(high / resolution - 1e-6)
    width, height = (last - first).tolist()
    check_cells(width, height, resolution)
    x, y = (first * resolution).tolist()
    return GridInfo(resolution, int(width), int(height), Pose2D(in_short(x), in_short(y), 0.0))


def in_short(value: float) -> float:
    """Return a length without the digits that rounding adds."""
    return float(f"{value:.9g}")


def grid_of(info: GridInfo, free: NDArray[np.bool_], occupied: NDArray[np.bool_]) -> GridMap:
    """Return a grid of masks; cells of both are occupied, cells of neither are unknown."""
    data = np.full(info.shape, UNKNOWN, np.int8)
    data[free] = FREE
    data[occupied] = OCCUPIED
    return GridMap(data, info)


def report_cells(report: ImportReport, grid: GridMap) -> None:
    """Report the size of the map that was made, and refuse one without a free cell.

    Raises
    ------
    InvalidMap
        No cell is free, so that no robot can be on the map.
    """
    info = grid.info
    free, occupied = (int(np.count_nonzero(grid.data == value)) for value in (FREE, OCCUPIED))
    if not free:
        raise InvalidMap("no cell of the map would be free, so that no robot can be on it")
    square = info.resolution**2
    report.translated(
        "grid",
        f"{info.width} × {info.height} cells of {info.resolution:g} m: {free * square:.1f} m² free, "
        f"{occupied * square:.1f} m² occupied",
    )


class KeepOutZones:
    """Collects keep-out zones of a foreign file, each with a name of its own.

    Parameters
    ----------
    report : ImportReport
    """

    def __init__(self, report: ImportReport) -> None:
        self._report = report
        self._zones: dict[str, Zone] = {}
        self._positions = 0

    def add(self, part: str, name: str, ring: Iterable[tuple[float, float]], note: str = "") -> None:
        """Add a polygon [m], and report it; a polygon that is not valid is refused."""
        corners = [[round(float(x), 4), round(float(y), 4)] for x, y in ring]
        if corners and corners[0] != corners[-1]:
            corners.append(corners[0])
        named = self._free_name(name)
        zone = Zone(Polygon([corners]), KeepOut(name=named))
        try:
            positions = self._positions + check_zone(zone)
        except InvalidZones as error:
            self._report.refused(part, str(error))
            return
        if len(self._zones) >= MOST_ZONES or positions > MOST_POSITIONS:
            self._report.refused(part, f"a map may have {MOST_ZONES} zones with {MOST_POSITIONS} positions together")
            return
        self._zones[named], self._positions = zone, positions
        self._report.translated(part, f"keep-out zone {named!r}{note}")

    def zones(self) -> ZoneSet:
        """Return the zones that were added."""
        return ZoneSet(list(self._zones.values()))

    def _free_name(self, name: str) -> str:
        wanted = " ".join(name.split())[: LONGEST_NAME - 4] or "keep out"
        count, found = 1, wanted
        while found in self._zones:
            count += 1
            found = f"{wanted} {count}"
        return found
