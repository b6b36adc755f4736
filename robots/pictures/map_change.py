"""Picture of the difference between two versions of a map."""

import mmap
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from ppaas.errors import InvalidInput
from ppaas.maps.formats.difference import difference, old_rows
from ppaas.maps.formats.map_files import GridRows, open_grid
from ppaas.maps.grid import FREE, OCCUPIED_THRESHOLD, UNKNOWN

MOST = 1600
"""Longest side of a picture [pixels]."""

_SHADES = np.array([[238, 241, 244], [120, 126, 134], [206, 211, 216]], np.uint8)  # free, obstacle, unknown
_BECAME = np.array([[20, 140, 85], [205, 38, 74], [226, 142, 20]], np.uint8)  # the same, where it was something else
_FRAME = (23, 95, 214)

Side = tuple[bytes, Path]
"""YAML of a map, and the path of its image."""


def write_change(picture: Path, old: Side, new: Side) -> None:
    """Draw the newer map with the changed cells in colour and a frame around them, as a PNG file.

    Green cells became free, red ones obstacles, and orange ones unknown.

    Raises
    ------
    InvalidMap
        One of the maps cannot be read.
    InvalidInput
        The maps differ in resolution or origin, or the file cannot be written.
    """
    before, after = _opened(old), _opened(new)
    found = difference(before, after)
    if not found.aligned:
        raise InvalidInput("the versions differ in resolution or origin, so they cannot be drawn on one grid")
    step = -(-max(after.info.width, after.info.height) // MOST)
    image = Image.fromarray(_pixels(before, after, step)[::-1])
    if found.rectangle is not None:
        column, row, width, height = found.rectangle
        top = after.info.height - row - height
        box = (column, top, column + width, top + height)
        ImageDraw.Draw(image).rectangle(
            [side / step + grow for side, grow in zip(box, (-2, -2, 1, 1), strict=True)], outline=_FRAME
        )
    try:
        image.save(picture)
    except OSError as error:
        raise InvalidInput(f"cannot write the picture: {error}") from error


def _opened(side: Side) -> GridRows:
    yaml, image = side
    with image.open("rb") as file:
        return open_grid(yaml, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ))


def _pixels(before: GridRows, after: GridRows, step: int) -> NDArray[np.uint8]:
    """Return a pixel for each square of ``step`` × ``step`` cells, coloured if any of its cells changed."""
    bands = []
    for first in range(0, after.info.height, step):
        cells = after.rows(first, min(first + step, after.info.height))
        differs = cells != old_rows(before, after.info, first, first + len(cells))
        kinds = _kinds(cells)
        starts = np.arange(0, cells.shape[1], step)
        colours = _SHADES[np.maximum.reduceat(np.where(kinds == 1, 1, 0).max(axis=0), starts)]
        unknown = np.logical_and.reduceat((kinds == 2).all(axis=0), starts)
        colours[unknown] = _SHADES[2]
        for kind in (2, 0, 1):
            colours[np.logical_or.reduceat((differs & (kinds == kind)).any(axis=0), starts)] = _BECAME[kind]
        bands.append(colours)
    return np.stack(bands)


def _kinds(cells: NDArray[np.int8]) -> NDArray[np.int8]:
    """Return 0 for free cells, 1 for obstacles, 2 for unknown cells."""
    return np.select([cells == UNKNOWN, cells >= OCCUPIED_THRESHOLD], [2, 1], FREE).astype(np.int8)
