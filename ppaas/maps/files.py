"""Map files of ROS's map_server: a YAML record and a PGM image, from bytes to a grid and back.

Follows ``image_loader.cpp`` and ``map_saver.cpp`` of ros-planning/navigation. Where map_server's raw mode would give
values that an occupancy grid cannot hold, Nav2's rule is taken: they are unknown.
"""

import math
from enum import Enum
from typing import Annotated

import msgspec
import numpy as np
import yaml
from msgspec import Meta
from numpy.typing import NDArray

from ppaas.errors import InvalidMap
from ppaas.geometry import Pose2D
from ppaas.maps.grid import FREE, OCCUPIED, UNKNOWN, GridInfo, GridMap
from ppaas.maps.pgm import parse_pgm, write_pgm

MAX_YAML = 1 << 16
"""Longest record that is read [bytes]."""

_FREE_PIXEL, _OCCUPIED_PIXEL, _UNKNOWN_PIXEL = 254, 0, 205
_Threshold = Annotated[float, Meta(ge=0.0, le=1.0)]


class Mode(Enum):
    """How grey becomes occupancy."""

    TRINARY = "trinary"
    SCALE = "scale"
    RAW = "raw"


class MapYaml(msgspec.Struct, frozen=True, kw_only=True):
    """The keys of a map_server record.

    Parameters
    ----------
    image : str
        Name of the image file.
    resolution : float
        Edge of a pixel [m].
    origin : tuple of float
        x, y [m] and yaw [rad] of the lower-left corner of the lower-left pixel.
    negate : bool
        White is occupied, and black free.
    occupied_thresh, free_thresh : float
        Occupancy (0 to 1) above which a cell is occupied, and below which it is free.
    mode : Mode
        ``trinary``: free, occupied, unknown. ``scale``: graded between the thresholds. ``raw``: the pixel is the value.
    """

    image: Annotated[str, Meta(min_length=1)]
    resolution: Annotated[float, Meta(gt=0.0)]
    origin: tuple[float, float, float]
    negate: bool = False
    occupied_thresh: _Threshold = 0.65
    free_thresh: _Threshold = 0.196
    mode: Mode = Mode.TRINARY

    def __post_init__(self) -> None:
        numbers = (self.resolution, *self.origin, self.occupied_thresh, self.free_thresh)
        if not all(map(math.isfinite, numbers)):
            raise ValueError("resolution, origin, occupied_thresh and free_thresh must be finite")
        if self.free_thresh >= self.occupied_thresh:
            raise ValueError(f"free_thresh {self.free_thresh} must be below occupied_thresh {self.occupied_thresh}")


# What PyYAML's constructors let through on scalars such as `!!bool x`, beside its own errors.
_YAML_ERRORS = (yaml.YAMLError, ValueError, KeyError, AttributeError, RecursionError)


def parse_yaml(record: bytes) -> MapYaml:
    """Read the record of a map.

    Raises
    ------
    InvalidMap
        Not YAML, or a key is missing or cannot be what it says; the text names the key.
    """
    if len(record) > MAX_YAML:
        raise InvalidMap(f"the map's YAML has {len(record)} bytes; at most {MAX_YAML} are read")
    try:
        keys = yaml.safe_load(record)
    except _YAML_ERRORS as error:
        raise InvalidMap(f"the map's YAML cannot be read: {error}") from error
    try:
        # Not strict: YAML 1.1 takes 5e-2 and "0.05" for strings, and roscpp does not.
        return msgspec.convert(keys, MapYaml, strict=False)
    except (msgspec.ValidationError, RecursionError) as error:
        raise InvalidMap(f"the map's YAML is not a map_server record: {error}") from error


def load_map(record: bytes, image: bytes) -> GridMap:
    """Read a map from the bytes of its two files.

    Parameters
    ----------
    record : bytes
        The YAML file; its ``image`` is not looked at.
    image : bytes
        The PGM file; its lowest row becomes row 0 of the grid.

    Raises
    ------
    InvalidMap
        One of the two cannot be read; the text says where.
    """
    keys = parse_yaml(record)
    pixels = parse_pgm(image)
    height, width = pixels.shape
    info = GridInfo(keys.resolution, width, height, Pose2D(*keys.origin))
    return GridMap(_occupancy_of_grey(keys)[pixels[::-1]], info)


def _occupancy_of_grey(keys: MapYaml) -> NDArray[np.int8]:
    """Return the occupancy of each of the 256 greys."""
    grey = np.arange(256)
    grey = 255 - grey if keys.negate else grey
    if keys.mode is Mode.RAW:
        return np.where(grey <= OCCUPIED, grey, UNKNOWN).astype(np.int8)
    occupancy = (255 - grey) / 255.0
    between = np.full(256, float(UNKNOWN))
    if keys.mode is Mode.SCALE:
        between = 1.0 + 98.0 * (occupancy - keys.free_thresh) / (keys.occupied_thresh - keys.free_thresh)
    decided = np.where(
        occupancy > keys.occupied_thresh, OCCUPIED, np.where(occupancy < keys.free_thresh, FREE, between)
    )
    return decided.astype(np.int8)


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
    text = yaml.safe_dump(keys, sort_keys=False, default_flow_style=None)
    return text.encode(), write_pgm(pixels[::-1])


def _trinary_pixels(data: NDArray[np.int8]) -> NDArray[np.uint8]:
    pixels = np.full(data.shape, _UNKNOWN_PIXEL, np.uint8)
    pixels[data == FREE] = _FREE_PIXEL
    pixels[data == OCCUPIED] = _OCCUPIED_PIXEL
    return pixels
