"""Map files of ROS's map_server and of Nav2: a YAML record and an image, from bytes to a grid and back."""

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D
from ppaas.maps.grid import FREE, OCCUPIED, UNKNOWN, GridInfo, GridMap
from ppaas.maps.image import parse_image
from ppaas.maps.pgm import write_pgm
from ppaas.maps.record import Mode, Rules, dump_yaml, parse_yaml
from ppaas.maps.thresholds import occupancy

_FREE_PIXEL, _OCCUPIED_PIXEL, _UNKNOWN_PIXEL = 254, 0, 205


def load_map(record: bytes, image: bytes, rules: Rules | None = None) -> GridMap:
    """Read a map from the bytes of its two files.

    Parameters
    ----------
    record : bytes
        The YAML file; its ``image`` is not looked at.
    image : bytes
        The PGM or PNG file; its lowest row becomes row 0 of the grid.
    rules : Rules, optional
        Whose rules tell free from occupied; without them those that the record names, else map_server's.

    Raises
    ------
    InvalidMap
        One of the two cannot be read; the text says where.
    """
    keys = parse_yaml(record, rules)
    cells = occupancy(parse_image(image), keys)
    height, width = cells.shape
    info = GridInfo(keys.resolution, width, height, Pose2D(*keys.origin))
    return GridMap(np.ascontiguousarray(cells[::-1]), info)


def save_map(grid: GridMap, image_name: str) -> tuple[bytes, bytes]:
    """Write a map so that ``load_map`` reads the same cells again.

    A grid of free, occupied and unknown cells becomes a trinary map, as map_saver writes it. One with graded cells
    becomes a raw map, which map_server and Nav2 read alike.

    Parameters
    ----------
    grid : GridMap
        What to write.
    image_name : str
        What the YAML shall call the image.

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
