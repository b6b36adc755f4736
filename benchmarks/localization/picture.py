"""Picture of a replayed recording: the map, the true path, and the path that localization estimated."""

from pathlib import Path
from typing import TYPE_CHECKING

from benchmarks.harness.map_figure import map_figure
from benchmarks.localization.replay import Replay
from ppaas.maps.grid import GridMap
from robots.pictures.figure_file import write_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TRUE, ESTIMATED, ERROR = "#148c55", "#175fd6", "#cd264a"

LARGE_ERROR = 0.25
"""Smallest error that is drawn as a line from the true to the estimated position [m]."""


def write_picture(path: Path, grid: GridMap, replay: Replay) -> None:
    """Draw a replay into a PNG file.

    Raises
    ------
    InvalidInput
        The file name does not end with ``.png``, or the file cannot be written.
    """
    write_figure(path, draw(grid, replay))


def draw(grid: GridMap, replay: Replay) -> "Figure":
    """Return the picture: the true path in green, the estimated one in blue, and large errors in red."""
    figure, axes = map_figure(grid)
    pairs = [(look.true, told) for look, told in zip(replay.looks, replay.told, strict=True)]
    for true, estimated in pairs:
        if true is not None and true.distance_to(estimated) >= LARGE_ERROR:
            axes.plot([true.x, estimated.x], [true.y, estimated.y], color=ERROR, linewidth=0.8)
    for label, poses, colour, width in (
        ("estimated", [estimated for _, estimated in pairs], ESTIMATED, 2.0),
        ("true", [true for true, _ in pairs if true is not None], TRUE, 1.0),
    ):
        axes.plot([pose.x for pose in poses], [pose.y for pose in poses], color=colour, linewidth=width, label=label)
    figure.legend(loc="outside upper left", ncols=2, frameon=False)
    return figure
