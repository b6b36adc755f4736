"""A picture of one drive: the map, the way of the robot, and what it knew when somebody was nearest to it."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from benchmarks.navigation.goals.run import Job, Trip, drive
from ppaas.costmap.costmap import FREE_SPACE, INSCRIBED_INFLATED_OBSTACLE, LETHAL_OBSTACLE, NO_INFORMATION, Costmap
from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.maps.grid import FREE, OCCUPIED, GridMap

WALL, FLOOR, UNKNOWN = (52, 60, 72), (255, 255, 255), (214, 219, 226)
WAY, PLAN, PARTICLE, PERSON, ROBOT = (20, 140, 85), (23, 95, 214), (150, 80, 200), (205, 38, 74), (20, 110, 70)
NEAR, SEEN = (255, 214, 150), (240, 140, 30)
EDGE = 1400
"""Least pixels of the longer edge."""


class _Moment:
    """What a drive looks like when somebody is nearest to the robot; and the way to there and on.

    Attributes
    ----------
    way : list of (x, y)
        Of the robot, truly [m].
    """

    def __init__(self) -> None:
        self.way: list[tuple[float, float]] = []
        self.nearest = np.inf
        self.costs: Costmap | None = None
        self.plan: NDArray[np.float64] = np.empty((0, 2))
        self.particles: NDArray[np.float64] = np.empty((0, 3))
        self.people: NDArray[np.float64] = np.empty((0, 2))
        self.robot = Pose2D(0.0, 0.0)

    def watch(self, trip: Trip) -> None:
        """Take note of a step."""
        pose, people = trip.robot.base.pose, trip.world.people()
        self.way.append((pose.x, pose.y))
        apart = float(np.hypot(*(people - np.array(pose[:2])).T).min(initial=np.inf))
        if apart < self.nearest and trip.clone.costs is not None and trip.clone.plan is not None:
            self.nearest, self.costs, self.plan = apart, trip.clone.costs, trip.clone.plan.poses[:, :2]
            self.particles, self.people, self.robot = trip.clone.particles, people, pose


def write_picture(path: Path, job: Job) -> None:
    """Drive, and draw it into a PNG file.

    Raises
    ------
    InvalidInput
        The file cannot be written.
    """
    moment = _Moment()
    drive(job, moment.watch)
    try:
        _draw(job.grid, moment).save(path)
    except OSError as error:
        raise InvalidInput(f"cannot write the picture: {error}") from error


def _draw(grid: GridMap, moment: _Moment) -> Image.Image:
    sheet = _Sheet(grid)
    if moment.costs is not None:
        sheet.costs(moment.costs)
    sheet.line(moment.way, WAY, 2)
    sheet.line(moment.plan.tolist(), PLAN, 2)
    for x, y in moment.particles[:, :2].tolist():
        sheet.disc(x, y, 0.03, PARTICLE)
    for x, y in moment.people.tolist():
        sheet.disc(x, y, 0.25, PERSON)
    sheet.disc(moment.robot.x, moment.robot.y, 0.18, ROBOT)
    return sheet.image


class _Sheet:
    """The map, on which things are drawn in metres."""

    def __init__(self, grid: GridMap) -> None:
        self._grid = grid
        self._scale = max(1, -(-EDGE // max(grid.data.shape)))
        colours = np.full((*grid.data.shape, 3), UNKNOWN, np.uint8)
        colours[grid.data == FREE] = FLOOR
        colours[grid.data >= OCCUPIED] = WALL
        size = grid.info.width * self._scale, grid.info.height * self._scale
        self.image = Image.fromarray(colours[::-1]).resize(size, Image.Resampling.NEAREST)
        self._pen = ImageDraw.Draw(self.image)

    def _pixel(self, x: float, y: float) -> tuple[float, float]:
        info = self._grid.info
        local = info.origin.inverse() @ Pose2D(x, y)
        return self._scale * local.x / info.resolution, self.image.height - self._scale * local.y / info.resolution

    def costs(self, costmap: Costmap) -> None:
        """Colour what is near to obstacles, and what the robot takes for one."""
        half = 0.5 * self._scale
        costly = (costmap.data != FREE_SPACE) & (costmap.data != NO_INFORMATION)
        for row, column in np.argwhere(costly & (costmap.data >= INSCRIBED_INFLATED_OBSTACLE // 4)).tolist():
            x, y = self._pixel(*costmap.info.to_world((row, column)).tolist())
            colour = SEEN if costmap.data[row, column] == LETHAL_OBSTACLE else NEAR
            self._pen.rectangle((x - half, y - half, x + half, y + half), colour)

    def line(self, points: list[tuple[float, float]], colour: tuple[int, int, int], width: int) -> None:
        """Draw a line along points."""
        self._pen.line([self._pixel(x, y) for x, y in points], colour, width)

    def disc(self, x: float, y: float, radius: float, colour: tuple[int, int, int]) -> None:
        """Draw something round."""
        right, down = self._pixel(x, y)
        size = max(radius / self._grid.info.resolution * self._scale, 1.0)
        self._pen.ellipse((right - size, down - size, right + size, down + size), colour)
