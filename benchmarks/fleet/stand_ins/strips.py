"""Cases of deadlock that users of other systems reported, and strips of pictures of their moments.

A picture shows what each robot holds and where it wants to go.
"""

from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from benchmarks.fleet.stand_ins.simulation import Simulation, roadmap_of
from ppaas.errors import InvalidInput
from ppaas.fleet.metric_roadmap import MetricRoadmap
from robots.pictures.figure_file import write_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


Place = tuple[int, int]


class ReportedCase(NamedTuple):
    """A hall in text, and starts and goals of robots, as row and column; a robot without a goal is idle.

    Parameters
    ----------
    name : str
    hall : str
    robots : tuple
    """

    name: str
    hall: str
    robots: tuple[tuple[Place, Place | None], ...]

    @property
    def goals(self) -> int:
        """Number of goals."""
        return sum(goal is not None for _, goal in self.robots)

    def simulation(self, seed: int) -> Simulation:
        """Return its simulation."""
        hall = roadmap_of(self.hall)
        simulation = Simulation(hall, seed)
        for start, goal in self.robots:
            simulation.add(int(hall.roadmap.numbers[start]), None if goal is None else int(hall.roadmap.numbers[goal]))
        return simulation


CASES = (
    ReportedCase("head-on, with a bay", "........\n###.####", (((0, 0), (0, 7)), ((0, 7), (0, 0)))),
    ReportedCase("a swap with one niche", ".....\n#.###", (((0, 0), (0, 4)), ((0, 4), (0, 0)))),
    ReportedCase(
        "a crossing",
        "###.###\n###.###\n.......\n###.###\n###.###",
        (((2, 0), (2, 6)), ((2, 6), (2, 0)), ((0, 3), (4, 3)), ((4, 3), (0, 3))),
    ),
    ReportedCase("an idle robot in the way", ".......\n###.###", (((0, 0), (0, 6)), ((0, 3), None))),
)


MOMENTS = 6
"""Number of pictures of a case."""

LONGEST = 90.0
"""Time within which all robots of a case are home [s]."""

FILE = "traffic-cases.png"

COLOURS = "#175fd6", "#d64817", "#148c55", "#8a3fd1"
WALL, FLOOR, GRID, INK = "#343c48", "#ffffff", "#d6dbe2", "#1c2129"

WIDTH, DPI = 12.0, 100
"""Width of the picture [inches], and pixels of an inch."""


class Drawn(NamedTuple):
    """A robot at a moment.

    Parameters
    ----------
    name : str
    at : tuple of float
        x, y [m].
    radius : float
        Its radius [m].
    held : list of tuple of float
        Centres of the cells that it holds [m].
    goal : tuple of float or None
        Place where it is to go [m]; None if it has arrived, or is idle.
    """

    name: str
    at: tuple[float, float]
    radius: float
    held: list[tuple[float, float]]
    goal: tuple[float, float] | None


class Moment(NamedTuple):
    """Robots at a time [s]."""

    time: float
    robots: list[Drawn]


def write_strips(folder: Path) -> Path:
    """Simulate all cases and draw them into a PNG file in a folder; return the file.

    Raises
    ------
    InvalidInput
        The file cannot be written, or some robot did not get home.
    """
    if not folder.is_dir():
        raise InvalidInput(f"there is no folder {folder}")
    path = folder / FILE
    write_figure(path, _draw([(case, moments_of(case)) for case in CASES]))
    return path


def moments_of(case: ReportedCase) -> list[Moment]:
    """Return moments of a case at equal distances, since all robots are known until they are home.

    Raises
    ------
    InvalidInput
        Some robot did not get home, or two touched.
    """
    simulation, seen = case.simulation(1), []
    while simulation.arrived < case.goals and simulation.now < LONGEST:
        simulation.step()
        moment = _seen(simulation)
        if all(robot.held for robot in moment.robots):
            seen.append(moment)
    if simulation.arrived < case.goals or simulation.contacts.count:
        raise InvalidInput(f"{case.name}: {simulation.arrived} goals, {simulation.contacts.count} contacts")
    return [seen[round(index)] for index in np.linspace(0, len(seen) - 1, MOMENTS)]


def _seen(simulation: Simulation) -> Moment:
    coordinator, robots = simulation.coordinator, []
    for robot in simulation.robots:
        member = None if coordinator is None else coordinator.members.get(robot.name)
        held = [] if member is None else [simulation.hall.centre(cell) for cell in sorted(member.held)]
        robots.append(Drawn(robot.name, robot.pose[:2], robot.radius, held, robot.goal))
    return Moment(simulation.now, robots)


# -- drawing -----------------------------------------------------------------------------------------------------------


def _draw(strips: list[tuple[ReportedCase, list[Moment]]]) -> "Figure":
    """Return the picture: a row for each case, its name above, and a time below each moment."""
    from matplotlib.figure import Figure  # noqa: PLC0415 - heavy, and of the extra plot

    halls = [case.simulation(1).hall for case, _ in strips]
    shapes = [hall.roadmap.numbers.shape for hall in halls]
    heights = [WIDTH / MOMENTS * (rows + 1.0) / (columns + 1.0) + 0.45 for rows, columns in shapes]
    figure = Figure(figsize=(WIDTH, sum(heights)), dpi=DPI, layout="constrained")
    for part, (case, moments), hall in zip(
        figure.subfigures(len(strips), 1, squeeze=False, height_ratios=heights)[:, 0], strips, halls, strict=True
    ):
        part.suptitle(case.name, x=0.01, ha="left", fontsize=12, fontweight="bold", color=INK)
        for axes, moment in zip(part.subplots(1, MOMENTS), moments, strict=True):
            _draw_hall(axes, hall)
            _draw_robots(axes, moment, hall.spacing)
            axes.set_xlabel(f"{moment.time:.0f} s", fontsize=11, color=INK)
    return figure


def _draw_hall(axes: "Axes", hall: MetricRoadmap) -> None:
    from matplotlib.patches import Rectangle  # noqa: PLC0415

    rows, columns = hall.roadmap.numbers.shape
    side = hall.spacing
    x0, y0 = hall.centres[0] - side * hall.roadmap.cells[0, ::-1]
    axes.set(
        aspect="equal", xticks=(), yticks=(), facecolor=WALL,
        xlim=(x0 - side, x0 + side * columns), ylim=(y0 + side * rows, y0 - side),
    )  # fmt: skip
    for x, y in hall.centres.tolist():
        axes.add_patch(
            Rectangle((x - side / 2.0, y - side / 2.0), side, side, facecolor=FLOOR, edgecolor=GRID, linewidth=0.6)
        )


def _draw_robots(axes: "Axes", moment: Moment, side: float) -> None:
    from matplotlib.patches import Circle, Rectangle  # noqa: PLC0415

    for robot, colour in zip(moment.robots, COLOURS, strict=False):
        for x, y in robot.held:
            corner = x - side / 2.0, y - side / 2.0
            axes.add_patch(Rectangle(corner, side, side, color=colour, alpha=0.3, linewidth=0.0))
        if robot.goal is not None:
            axes.plot(*robot.goal, "x", color=colour, markersize=8, markeredgewidth=2.5)
    for robot, colour in zip(moment.robots, COLOURS, strict=False):
        axes.add_patch(Circle(robot.at, robot.radius, facecolor=colour, edgecolor=FLOOR, linewidth=0.8, zorder=3))
        axes.annotate(
            robot.name.removeprefix("tb"), robot.at, color=FLOOR, fontsize=8, fontweight="bold",
            ha="center", va="center", zorder=4,
        )  # fmt: skip
