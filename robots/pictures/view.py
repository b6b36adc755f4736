"""View of a costmap: the part that a picture shows, its scale, and the pixel of a point."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from PIL import Image

from ppaas.costmap.costmap import INSCRIBED_INFLATED_OBSTACLE, LETHAL_OBSTACLE, NO_INFORMATION, Costmap

WIDEST, HIGHEST = 1400, 1000
"""Largest size of the map in the picture [pixels]."""

OVERSAMPLING = 2
"""Factor by which everything is drawn larger and then reduced, for smooth lines."""

MARGIN = 8
"""Margin around the known cells [cells]."""

FREE, UNKNOWN, OBSTACLE = (253, 253, 251), (221, 225, 230), (40, 46, 56)
NEAR, FAR, INSCRIBED = (247, 178, 103), (253, 240, 222), (238, 125, 88)


def palette() -> NDArray[np.uint8]:
    """Return the (256, 3) RGB colours of the costs."""
    share = np.linspace(0.0, 1.0, LETHAL_OBSTACLE)[:, np.newaxis]
    colours = np.zeros((256, 3))
    colours[:LETHAL_OBSTACLE] = (1.0 - share) * FAR + share * NEAR
    for cost, colour in (
        (0, FREE), (INSCRIBED_INFLATED_OBSTACLE, INSCRIBED), (LETHAL_OBSTACLE, OBSTACLE), (NO_INFORMATION, UNKNOWN),
    ):  # fmt: skip
        colours[cost] = colour
    return colours.astype(np.uint8)


@dataclass(frozen=True, slots=True)
class View:
    """Magnified window of a costmap.

    Parameters
    ----------
    costmap : Costmap
        The whole costmap.
    top, bottom, left, right : int
        Bounds of the window [cells]; ``top`` and ``right`` are exclusive.
    scale : float
        Pixels per cell.
    """

    costmap: Costmap
    top: int
    bottom: int
    left: int
    right: int
    scale: float

    @classmethod
    def of(cls, costmap: Costmap, points: NDArray[np.float64]) -> "View":
        """Return the view that contains all known cells and some points."""
        height, width = costmap.data.shape
        known = costmap.data != NO_INFORMATION
        rows, columns = np.flatnonzero(known.any(axis=1)), np.flatnonzero(known.any(axis=0))
        cells = costmap.info.to_cells(points)
        rows, columns = np.concatenate((rows, cells[:, 0])), np.concatenate((columns, cells[:, 1]))
        bottom, top = max(0, rows.min() - MARGIN), min(height, rows.max() + 1 + MARGIN)
        left, right = max(0, columns.min() - MARGIN), min(width, columns.max() + 1 + MARGIN)
        fits = min(WIDEST / (right - left), HIGHEST / (top - bottom))
        # A whole number of pixels per cell if possible, so all cells have the same size.
        scale = OVERSAMPLING * (float(int(fits)) if fits >= 1.0 else fits)
        return cls(costmap, int(top), int(bottom), int(left), int(right), scale)

    @property
    def size(self) -> tuple[int, int]:
        """Width and height [pixels]."""
        width, height = (self.right - self.left) * self.scale, (self.top - self.bottom) * self.scale
        return max(1, round(width)), max(1, round(height))

    def picture(self) -> Image.Image:
        """Return the image of the costmap."""
        cells = self.costmap.data[self.bottom : self.top, self.left : self.right][::-1]
        coloured = Image.fromarray(palette()[cells])
        how = Image.Resampling.NEAREST if self.scale >= 1.0 else Image.Resampling.BOX
        return coloured.resize(self.size, how)

    def pixels(self, points: ArrayLike) -> list[tuple[float, float]]:
        """Return the pixels of (n, 2) points [m], counted from the upper left corner."""
        info = self.costmap.info
        local = np.asarray(points, dtype=np.float64) - (info.origin.x, info.origin.y)
        c, s = np.cos(info.origin.theta), np.sin(info.origin.theta)
        columns = (c * local[:, 0] + s * local[:, 1]) / info.resolution - self.left
        rows = self.top - (c * local[:, 1] - s * local[:, 0]) / info.resolution
        return list(zip((columns * self.scale).tolist(), (rows * self.scale).tolist(), strict=True))

    @property
    def metre(self) -> float:
        """Pixels per metre."""
        return self.scale / self.costmap.info.resolution
