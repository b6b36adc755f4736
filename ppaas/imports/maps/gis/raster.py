"""Rasters of GIS programs: GeoTIFF, ESRI ASCII grids, and pictures with a world file."""

import math
import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput, InvalidMap
from ppaas.geometry import Pose2D
from ppaas.imports.maps.common.imported_map import ImportedMap, MapOptions, check_cells, in_short, report_cells
from ppaas.imports.maps.gis.pixel_values import cells_of_raster
from ppaas.imports.maps.gis.projection import gis_library, local_frame, parse_projection
from ppaas.imports.report import ImportReport
from ppaas.maps.georeference import GeoAnchor
from ppaas.maps.grid import GridInfo, GridMap

DRIVERS = ("GTiff", "AAIGrid", "PNG", "JPEG", "BMP")
"""Formats that GDAL may try: others name further files, or addresses in the net."""

MOST_BANDS = 4

FAR = 10_000.0
"""Coordinates without a coordinate system beyond it become relative to the lower-left corner [m]."""

_Affine = NDArray[np.float64]
"""(2, 3): coordinates of the file from column, row and 1."""


@dataclass(frozen=True, slots=True)
class _Frame:
    """Frame of a map on a raster: size of a pixel [m], pose of its lower-left corner, and georeference."""

    width: float
    height: float
    corner: Pose2D
    anchor: GeoAnchor | None
    mirrored: bool


def import_raster(content: bytes, name: str, options: MapOptions | None = None) -> tuple[ImportedMap, ImportReport]:
    """Import a raster.

    Parameters
    ----------
    content : bytes
    name : str
        Name of the file, for the report.
    options : MapOptions, optional

    Raises
    ------
    InvalidMap
        GDAL cannot read it, its pixels are not rectangles, or no cell is free.
    InvalidInput
        rasterio is not installed, or a picture has no georeference.
    """
    options = options or MapOptions()
    rasterio = gis_library()
    report = ImportReport(name)
    try:
        with warnings.catch_warnings(), rasterio.MemoryFile(content) as memory:
            warnings.simplefilter("ignore", rasterio.errors.NotGeoreferencedWarning)  # is reported or refused below
            source = memory.open(driver=_driver(content))
            check_cells(source.width, source.height, 1.0)
            frame = _frame(source, options, report)
            size = abs(frame.width)
            bands = source.read(list(range(1, min(source.count, MOST_BANDS) + 1)))
            valid = source.dataset_mask() > 0
            cells = cells_of_raster(bands, valid, size, options, report)
    except rasterio.errors.RasterioError as error:
        raise InvalidMap(f"the raster cannot be read: {error}") from error
    if not frame.mirrored:
        cells = cells[::-1]
    grid = _gridded(cells, frame, options.resolution, report)
    report_cells(report, grid)
    return ImportedMap(grid, anchor=frame.anchor).anchored(options.anchor), report


def _driver(content: bytes) -> str:
    """Return the name of GDAL for a format."""
    for magic, name in ((b"II", "GTiff"), (b"MM", "GTiff"), (b"\x89PNG", "PNG"), (b"\xff\xd8", "JPEG"), (b"BM", "BMP")):
        if content.startswith(magic):
            return name
    return "AAIGrid"


# -- where the raster is -----------------------------------------------------------------------------------------------


def _frame(source: Any, options: MapOptions, report: ImportReport) -> _Frame:
    affine = _affine(source, options, report)
    system = source.crs
    if system is None and options.projection is not None:
        system = parse_projection(options.projection.decode("utf-8", "replace").strip("\0 \r\n"))
    # The corner that is the lower left one if rows go down, as they do in nearly all files.
    mirrored = float(np.linalg.det(affine[:, :2])) > 0.0
    corner = affine @ (0.0, 0.0 if mirrored else float(source.height), 1.0)
    if system is None:
        metres = np.eye(2)
        anchor = None
        report.without_effect("coordinate system", "the file has none: its units are taken for metres")
    else:
        anchor, metres = local_frame(system, *corner.tolist())
    across, down = (metres @ affine[:, :2]).T
    _check_rectangular(across, down, max(source.width, source.height))
    yaw = math.atan2(across[1], across[0])
    pose = Pose2D(0.0, 0.0, 0.0)
    if anchor is None:
        pose = Pose2D(float(corner[0]), float(corner[1]), yaw)
        if np.abs(corner).max() > FAR:
            pose = Pose2D(0.0, 0.0, yaw)
            report.translated("origin", f"{corner[0]:.2f}, {corner[1]:.2f} of the file becomes 0, 0")
    else:
        anchor = GeoAnchor(anchor.latitude, anchor.longitude, yaw)
        name = system.to_string() if len(system.to_string()) < 40 else "the file"
        report.translated(
            "georeference", f"the lower-left corner in {name}: {anchor.latitude:.7f}, {anchor.longitude:.7f}"
        )
    return _Frame(in_short(float(np.hypot(*across))), in_short(float(np.hypot(*down))), pose, anchor, mirrored)


def _affine(source: Any, options: MapOptions, report: ImportReport) -> _Affine:
    if options.world is not None:
        report.taken("world file")
        return _world(options.world)
    transform = source.transform
    if transform.is_identity:
        if options.resolution is None:
            raise InvalidInput(
                "the raster has no georeference: put its world file beside it, give --resolution METRES, or import it "
                "with 'ppaas map from-plan'"
            )
        edge = options.resolution
        report.translated("pixels", f"{edge:g} m, as given")
        return np.array([[edge, 0.0, 0.0], [0.0, -edge, source.height * edge]])
    return np.array([[transform.a, transform.b, transform.c], [transform.d, transform.e, transform.f]])


def _world(content: bytes) -> _Affine:
    """Return the geometry of a world file, whose last two numbers are of the middle of the first pixel."""
    try:
        a, d, b, e, x, y = (float(line.replace(b",", b".")) for line in content.split())
    except ValueError as error:
        raise InvalidMap("a world file has six numbers, each in a line") from error
    return np.array([[a, b, x - (a + b) / 2.0], [d, e, y - (d + e) / 2.0]])


def _check_rectangular(across: NDArray[np.float64], down: NDArray[np.float64], cells: int) -> None:
    sizes = float(np.hypot(*across)), float(np.hypot(*down))
    if not all(1e-4 < size < 1e5 for size in sizes):
        raise InvalidMap(f"the pixels of the raster are {sizes[0]:g} × {sizes[1]:g} m large")
    if abs(float(across @ down)) / (sizes[0] * sizes[1]) * cells > 1.0:
        raise InvalidMap("the pixels of the raster are no rectangles: warp it to a projection first, as with gdalwarp")


# -- cells of the map --------------------------------------------------------------------------------------------------


def _gridded(cells: NDArray[np.int8], frame: _Frame, resolution: float | None, report: ImportReport) -> GridMap:
    """Return the grid of cells, row 0 the lowest; cells are square, so other pixels are sampled."""
    height, width = cells.shape
    edge = min(frame.width, frame.height) if resolution is None else resolution
    columns, rows = width * frame.width / edge, height * frame.height / edge
    if max(abs(columns - width), abs(rows - height)) < 0.5:
        edge = frame.width if resolution is None else edge
    else:
        check_cells(columns, rows, edge)
        cells = _sampled(_sampled(cells, rows, 0), columns, 1)
        report.translated("pixels", f"{frame.width:g} × {frame.height:g} m became {edge:g} m")
    info = GridInfo(edge, cells.shape[1], cells.shape[0], frame.corner)
    return GridMap(np.ascontiguousarray(cells), info)


def _sampled(cells: NDArray[np.int8], wanted: float, axis: int) -> NDArray[np.int8]:
    """Return cells of another size along an axis; an obstacle in any part of a larger cell fills it."""
    count, size = max(1, math.ceil(wanted - 1e-6)), cells.shape[axis]
    if count >= size:
        source = np.minimum(((np.arange(count) + 0.5) * size / wanted).astype(np.int64), size - 1)
        return np.asarray(cells.take(source, axis))
    begins = np.minimum((np.arange(count) * size / wanted).astype(np.int64), size - 1)
    return np.asarray(np.maximum.reduceat(cells, begins, axis))
