"""Image of a map, with north up, on which something else is drawn."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from ppaas.errors import InvalidInput
from ppaas.maps.grid import FREE, OCCUPIED_THRESHOLD, UNKNOWN, GridInfo, GridMap

_FREE, _WALL, _UNKNOWN = (255, 255, 255), (40, 46, 56), (214, 219, 226)


@dataclass(frozen=True, slots=True)
class GridImage:
    """Image of a map.

    Parameters
    ----------
    picture : Image
    info : GridInfo
        Geometry of the map.
    scale : float
        Edge of a pixel [m].
    """

    picture: Image.Image
    info: GridInfo
    scale: float

    @classmethod
    def of(cls, grid: GridMap, most: int, least: int = 0) -> "GridImage":
        """Return the image of a map.

        Parameters
        ----------
        grid : GridMap
            A wall in a reduced cell stays visible.
        most, least : int
            Longest side of the image [pixels]: larger and smaller maps are reduced and enlarged by whole factors.
        """
        longest = max(grid.data.shape)
        factor, larger = max(1, -(-longest // most)), max(1, least // longest)
        picture = Image.fromarray(_colours(_reduced(grid.data, factor))[::-1])
        if larger > 1:
            picture = picture.resize((picture.width * larger, picture.height * larger), Image.Resampling.NEAREST)
        return cls(picture, grid.info, grid.info.resolution * factor / larger)

    def pixels(self, points: NDArray[np.float64]) -> list[tuple[float, float]]:
        """Return the pixels of (n, 2) points in the frame of the map [m]; the map is not turned in it."""
        found = (points - (self.info.origin.x, self.info.origin.y)) / self.scale
        return [(float(x), float(self.picture.height - y)) for x, y in found]

    def write(self, path: Path) -> None:
        """Write the picture to a file; raise ``InvalidInput`` if that fails."""
        try:
            self.picture.save(path)
        except OSError as error:
            raise InvalidInput(f"cannot write the picture: {error}") from error


def _reduced(cells: NDArray[np.int8], factor: int) -> NDArray[np.int8]:
    """Return cells of which each is the maximum of ``factor``² ones, so that walls win over free and unknown cells."""
    if factor == 1:
        return cells
    height, width = (-(-side // factor) for side in cells.shape)
    padded = np.full((height * factor, width * factor), UNKNOWN, np.int8)
    padded[: cells.shape[0], : cells.shape[1]] = cells
    reduced: NDArray[np.int8] = padded.reshape(height, factor, width, factor).max(axis=(1, 3))
    return reduced


def _colours(cells: NDArray[np.int8]) -> NDArray[np.uint8]:
    colours = np.full((*cells.shape, 3), _UNKNOWN, np.uint8)
    colours[(cells >= FREE) & (cells < OCCUPIED_THRESHOLD)] = _FREE
    colours[cells >= OCCUPIED_THRESHOLD] = _WALL
    return colours
