"""A picture of one run: the cylinders, the way the robot truly took, and what it saw and thought of the costs."""

from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from benchmarks.navigation.barn.environment import Course
from benchmarks.navigation.barn.jackal import FOOTPRINT
from benchmarks.navigation.barn.navigator import PERIOD, Pilot
from benchmarks.navigation.barn.run import Job, Result, drive
from benchmarks.navigation.barn.worlds import GOAL, GOAL_TOLERANCE, START, World
from ppaas.costmap.costmap import INSCRIBED_INFLATED_OBSTACLE, LETHAL_OBSTACLE, Costmap
from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D

SCALE = 80
"""Pixels of a metre."""
MARGIN = 0.5
HEAD = 76
OUTLINE_EVERY = 0.5
"""Seconds between two outlines of the robot."""

INK, FAINT, PAPER = (28, 33, 41), (105, 113, 125), (255, 255, 255)
CYLINDER, SEEN, WAY, THERE = (84, 92, 106), (214, 72, 23), (23, 95, 214), (20, 140, 85)

Point = tuple[float, float]


def write_picture(path: Path, job: Job) -> None:
    """Drive one run and draw it into a PNG file.

    Raises
    ------
    InvalidInput
        The file cannot be written.
    """
    poses, costs = [START], []

    def watch(course: Course, pilot: Pilot) -> None:
        poses.append(course.pose)
        costs.append(pilot.costs)

    result = drive(job, watch)
    picture = draw(job.world, poses, costs[len(costs) // 2] if costs else None, result)
    try:
        picture.save(path)
    except OSError as error:
        raise InvalidInput(f"cannot write the picture: {error}") from error


def draw(world: World, poses: list[Pose2D], costs: Costmap | None, result: Result) -> Image.Image:
    """Return the picture of a run.

    Parameters
    ----------
    world : World
    poses : list of Pose2D
        True ones, one each cycle, in the frame of the world.
    costs : Costmap, optional
        Local one of half-way, in the frame of the odometry.
    result : Result
    """
    sheet = _Sheet(world, poses)
    if costs is not None:
        sheet.costs(costs)
    for x, y in world.cylinders:
        sheet.disc(x, y, world.radius, CYLINDER)
    sheet.ring(GOAL.x, GOAL.y, GOAL_TOLERANCE, THERE)
    for pose in poses[:: round(OUTLINE_EVERY / PERIOD)]:
        sheet.outline(pose)
    sheet.line(poses)
    sheet.title(
        f"BARN world {world.world}: {result.outcome} after {result.seconds:.2f} s",
        f"least clearance {result.clearance:.3f} m",
        "grey: cylinders, orange: cells marked half-way, shade: costs",
    )
    return sheet.image


class _Sheet:
    """Paper on which metres of the world are pixels."""

    def __init__(self, world: World, poses: list[Pose2D]) -> None:
        points = np.vstack((world.centres, [(pose.x, pose.y) for pose in poses], [(GOAL.x, GOAL.y + GOAL_TOLERANCE)]))
        self._low = points.min(axis=0) - MARGIN
        width, height = ((points.max(axis=0) + MARGIN - self._low) * SCALE).astype(int).tolist()
        self.image = Image.new("RGB", (width, height + HEAD), PAPER)
        self._pen = ImageDraw.Draw(self.image)

    def _pixel(self, x: float, y: float) -> Point:
        return (x - self._low[0]) * SCALE, self.image.height - (y - self._low[1]) * SCALE

    def costs(self, costmap: Costmap) -> None:
        """Shade what costs, and colour what was seen; the start of the run is where the odometry begins."""
        half = 0.5 * costmap.info.resolution * SCALE
        for row, column in np.argwhere(costmap.data > 0).tolist():
            cost = int(costmap.data[row, column])
            pose = START @ Pose2D(*costmap.info.to_world((row, column)).tolist())
            x, y = self._pixel(pose.x, pose.y)
            shade = 255 - 45 * min(cost, INSCRIBED_INFLATED_OBSTACLE) // INSCRIBED_INFLATED_OBSTACLE
            colour = SEEN if cost == LETHAL_OBSTACLE else (255, shade, shade)
            self._pen.rectangle((x - half, y - half, x + half, y + half), colour)

    def disc(self, x: float, y: float, radius: float, colour: tuple[int, int, int]) -> None:
        """Draw a cylinder."""
        (left, low), (right, high) = self._pixel(x - radius, y - radius), self._pixel(x + radius, y + radius)
        self._pen.ellipse((left, high, right, low), colour)

    def ring(self, x: float, y: float, radius: float, colour: tuple[int, int, int]) -> None:
        """Draw a circle."""
        (left, low), (right, high) = self._pixel(x - radius, y - radius), self._pixel(x + radius, y + radius)
        self._pen.ellipse((left, high, right, low), outline=colour, width=3)

    def outline(self, pose: Pose2D) -> None:
        """Draw the robot at a pose."""
        corners = [pose @ Pose2D(x, y) for x, y in FOOTPRINT]
        self._pen.polygon([self._pixel(corner.x, corner.y) for corner in corners], outline=WAY)

    def line(self, poses: list[Pose2D]) -> None:
        """Draw the way along poses."""
        self._pen.line([self._pixel(pose.x, pose.y) for pose in poses], WAY, 3, joint="curve")

    def title(self, title: str, *lines: str) -> None:
        """Write the headline and lines below."""
        self._pen.rectangle((0, 0, self.image.width, HEAD), PAPER)
        self._pen.text((12, 8), title, INK, ImageFont.load_default(20))
        self._pen.text((12, 36), "\n".join(lines), FAINT, ImageFont.load_default(12))
