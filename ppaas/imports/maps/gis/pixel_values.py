"""Meaning of the values of a raster: greys, occupancies, masks, or heights."""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.imports.maps.common.imported_map import MapOptions
from ppaas.imports.report import ImportReport
from ppaas.maps.formats.image import MapImage
from ppaas.maps.formats.map_files import occupancy
from ppaas.maps.formats.map_yaml import MapYaml
from ppaas.maps.grid import FREE, OCCUPIED, OCCUPIED_THRESHOLD, UNKNOWN

GREYS, OCCUPANCIES, MASK, HEIGHTS = "greys", "occupancies", "mask", "heights"
MEANINGS = (GREYS, OCCUPANCIES, MASK, HEIGHTS)

_TEXTS = {
    GREYS: "greys as in a map of map_server: black is occupied, white is free",
    OCCUPANCIES: "occupancies from 0 to 100, and -1 for unknown",
    MASK: "a mask: 0 is free, all else is occupied",
}
_RECORD = MapYaml(image="raster", resolution=1.0, origin=(0.0, 0.0, 0.0))
_FREE_BELOW = 20
"""Occupancy below which a cell is free, map_server's default ``free_thresh`` in percent."""

_Cells = NDArray[np.int8]


def cells_of_raster(
    bands: NDArray[np.generic], valid: NDArray[np.bool_], size: float, options: MapOptions, report: ImportReport
) -> _Cells:
    """Return the occupancy of pixels, in the order of the raster.

    Parameters
    ----------
    bands : (n, height, width) array
    valid : (height, width) bool array
        Pixels with data; others are unknown.
    size : float
        Edge of a pixel [m].
    options : MapOptions
    report : ImportReport
    """
    meaning = options.values or _meaning(bands, valid)
    if meaning == HEIGHTS:
        cells = _of_heights(bands[0].astype(np.float64), valid, size, options.max_slope)
        text = f"heights [m]: steeper than {options.max_slope:g}° is occupied"
    else:
        cells, text = {GREYS: _of_greys, OCCUPANCIES: _of_occupancies, MASK: _of_mask}[meaning](bands), _TEXTS[meaning]
    report.translated("values", text if options.values else f"{text}; --values chooses another meaning")
    unknown = int((~valid).sum())
    if unknown:
        report.translated("no data", f"{unknown} pixels are unknown")
        np.copyto(cells, np.int8(UNKNOWN), where=~valid)
    return cells


def _meaning(bands: NDArray[np.generic], valid: NDArray[np.bool_]) -> str:
    band = bands[0]
    if len(bands) > 1:
        return GREYS
    if not valid.any():
        return OCCUPANCIES
    known = np.where(valid, band, band.flat[valid.argmax()])
    least, most = float(known.min()), float(known.max())
    if band.dtype.kind == "f":
        return OCCUPANCIES if least >= 0.0 and most <= 1.0 else HEIGHTS
    if band.dtype.itemsize == 1 and least >= 0 and most <= 1:
        return MASK
    if band.dtype == np.uint8:
        return OCCUPANCIES if most <= OCCUPIED else GREYS
    return OCCUPANCIES if least >= UNKNOWN and most <= OCCUPIED else HEIGHTS


def _of_greys(bands: NDArray[np.generic]) -> _Cells:
    if bands.dtype.itemsize > 1:
        span = float(bands.max()) or 1.0
        bands = (bands.astype(np.float64) * (255.0 / span)).astype(np.uint8)
    channels = bands if len(bands) in (1, 3, 4) else bands[:1]
    return occupancy(MapImage(np.moveaxis(channels, 0, -1).astype(np.uint8)), _RECORD)


def _of_occupancies(bands: NDArray[np.generic]) -> _Cells:
    band = bands[0]
    if band.dtype == np.uint8:
        return np.asarray(_cells_of(np.arange(256.0))[band])
    return _cells_of(band * 100.0 if band.dtype.kind == "f" else band.astype(np.float64))


def _cells_of(band: NDArray[np.float64]) -> _Cells:
    """Return the cells of occupancies [%]; those between free and occupied are unknown."""
    cells = np.full(band.shape, UNKNOWN, np.int8)
    cells[(band >= 0.0) & (band < _FREE_BELOW)] = FREE
    cells[(band >= OCCUPIED_THRESHOLD) & (band <= OCCUPIED)] = OCCUPIED
    return cells


def _of_mask(bands: NDArray[np.generic]) -> _Cells:
    return np.where(bands[0] != 0, OCCUPIED, FREE).astype(np.int8)


def _of_heights(heights: NDArray[np.float64], valid: NDArray[np.bool_], size: float, max_slope: float) -> _Cells:
    """Return cells that are occupied where the step to one of four neighbours is too steep."""
    heights = np.where(valid, heights, np.nan)
    most = math.tan(math.radians(max_slope)) * size
    steep = np.zeros(heights.shape, np.bool_)
    down, across = np.abs(np.diff(heights, axis=0)) > most, np.abs(np.diff(heights, axis=1)) > most
    steep[:-1] |= down
    steep[1:] |= down
    steep[:, :-1] |= across
    steep[:, 1:] |= across
    return np.where(steep, OCCUPIED, FREE).astype(np.int8)
