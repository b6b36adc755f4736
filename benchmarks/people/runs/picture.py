"""Picture of one run: the map, the tracks of people by identity, the robots, and the handovers."""

from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import msgspec
import numpy as np

from benchmarks.harness.map_figure import map_figure
from benchmarks.people.runs.job import PeopleJob
from benchmarks.people.runs.run import run
from benchmarks.people.runs.scene import PeopleScene
from ppaas.maps.grid import GridMap
from robots.demo.people_score import Handovers, ScoredFrame
from robots.pictures.figure_file import write_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Point = tuple[float, float]

UNSEEN, INK = "#b9c0ca", "#1c2129"
JUMP = 1.5
"""Distance between two positions of an identity beyond which its track is drawn in two parts [m]."""


class Handover(NamedTuple):
    """A handover: its time [s], where the person was, the person's identity, and the robot that took over."""

    time: float
    at: Point
    person: int
    robot: str


class Tracks:
    """Tracks of a run.

    Attributes
    ----------
    identities : dict of int to list of (x, y)
        Positions of each identity while it was seen [m].
    people : list of list of (x, y)
        True positions of each person [m].
    robots : dict of str to list of (x, y)
        True positions of each robot [m].
    handovers : list of Handover
    """

    def __init__(self) -> None:
        self.identities: dict[int, list[Point]] = {}
        self.people: list[list[Point]] = []
        self.robots: dict[str, list[Point]] = {}
        self.handovers: list[Handover] = []
        self._counter = Handovers()

    def watch(self, scene: PeopleScene, frame: ScoredFrame) -> None:
        """Record a state of the coordinator and the truth at that time."""
        if scene.truth is None or scene.state is None:
            return
        self.people = self.people or [[] for _ in scene.truth.people]
        for track, at in zip(self.people, scene.truth.people.tolist(), strict=True):
            track.append((at[0], at[1]))
        for robot, place in scene.truth.robots.items():
            self.robots.setdefault(robot, []).append(place)
        for identity, at in zip(frame.identities, frame.positions.tolist(), strict=True):
            self.identities.setdefault(identity, []).append((at[0], at[1]))
        for order in scene.state.orders:
            if self._counter.take(scene.truth.time, order.person, order.robot):
                at = next(((p.position.x, p.position.y) for p in scene.state.people if p.id == order.person), None)
                self.handovers += [] if at is None else [Handover(scene.truth.time, at, order.person, order.robot)]


def write_picture(path: Path, job: PeopleJob) -> dict[str, Any]:
    """Simulate a run and draw it into a PNG file; return its result.

    Raises
    ------
    InvalidInput
        The file cannot be written.
    """
    tracks = Tracks()
    result = run(job, tracks.watch)
    write_figure(path, draw(job.grid, tracks))
    figures: dict[str, Any] = msgspec.to_builtins(result)
    return figures


def draw(grid: GridMap, tracks: Tracks) -> "Figure":
    """Return the picture of a run.

    Thin grey lines are the true paths of people, coloured ones the positions of each identity, dashed ones the paths of
    robots, and stars the handovers, each with the robot that took over and the time.
    """
    from matplotlib import colormaps  # noqa: PLC0415 - heavy, and of the extra plot

    figure, axes = map_figure(grid)
    for track in tracks.people:
        axes.plot(*np.array(track).T, color=UNSEEN, linewidth=1.0, zorder=2)
    palette = colormaps["tab20"].colors  # type: ignore[attr-defined]
    for identity, points in sorted(tracks.identities.items()):
        colour = palette[(identity - 1) % len(palette)]
        axes.plot(*_parted(points).T, color=colour, linewidth=2.0, zorder=3)
        axes.annotate(str(identity), points[-1], color=colour, fontsize=9, fontweight="bold", zorder=6)
    for number, (robot, points) in enumerate(tracks.robots.items()):
        axes.plot(*np.array(points).T, color=INK, linestyle=(0, (4, 1 + number % 4)), linewidth=0.8, zorder=4)
        axes.plot(*points[-1], "o", color=INK, markersize=7, zorder=5)
        axes.annotate(robot, points[-1], xytext=(5, -9), textcoords="offset points", color=INK, fontsize=9, zorder=6)
    _mark(axes, tracks.handovers)
    axes.set_title(
        "identities in colour, true paths in grey, robots dashed; a star is a handover to the robot beside it",
        fontsize=9,
    )
    return figure


def _mark(axes: "Axes", handovers: list[Handover]) -> None:
    for each in handovers:
        axes.plot(*each.at, "*", color="#cd264a", markersize=14, markeredgecolor="white", zorder=7)
        label = f"{each.robot} {int(each.time) // 60}:{int(each.time) % 60:02}"
        axes.annotate(label, each.at, xytext=(7, 5), textcoords="offset points", color="#cd264a", fontsize=9, zorder=7)


def _parted(points: list[Point]) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    """Return (n, 2) points with NaN where the track jumps."""
    track = np.array(points).reshape(-1, 2)
    jumps = np.flatnonzero(np.hypot(*np.diff(track, axis=0).T) > JUMP) + 1
    return np.insert(track, jumps, np.nan, axis=0)
