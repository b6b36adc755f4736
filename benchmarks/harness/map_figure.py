"""Matplotlib figures of a map in metres, on which benches draw drives."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D
from ppaas.maps.grid import FREE, OCCUPIED, GridInfo, GridMap

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

EDGE = 12.0
"""Longer edge of a figure [inches, at 100 pixels each]."""

TITLE = 0.6
"""Height that titles take [inches]."""

WALL, FLOOR, UNKNOWN = (52, 60, 72), (255, 255, 255), (214, 219, 226)
"""RGB colours of occupied, free and unknown cells."""


def map_figure(grid: GridMap) -> tuple["Figure", "Axes"]:
    """Return a figure that shows a map, and its axes, in metres of the map frame."""
    colours = np.full((*grid.data.shape, 3), UNKNOWN, np.uint8)
    colours[grid.data == FREE] = FLOOR
    colours[grid.data >= OCCUPIED] = WALL
    corners = [
        grid.info.origin @ Pose2D(x * grid.info.resolution, y * grid.info.resolution)
        for x in (0, grid.info.width)
        for y in (0, grid.info.height)
    ]
    points = np.array([(corner.x, corner.y) for corner in corners])
    figure, axes = empty_figure(points.min(axis=0), points.max(axis=0))
    show_cells(axes, colours, grid.info)
    return figure, axes


def empty_figure(low: NDArray[np.float64], high: NDArray[np.float64]) -> tuple["Figure", "Axes"]:
    """Return a figure and its axes, which show a rectangle from corner ``low`` (x, y) to corner ``high`` [m]."""
    from matplotlib.figure import Figure  # noqa: PLC0415 - heavy, and of the extra plot

    width, height = ((high - low) * EDGE / np.max(high - low)).tolist()
    figure = Figure(figsize=(width, height + TITLE), dpi=100, layout="constrained")
    axes = figure.add_subplot(aspect="equal", xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    return figure, axes


def show_cells(axes: "Axes", colours: NDArray[np.uint8], info: GridInfo, frame: Pose2D | None = None) -> None:
    """Draw the cells of a grid.

    Parameters
    ----------
    axes : Axes
        In metres.
    colours : (height, width, 3) or (height, width, 4) uint8 array
        RGB or RGBA of each cell.
    info : GridInfo
        Size, resolution and origin of the grid.
    frame : Pose2D, optional
        Pose of the frame of the grid in the frame of the axes; by default they are the same.
    """
    from matplotlib.transforms import Affine2D  # noqa: PLC0415

    corner = (frame or Pose2D(0.0, 0.0)) @ info.origin
    to_frame = Affine2D().scale(info.resolution).rotate(corner.theta).translate(corner.x, corner.y)
    limits = axes.axis()  # the image would change them
    image = axes.imshow(colours, origin="lower", extent=(0, info.width, 0, info.height), interpolation="nearest")
    image.set_transform(to_frame + axes.transData)
    axes.axis(limits)
