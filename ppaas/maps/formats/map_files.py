"""Map files of map_server and Nav2, a YAML record and an image: reading and writing of grids.

Sources: ``image_loader.cpp`` of map_server (ros-planning/navigation) and ``map_io.cpp`` of Nav2
(ros-navigation/navigation2). Three apparent errors of map_server are not reproduced: it takes palette indices as greys,
it takes the blue of an RGB image as alpha, and its raw mode produces values that an occupancy grid cannot hold (they
are unknown here, as in Nav2).
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D
from ppaas.maps.buffer import Buffer
from ppaas.maps.formats.image import ImageRows, MapImage, image_size, open_image
from ppaas.maps.formats.map_yaml import MapYaml, Mode, Rules, dump_yaml, parse_yaml
from ppaas.maps.formats.netpbm import write_pgm
from ppaas.maps.grid import FREE, OCCUPIED, UNKNOWN, GridInfo, GridMap

# -- occupancy of pixels -----------------------------------------------------------------------------------------------

Cells = NDArray[np.int8]

_LUMA = np.array([299, 587, 114], np.uint32)
"""Weights of red, green and blue in a grey [1/1000] (ITU-R BT.601), as GraphicsMagick uses them for Nav2."""


def occupancy(image: MapImage, keys: MapYaml) -> Cells:
    """Return the occupancy of each pixel.

    Parameters
    ----------
    image : MapImage
        Row 0 on top.
    keys : MapYaml
        Thresholds, mode and rules.

    Returns
    -------
    (height, width) int8 array
        0 free to 100 occupied, −1 unknown; row 0 on top.
    """
    return (_by_nav2 if keys.rules is Rules.NAV2 else _by_map_server)(image, keys)


# -- map_server --------------------------------------------------------------------------------------------------------


def _by_map_server(image: MapImage, keys: MapYaml) -> Cells:
    """Classify pixels by the mean of their channels, which in trinary mode includes alpha.

    A cell is occupied above ``occupied_thresh``, else free below ``free_thresh``, else graded (scale) or unknown
    (trinary). In scale mode, fully transparent pixels between the thresholds are unknown. Where the thresholds are
    equal, map_server divides 0 by 0 for a pixel between them; it is unknown here.
    """
    alpha = image.alpha
    averaged = image.channels if keys.mode is Mode.TRINARY else image.channels[..., :3]
    count = averaged.shape[2]
    total = averaged[..., 0] if count == 1 else averaged.sum(axis=2, dtype=np.uint16)
    mean = np.arange(255 * count + 1) / count
    mean = 255.0 - mean if keys.negate else mean
    if keys.mode is Mode.RAW:
        return _raw(mean)[total]
    ratio = (255.0 - mean) / 255.0
    between = (ratio >= keys.free_thresh) & (ratio <= keys.occupied_thresh)
    values = np.where(ratio > keys.occupied_thresh, OCCUPIED, FREE).astype(np.int8)
    span = keys.occupied_thresh - keys.free_thresh
    scaled = keys.mode is Mode.SCALE and span > 0.0
    values[between] = 1.0 + 98.0 * (ratio[between] - keys.free_thresh) / span if scaled else UNKNOWN
    cells = values[total]
    if keys.mode is Mode.SCALE and alpha is not None:
        cells[between[total] & (alpha == 0)] = UNKNOWN
    return cells


# -- Nav2 --------------------------------------------------------------------------------------------------------------


def _by_nav2(image: MapImage, keys: MapYaml) -> Cells:
    """Classify pixels by their luma, in float32 as Nav2 does.

    A cell is free up to ``free_thresh``, else occupied from ``occupied_thresh`` up, else graded (scale) or unknown
    (trinary). A pixel that is not fully opaque is unknown. Raw mode ignores alpha and ``negate``.
    """
    luma = _luma(image)
    if keys.mode is Mode.RAW:
        return _raw(np.arange(256.0))[luma]
    ratio = np.arange(256, dtype=np.float32) / np.float32(255.0)
    ratio = ratio if keys.negate else np.float32(1.0) - ratio
    low, high = np.float32(keys.free_thresh), np.float32(keys.occupied_thresh)
    # Overflows or divides by 0 only if the thresholds are so close that no value is between them.
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        graded = np.floor((ratio - low) / (high - low) * np.float32(100.0) + np.float32(0.5))
    between = graded if keys.mode is Mode.SCALE else np.full(256, UNKNOWN)
    values = np.where(ratio <= low, FREE, np.where(ratio >= high, OCCUPIED, between)).astype(np.int8)
    cells = values[luma]
    if image.alpha is not None:
        cells[image.alpha < 255] = UNKNOWN
    return cells


def _luma(image: MapImage) -> NDArray[np.uint8]:
    if image.channels.shape[2] == 1:
        return image.channels[..., 0]
    return ((image.channels[..., :3] @ _LUMA + 500) // 1000).astype(np.uint8)


def _raw(grey: NDArray[np.float64]) -> Cells:
    """Return the occupancy of greys in raw mode: the integer part of the grey, or unknown above 100."""
    return np.where(np.floor(grey) <= OCCUPIED, np.floor(grey), UNKNOWN).astype(np.int8)


# -- files -------------------------------------------------------------------------------------------------------------

_BLOCK = 1 << 20
"""Number of cells that are read at once."""

_FREE_PIXEL, _OCCUPIED_PIXEL, _UNKNOWN_PIXEL = 254, 0, 205


class GridRows:
    """Map whose rows are read on demand, so that a large one need not fit in memory.

    Parameters
    ----------
    image : ImageRows
        Image of the map.
    keys : MapYaml
        YAML record of the map.
    """

    def __init__(self, image: ImageRows, keys: MapYaml) -> None:
        self.info = _info(image.shape, keys)
        self._image = image
        self._keys = keys

    def rows(self, first: int, last: int) -> NDArray[np.int8]:
        """Return the cells of the rows ``first`` to ``last`` (excluded), counted from the lowest row of the map.

        Raises
        ------
        InvalidMap
            One of their pixels is invalid.
        """
        height = self.info.height
        return occupancy(self._image.rows(height - last, height - first), self._keys)[::-1]

    def blocks(self) -> Iterator[tuple[int, NDArray[np.int8]]]:
        """Yield blocks of rows, each with the number of its first row; raises as ``rows``."""
        step = max(1, _BLOCK // self.info.width)
        for first in range(0, self.info.height, step):
            yield first, self.rows(first, min(first + step, self.info.height))

    def check(self) -> None:
        """Raise ``InvalidMap`` if any pixel is invalid."""
        self._image.check()


def open_grid(record: bytes, image: Buffer, rules: Rules | None = None) -> GridRows:
    """Open a map from its two files.

    Parameters
    ----------
    record : bytes
        The YAML file; its key ``image`` is ignored.
    image : bytes or mmap
        The image file; its lowest row becomes row 0 of the grid.
    rules : Rules, optional
        Rules that classify pixels as free or occupied; by default those that the record names, or else map_server's.

    Raises
    ------
    InvalidMap
        One of the files is invalid; the text says why.
    """
    keys = parse_yaml(record, rules)
    return GridRows(open_image(image), keys)


def read_info(record: bytes, image: Buffer) -> GridInfo:
    """Return the geometry of a map, for which only the header of its image is read; raises as ``open_grid``."""
    return _info(image_size(image), parse_yaml(record))


def _info(shape: tuple[int, int], keys: MapYaml) -> GridInfo:
    height, width = shape
    return GridInfo(keys.resolution, width, height, Pose2D(*keys.origin))


def load_map(record: bytes, image: Buffer, rules: Rules | None = None) -> GridMap:
    """Return a map read from its two files; parameters and errors are the same as for ``open_grid``."""
    opened = open_grid(record, image, rules)
    data = np.empty(opened.info.shape, np.int8)
    for first, rows in opened.blocks():
        data[first : first + len(rows)] = rows
    return GridMap(data, opened.info)


def save_map(grid: GridMap, image_name: str) -> tuple[bytes, bytes]:
    """Return the files of a map, from which ``load_map`` reads the same cells.

    A grid of free, occupied and unknown cells becomes a trinary map, as map_saver writes it. A grid with graded cells
    becomes a raw map, which map_server and Nav2 interpret equally.

    Parameters
    ----------
    grid : GridMap
        The map.
    image_name : str
        Name of the image file, for the YAML file.

    Returns
    -------
    tuple of bytes
        The YAML file and the PGM file.
    """
    graded = bool(((grid.data != FREE) & (grid.data != OCCUPIED) & (grid.data != UNKNOWN)).any())
    pixels = grid.data.view(np.uint8) if graded else _trinary_pixels(grid.data)
    origin = grid.info.origin
    keys = {
        "image": image_name,
        "mode": (Mode.RAW if graded else Mode.TRINARY).value,
        "resolution": float(grid.info.resolution),
        "origin": [float(origin.x), float(origin.y), float(origin.theta)],
        "negate": 0,
        "occupied_thresh": 0.65,
        "free_thresh": 0.196,
    }
    return dump_yaml(keys), write_pgm(pixels[::-1])


def _trinary_pixels(data: NDArray[np.int8]) -> NDArray[np.uint8]:
    pixels = np.full(data.shape, _UNKNOWN_PIXEL, np.uint8)
    pixels[data == FREE] = _FREE_PIXEL
    pixels[data == OCCUPIED] = _OCCUPIED_PIXEL
    return pixels
