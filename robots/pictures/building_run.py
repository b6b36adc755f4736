"""Picture of a run in a building: floors side by side with the ways of robots, and their rides (extra ``plot``)."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ppaas.maps.grid import GridMap
from robots.pictures.figure_file import write_figure
from robots.pictures.map_pictures import draw_zones

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Points = Sequence[tuple[float, float]]

FLOOR, TIMELINE = 4.2, 2.6
"""Width of a floor, and height of the timeline [inches, at 100 pixels each]."""

CAR = "0.75"
"""Colour of the cars of lifts."""


@dataclass(frozen=True, slots=True)
class RunFloor:
    """Floor to draw: its name, its height [m], its map, and the zones on it as GeoJSON."""

    name: str
    height: float
    grid: GridMap
    geojson: bytes


@dataclass(frozen=True, slots=True)
class RobotRun:
    """Run of a robot: its name, its heights over the time [s, m], and its ways on each floor as x, y [m]."""

    name: str
    heights: Points
    ways: Mapping[str, Sequence[Points]]


def write_run(path: Path, floors: Sequence[RunFloor], robots: Sequence[RobotRun], cars: Mapping[str, Points]) -> None:
    """Draw a run, and write the picture to a PNG file.

    Parameters
    ----------
    path : Path
    floors : sequence of RunFloor
    robots : sequence of RobotRun
    cars : mapping of str to sequence of (float, float)
        Height of the car of each lift over the time [s, m].

    Raises
    ------
    InvalidInput
        The file name does not end with ``.png``, or the file cannot be written.
    """
    write_figure(path, draw_run(floors, robots, cars))


def draw_run(floors: Sequence[RunFloor], robots: Sequence[RobotRun], cars: Mapping[str, Points]) -> "Figure":
    """Return the picture; each robot has one colour."""
    from matplotlib.figure import Figure  # noqa: PLC0415 - heavy, and of the extra plot

    width, height = _size(floors)
    figure = Figure(figsize=(width, height + TIMELINE), dpi=100, layout="constrained")
    grid = figure.add_gridspec(2, len(floors), height_ratios=(height, TIMELINE))
    for number, floor in enumerate(floors):
        _draw_floor(figure.add_subplot(grid[0, number]), floor, robots)
    _draw_times(figure.add_subplot(grid[1, :]), floors, robots, cars)
    return figure


def _size(floors: Sequence[RunFloor]) -> tuple[float, float]:
    rows, columns = np.max([floor.grid.info.shape for floor in floors], axis=0)
    return FLOOR * len(floors), FLOOR * float(rows) / float(columns) + 0.4


def _draw_floor(axes: "Axes", floor: RunFloor, robots: Sequence[RobotRun]) -> None:
    image = draw_zones(floor.grid, floor.geojson)
    axes.imshow(image.picture)
    axes.set_title(floor.name, loc="left")
    axes.set_axis_off()
    for number, robot in enumerate(robots):
        for way in robot.ways.get(floor.name, ()):
            pixels = np.array(image.pixels(np.array(way, float)), float)
            axes.plot(pixels[:, 0], pixels[:, 1], color=f"C{number}", linewidth=2.0)
            axes.plot(*pixels[-1], "o", color=f"C{number}", markersize=5.0)


def _draw_times(
    axes: "Axes", floors: Sequence[RunFloor], robots: Sequence[RobotRun], cars: Mapping[str, Points]
) -> None:
    for number, (name, points) in enumerate(cars.items()):
        style = ("-", "--", ":", "-.")[number % 4]
        axes.plot(*np.array(points, float).T, style, color=CAR, linewidth=3.0, label=f"lift {name}")
    for number, robot in enumerate(robots):
        axes.plot(*np.array(robot.heights, float).T, color=f"C{number}", label=robot.name)
    axes.set_yticks([floor.height for floor in floors], [floor.name for floor in floors])
    axes.set_xlabel("time [s]")
    axes.margins(x=0.0)
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)
