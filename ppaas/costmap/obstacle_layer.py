"""Obstacle layer of costmap_2d: obstacles that the laser saw in a window that moves with the robot."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.cost_values import FREE_SPACE, LETHAL_OBSTACLE, NO_INFORMATION
from ppaas.costmap.kernels.obstacle import mark_and_clear
from ppaas.errors import InvalidInput, InvalidParameter
from ppaas.geometry import Pose2D, reach_of, within_hull
from ppaas.maps.discs import stamp_disc
from ppaas.messages.sensor_msgs import LaserScan

OBSTACLE_RANGE = 2.5
"""Default longest range that marks an obstacle [m]."""

RAYTRACE_RANGE = 3.0
"""Default range up to which beams clear cells [m]."""


@dataclass(frozen=True, slots=True)
class LaserReading:
    """Laser scan, and the pose at which it was taken.

    Parameters
    ----------
    origin : Pose2D
        Pose of the laser, in the frame of the map.
    angles : (n,) float64 array
        Angles of the beams, relative to the heading of the laser [rad].
    ranges : (n,) float64 array
        Ranges [m]; infinite if nothing was hit. NaN, 0 and negative numbers are not readings.

    Raises
    ------
    InvalidInput
        The pose or an angle is not finite, or the numbers of ranges and angles differ.
    """

    origin: Pose2D
    angles: NDArray[np.float64]
    ranges: NDArray[np.float64]

    def __post_init__(self) -> None:
        if self.angles.ndim != 1 or self.angles.shape != self.ranges.shape:
            raise InvalidInput(
                f"a scan must have one range per angle, not ranges of shape {self.ranges.shape} for angles of shape "
                f"{self.angles.shape}"
            )
        if not (self.origin.is_finite() and np.isfinite(self.angles).all()):
            raise InvalidInput("the laser's pose and the angles of its beams must be finite")

    @classmethod
    def of(cls, scan: LaserScan, origin: Pose2D) -> "LaserReading":
        """Return the reading of a message.

        Ranges that are null, 0 or at most ``range_min`` are not readings, as in amcl; ranges from ``range_max`` up hit
        nothing.
        """
        ranges: NDArray[np.float64] = np.array(scan.ranges, dtype=np.float64)
        ranges[ranges <= max(scan.range_min, 0.0)] = np.nan
        ranges[ranges >= scan.range_max] = np.inf
        angles = scan.angle_min + scan.angle_increment * np.arange(ranges.size, dtype=np.float64)
        return cls(origin, angles, ranges)


class ObstacleLayer:
    """State of each cell of a rolling window.

    The window is aligned with the cells of the map, and may extend beyond the map. Cells that leave it are forgotten.

    Parameters
    ----------
    height, width : int
        Size of the window [cells].
    resolution : float
        Edge of a cell [m].
    obstacle_range : float
        Longest range that marks an obstacle [m].
    raytrace_range : float
        Range up to which beams clear cells [m].
    inf_is_valid : bool
        Whether a beam that hit nothing clears cells.

    Attributes
    ----------
    cells : (height, width) uint8 array
        ``LETHAL_OBSTACLE`` if a beam ended there, ``FREE_SPACE`` if one passed through, else ``NO_INFORMATION``.
    row, column : int
        Cell of the map that is cell (0, 0) of the window.

    Raises
    ------
    InvalidParameter
        A range is negative or not finite.
    """

    def __init__(
        self,
        height: int,
        width: int,
        resolution: float,
        *,
        obstacle_range: float = OBSTACLE_RANGE,
        raytrace_range: float = RAYTRACE_RANGE,
        inf_is_valid: bool = True,
    ) -> None:
        for name, value in (("obstacle_range", obstacle_range), ("raytrace_range", raytrace_range)):
            if not (math.isfinite(value) and value >= 0.0):
                raise InvalidParameter(f"{name} must be finite and not negative, not {value}")
        self.cells = np.full((height, width), NO_INFORMATION, np.uint8)
        self.row = self.column = 0
        self._resolution = resolution
        self._obstacle_range = obstacle_range
        self._raytrace_range = raytrace_range
        self._inf_is_valid = inf_is_valid

    def move_to(self, row: int, column: int) -> None:
        """Move cell (0, 0) of the window to a cell of the map, keeping the cells in both the old and the new window."""
        down, left = row - self.row, column - self.column
        if (down, left) == (0, 0):
            return
        height, width = self.cells.shape
        moved = np.full_like(self.cells, NO_INFORMATION)
        if abs(down) < height and abs(left) < width:
            kept = self.cells[max(down, 0) : height + min(down, 0), max(left, 0) : width + min(left, 0)]
            top, start = max(-down, 0), max(-left, 0)
            moved[top : top + kept.shape[0], start : start + kept.shape[1]] = kept
        self.cells, self.row, self.column = moved, row, column

    def see(self, origin: Pose2D, reading: LaserReading) -> None:
        """Clear and mark cells by a scan, with the laser at ``origin`` in the frame of the grid [m, rad]."""
        ranges = np.ascontiguousarray(reading.ranges / self._resolution, dtype=np.float64)
        if not self._inf_is_valid:
            ranges[np.isposinf(ranges)] = np.nan
        mark_and_clear(
            self.cells,
            origin.x / self._resolution - self.column,
            origin.y / self._resolution - self.row,
            np.ascontiguousarray(reading.angles + origin.theta, dtype=np.float64),
            ranges,
            self._obstacle_range / self._resolution,
            self._raytrace_range / self._resolution,
        )

    def clear_footprint(self, robot: Pose2D, radius: float) -> None:
        """Free the cells under the robot, whose pose is in the frame of the grid [m]; no obstacle can be there."""
        stamp_disc(
            self.cells,
            robot.x / self._resolution - self.column,
            robot.y / self._resolution - self.row,
            radius / self._resolution,
            FREE_SPACE,
        )

    def clear_outline(self, robot: Pose2D, hull: NDArray[np.float64]) -> None:
        """Free the cells under a robot with an outline, whose pose is in the frame of the grid.

        Parameters
        ----------
        robot : Pose2D
        hull : (n, 2) array
            Corners of its convex outline, counter-clockwise [m].
        """
        reach = math.ceil(reach_of(hull) / self._resolution) + 1
        row, column = math.floor(robot.y / self._resolution), math.floor(robot.x / self._resolution)
        top, left = max(row - reach - self.row, 0), max(column - reach - self.column, 0)
        part = self.cells[top : max(row + reach + 1 - self.row, 0), left : max(column + reach + 1 - self.column, 0)]
        x = (np.arange(part.shape[1]) + left + self.column + 0.5) * self._resolution - robot.x
        y = (np.arange(part.shape[0])[:, None] + top + self.row + 0.5) * self._resolution - robot.y
        c, s = math.cos(robot.theta), math.sin(robot.theta)
        part[within_hull(hull, c * x + s * y, c * y - s * x, 0.5 * self._resolution)] = FREE_SPACE

    def clear(self) -> None:
        """Forget all cells."""
        self.cells.fill(NO_INFORMATION)

    def clear_beyond(self, centre: Pose2D, distance: float) -> None:
        """Forget the cells farther than ``distance`` [m] from a point in the frame of the grid."""
        rows, columns = np.indices(self.cells.shape, sparse=True)
        across = (columns + self.column + 0.5) * self._resolution - centre.x
        up = (rows + self.row + 0.5) * self._resolution - centre.y
        self.cells[np.hypot(across, up) > distance] = NO_INFORMATION

    @property
    def marked(self) -> NDArray[np.bool_]:
        """(height, width) bool array: cells with an obstacle."""
        return np.equal(self.cells, LETHAL_OBSTACLE)

    @property
    def seen(self) -> NDArray[np.bool_]:
        """(height, width) bool array: cells that were seen, free or not."""
        return np.not_equal(self.cells, NO_INFORMATION)
