"""Map files of map_server and Nav2, a YAML record and an image: reading and writing of grids."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D
from ppaas.maps.buffer import Buffer
from ppaas.maps.formats.image import ImageRows, image_size, open_image
from ppaas.maps.formats.map_yaml import MapYaml, Mode, Rules, dump_yaml, parse_yaml
from ppaas.maps.formats.pgm import write_pgm
from ppaas.maps.formats.thresholds import occupancy
from ppaas.maps.grid import FREE, OCCUPIED, UNKNOWN, GridInfo, GridMap

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
