"""Map canvas: an occupancy grid that grows, and to which key frames are added one by one."""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import QuotaExceeded
from ppaas.geometry import Pose2D
from ppaas.mapping.key_frames import KeyFrames
from ppaas.mapping.map_drawing import DEFAULTS, MARGIN, MOST_CELLS, DrawingSettings, bounds, count_beams, occupancy
from ppaas.mapping.parts.map_parts import WHOLE, MapParts
from ppaas.maps.cell_rectangle import Rectangle
from ppaas.maps.grid import UNKNOWN, GridInfo

BLOCK = 128
"""The canvas grows by blocks of this edge, so that its corner seldom moves [cells]."""


class MapCanvas:
    """Occupancy grid of the key frames drawn so far. A cell takes 5 bytes.

    Parameters
    ----------
    settings : DrawingSettings
        Resolution and thresholds.
    extent : Rectangle, optional
        Least extent, in cells from the origin of the map frame.

    Attributes
    ----------
    extent : Rectangle or None
        Extent in cells from the origin of the map frame; None before the first key frame.
    cells : (h, w) int8 array
        Occupancy; modified by `draw`.
    """

    def __init__(self, settings: DrawingSettings = DEFAULTS, extent: Rectangle | None = None) -> None:
        self.extent: Rectangle | None = None
        self.cells: NDArray[np.int8] = np.empty((0, 0), np.int8)
        self._settings = settings
        self._ended = self._passed = np.empty((0, 0), np.uint16)
        self._touched: Rectangle | None = None
        if extent is not None:
            self._grow(extent)

    @property
    def info(self) -> GridInfo:
        """Geometry of the grid; there must be a key frame."""
        assert self.extent is not None
        resolution, (height, width) = self._settings.resolution, self.extent.shape
        origin = Pose2D(self.extent.column * resolution, self.extent.row * resolution, 0.0)
        return GridInfo(resolution, width, height, origin)

    def take_touched(self) -> Rectangle | None:
        """Return the cells of the grid that may have changed since the last call; None if none."""
        if self._touched is None or self.extent is None:
            return None
        touched, self._touched = self._touched.moved(-self.extent.row, -self.extent.column), None
        return touched

    def draw(self, key_frames: KeyFrames, first: int, end: int | None = None) -> None:
        """Add the key frames from an index on, to before another one, at their poses.

        Raises
        ------
        QuotaExceeded
            The map would have more than `MOST_CELLS` cells; it is left unchanged.
        """
        part = slice(first, end)
        poses, points, valid = key_frames.poses[part], key_frames.points[part], key_frames.valid[part]
        if not len(poses):
            return
        seen = self._around(*bounds(poses, points, valid))
        self._grow(seen)
        count_beams((self._ended, self._passed), self.info, poses, points, valid)
        assert self.extent is not None
        cells = seen.moved(-self.extent.row, -self.extent.column).slices
        self.cells[cells] = occupancy(self._ended[cells], self._passed[cells], self._settings)
        self._touched = seen if self._touched is None else seen.around(self._touched)

    def _around(self, x0: float, y0: float, x1: float, y1: float) -> Rectangle:
        """Return the cells of a rectangle [m], with a margin."""
        column, row, last_column, last_row = (
            math.floor(value / self._settings.resolution) for value in (x0, y0, x1, y1)
        )
        return Rectangle(row - MARGIN, column - MARGIN, last_row + MARGIN + 1, last_column + MARGIN + 1)

    def _grow(self, needed: Rectangle) -> None:
        low = (value // BLOCK * BLOCK for value in needed[:2])
        high = (-(-value // BLOCK) * BLOCK for value in needed[2:])
        extent = Rectangle(*low, *high)
        if self.extent is not None:
            extent = extent.around(self.extent)
        if extent == self.extent:
            return
        height, width = extent.shape
        if height * width > MOST_CELLS:
            raise QuotaExceeded(
                f"the map would have {width} × {height} cells, and at most {MOST_CELLS} are allowed: "
                "choose a coarser resolution or a smaller max_laser_range"
            )
        self.cells = self._extended(self.cells, extent, UNKNOWN)
        self._ended = self._extended(self._ended, extent, 0)
        self._passed = self._extended(self._passed, extent, 0)
        self.extent = extent

    def _extended(self, array: NDArray[np.generic], extent: Rectangle, value: int) -> NDArray:  # type: ignore[type-arg]
        grown = np.full(extent.shape, value, array.dtype)
        if self.extent is not None:
            grown[self.extent.moved(-extent.row, -extent.column).slices] = array
        return grown


def drawn(
    frames: KeyFrames, settings: DrawingSettings, extent: Rectangle | None = None, parts: MapParts = WHOLE
) -> MapCanvas | None:
    """Return the map of key frames; None if it would be too large.

    Parameters
    ----------
    frames : KeyFrames
    settings : DrawingSettings
    extent : Rectangle, optional
        Least extent, in cells from the origin of the map frame.
    parts : MapParts
        Parts of the map, of which the current one is drawn.
    """
    try:
        canvas = MapCanvas(settings, extent)
        for run in parts.runs(parts.current, len(frames)):
            canvas.draw(frames, run.start, run.stop)
    except QuotaExceeded:
        return None
    return canvas
