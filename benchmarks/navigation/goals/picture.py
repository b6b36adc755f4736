"""Picture of one drive: the map, the robot's path, and its state when a person was closest to it."""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from benchmarks.harness.map_figure import map_figure, show_cells
from benchmarks.navigation.goals.run import GoalsJob, Trip, drive
from ppaas.costmap.costmap import FREE_SPACE, INSCRIBED_INFLATED_OBSTACLE, LETHAL_OBSTACLE, NO_INFORMATION, Costmap
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridMap
from robots.pictures.figure_file import write_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PATH, PLAN, PARTICLE, PERSON, ROBOT = "#148c55", "#175fd6", "#9650c8", "#cd264a", "#146e46"

NEAR, LETHAL = (255, 214, 150, 255), (240, 140, 30, 255)
"""RGBA colours of cells near obstacles, and of obstacles, in the local costmap."""

PERSON_RADIUS, ROBOT_RADIUS = 0.25, 0.18
"""Radii of the discs that are drawn [m]."""


class ClosestEncounter:
    """State of a drive when a person was closest to the robot, and the robot's whole path.

    Attributes
    ----------
    path : list of (x, y)
        True positions of the robot [m].
    distance : float
        From the robot to the closest person [m]; infinite if there was none.
    costs : Costmap or None
        Local costmap of the robot.
    plan : (n, 2) array
        Points of its plan [m].
    particles : (n, 3) array
        Of localization: x, y [m] and heading [rad].
    people : (n, 2) array
        Positions of all people [m].
    robot : Pose2D
        True pose of the robot.
    """

    def __init__(self) -> None:
        self.path: list[tuple[float, float]] = []
        self.distance = np.inf
        self.costs: Costmap | None = None
        self.plan: NDArray[np.float64] = np.empty((0, 2))
        self.particles: NDArray[np.float64] = np.empty((0, 3))
        self.people: NDArray[np.float64] = np.empty((0, 2))
        self.robot = Pose2D(0.0, 0.0)

    def watch(self, trip: Trip) -> None:
        """Record a step of the drive."""
        pose, people = trip.robot.base.pose, trip.world.people()
        self.path.append((pose.x, pose.y))
        distance = float(np.hypot(*(people - np.array(pose[:2])).T).min(initial=np.inf))
        if distance < self.distance and trip.clone.costs is not None and trip.clone.plan is not None:
            self.distance, self.costs, self.plan = distance, trip.clone.costs, trip.clone.plan.poses[:, :2]
            self.particles, self.people, self.robot = trip.clone.particles, people, pose


def write_picture(path: Path, job: GoalsJob) -> None:
    """Drive, and draw the drive into a PNG file.

    Raises
    ------
    InvalidInput
        The file cannot be written.
    """
    encounter = ClosestEncounter()
    drive(job, encounter.watch)
    write_figure(path, draw(job.grid, encounter))


def draw(grid: GridMap, encounter: ClosestEncounter) -> "Figure":
    """Return the picture of a drive."""
    from matplotlib.patches import Circle  # noqa: PLC0415 - heavy, and of the extra plot

    figure, axes = map_figure(grid)
    if encounter.costs is not None:
        show_cells(axes, _colours(encounter.costs), encounter.costs.info)
    axes.plot(*np.array(encounter.path).reshape(-1, 2).T, color=PATH, label="path")
    axes.plot(*encounter.plan.T, color=PLAN, label="plan")
    axes.plot(*encounter.particles[:, :2].T, ".", color=PARTICLE, markersize=2.0, label="particles")
    for x, y in encounter.people.tolist():
        axes.add_patch(Circle((x, y), PERSON_RADIUS, color=PERSON, zorder=3))
    axes.add_patch(Circle((encounter.robot.x, encounter.robot.y), ROBOT_RADIUS, color=ROBOT, zorder=3))
    figure.legend(loc="outside upper left", ncols=3, frameon=False)
    return figure


def _colours(costs: Costmap) -> NDArray[np.uint8]:
    """Return (height, width, 4) RGBA colours of the cells; cheap and unknown cells are transparent."""
    known = (costs.data != FREE_SPACE) & (costs.data != NO_INFORMATION)
    colours = np.zeros((*costs.data.shape, 4), np.uint8)
    colours[known & (costs.data >= INSCRIBED_INFLATED_OBSTACLE // 4)] = NEAR
    colours[costs.data == LETHAL_OBSTACLE] = LETHAL
    return colours
