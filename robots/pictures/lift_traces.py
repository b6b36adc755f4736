"""Picture of a run of many robots in a building: their tracks on floors side by side, and what each lift did."""

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput
from ppaas.maps.grid import FREE, OCCUPIED, GridMap
from robots.pictures.figure_file import write_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

T = TypeVar("T")

WIDTH, MAPS, TIMELINE = 14.0, 3.6, 1.9
"""Width of the picture, height of the floors and of the timeline of a lift [inches, at 100 pixels each]."""

PALETTE = "tab20"
"""Colours of robots."""

CLOSED, DOORS = "0.6", {"open": "tab:green", "offline": "tab:red"}
"""Colours of a car that drives, and of one that stands open, or is out of order."""


@dataclass(frozen=True, slots=True)
class FloorTracks:
    """Floor, and where robots drove on it.

    Parameters
    ----------
    name : str
    grid : GridMap
    tracks : sequence of (int, (n, 2) float64 array)
        Parts of tracks, each with the number of its robot and its places x, y [m].
    """

    name: str
    grid: GridMap
    tracks: Sequence[tuple[int, NDArray[np.float64]]]


@dataclass(frozen=True, slots=True)
class LiftTrace:
    """What a lift did, at the times of a run.

    Parameters
    ----------
    name : str
    floors : sequence of int
        Number of the floor where the car was, from below.
    doors : sequence of str
        ``open``, ``closed`` or ``moving``; ``offline`` while it is out of order.
    riders : sequence of sequence of (int, int)
        Robots in the car: place and number of each.
    """

    name: str
    floors: Sequence[int]
    doors: Sequence[str]
    riders: Sequence[Sequence[tuple[int, int]]]


def write_lift_traces(
    path: Path, floors: Sequence[FloorTracks], times: Sequence[float], lifts: Sequence[LiftTrace]
) -> None:
    """Draw a run, and write it to a PNG file.

    Raises
    ------
    InvalidInput
        There are no times, the file name does not end with ``.png``, or the file cannot be written.
    """
    if not times:
        raise InvalidInput("nothing was recorded, so there is nothing to draw")
    write_figure(path, draw_lift_traces(floors, times, lifts))


def draw_lift_traces(floors: Sequence[FloorTracks], times: Sequence[float], lifts: Sequence[LiftTrace]) -> "Figure":
    """Return the picture: robots have one colour in tracks and lifts."""
    from matplotlib.figure import Figure  # noqa: PLC0415 - heavy, and of the extra plot

    figure = Figure(figsize=(WIDTH, MAPS + TIMELINE * len(lifts)), dpi=100, layout="constrained")
    upper, lower = figure.subfigures(2, 1, squeeze=False, height_ratios=(MAPS, max(TIMELINE * len(lifts), 0.1)))[:, 0]
    for axes, floor in zip(upper.subplots(1, len(floors), squeeze=False)[0], floors, strict=True):
        _draw_floor(axes, floor)
    if lifts:
        drawn = lower.subplots(len(lifts), 1, squeeze=False, sharex=True)[:, 0]
        for axes, lift in zip(drawn, lifts, strict=True):
            _draw_lift(axes, [floor.name for floor in floors], times, lift)
        drawn[-1].set_xlabel("time [s]")
    return figure


def colour_of(robot: int) -> tuple[float, ...]:
    """Return the colour of a robot."""
    from matplotlib import colormaps  # noqa: PLC0415 - see above

    colours = colormaps[PALETTE]
    return tuple(colours(robot % colours.N))


def _draw_floor(axes: "Axes", floor: FloorTracks) -> None:
    info, data = floor.grid.info, floor.grid.data
    shade = np.where(data == OCCUPIED, 0.25, np.where(data == FREE, 1.0, 0.85))
    corners = info.to_world(np.array([(-0.5, -0.5), (info.height - 0.5, info.width - 0.5)]))
    (x0, y0), (x1, y1) = corners.tolist()
    axes.imshow(shade, cmap="gray", vmin=0.0, vmax=1.0, origin="lower", extent=(x0, x1, y0, y1))
    for robot, places in floor.tracks:
        axes.plot(places[:, 0], places[:, 1], color=colour_of(robot), linewidth=0.8, alpha=0.8)
    axes.set(title=floor.name, xticks=(), yticks=(), aspect="equal")


def _draw_lift(axes: "Axes", names: Sequence[str], times: Sequence[float], lift: LiftTrace) -> None:
    axes.step(times, lift.floors, where="post", color=CLOSED, linewidth=1.0)
    at = list(zip(lift.floors, lift.doors, strict=True))
    for (floor, door), begin, end in _spans(times, at):
        if door in DOORS:
            axes.broken_barh([(begin, end - begin)], (floor - 0.06, 0.12), facecolors=DOORS[door], linewidth=0.0)
    for place in sorted({place for riders in lift.riders for place, _ in riders}):
        riding = [(floor, dict(riders).get(place)) for floor, riders in zip(lift.floors, lift.riders, strict=True)]
        for (floor, robot), begin, end in _spans(times, riding):
            if robot is not None:
                low = floor + 0.12 + 0.16 * place
                axes.broken_barh([(begin, end - begin)], (low, 0.14), facecolors=[colour_of(robot)], linewidth=0.0)
    axes.set_yticks(range(len(names)), names)
    axes.set(title=lift.name, ylim=(-0.3, len(names) - 0.3), xlim=(times[0], times[-1]))
    axes.grid(axis="x", color="0.9")
    axes.set_axisbelow(True)


def _spans(times: Sequence[float], values: Sequence[T]) -> Iterator[tuple[T, float, float]]:
    """Yield each value with the times between which it stays."""
    begin = 0
    for _, group in itertools.groupby(values):
        end = begin + len(list(group))
        yield values[begin], times[begin], times[min(end, len(times) - 1)]
        begin = end
