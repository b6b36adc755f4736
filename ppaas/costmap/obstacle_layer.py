"""The obstacle layer of costmap_2d: what the laser saw in a window that moves with the robot."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.cost_values import FREE_SPACE, LETHAL_OBSTACLE, NO_INFORMATION
from ppaas.costmap.kernels.obstacle import mark_and_clear
from ppaas.errors import InvalidInput, InvalidParameter
from ppaas.geometry import Pose2D
from ppaas.maps.discs import stamp_disc
from ppaas.messages.sensor_msgs import LaserScan

OBSTACLE_RANGE = 2.5
RAYTRACE_RANGE = 3.0


@dataclass(frozen=True, slots=True)
class LaserReading:
    """One scan, and where it was taken.

    Parameters
    ----------
    origin : Pose2D
        Of the laser, in the frame of the map.
    angles : (n,) float64 array
        Of the beams, from its heading [rad].
    ranges : (n,) float64 array
        [m]. Infinite: nothing was hit. Not a number, or not positive: no reading.

    Raises
    ------
    InvalidInput
        A pose or angle that is not finite, or not as many ranges as angles.
    """

    origin: Pose2D
    angles: NDArray[np.float64]
    ranges: NDArray[np.float64]

    def __post_init__(self) -> None:
        if self.angles.ndim != 1 or self.angles.shape != self.ranges.shape:
            raise InvalidInput(f"a scan has a range for each angle, not {self.ranges.shape} for {self.angles.shape}")
        if not (self.origin.is_finite() and np.isfinite(self.angles).all()):
            raise InvalidInput("the pose of the laser and the angles of its beams must be finite")

    @classmethod
    def of(cls, scan: LaserScan, origin: Pose2D) -> "LaserReading":
        """Read a message: null and what is below ``range_min`` is no reading, ``range_max`` or more hit nothing."""
        ranges: NDArray[np.float64] = np.array(scan.ranges, dtype=np.float64)
        ranges[ranges < scan.range_min] = np.nan
        ranges[ranges >= scan.range_max] = np.inf
        angles = scan.angle_min + scan.angle_increment * np.arange(ranges.size, dtype=np.float64)
        return cls(origin, angles, ranges)


class ObstacleLayer:
    """What was seen in each cell of a rolling window.

    Cells are counted in the grid of the map, beyond whose edge the window may hang. What leaves the window is
    forgotten.

    Parameters
    ----------
    height, width : int
        Of the window [cells].
    resolution : float
        Edge of a cell [m].
    obstacle_range : float
        Longest range that marks [m].
    raytrace_range : float
        Up to which a beam clears [m].
    inf_is_valid : bool
        Whether a beam that hit nothing clears.

    Attributes
    ----------
    cells : (height, width) uint8 array
        ``LETHAL_OBSTACLE`` where something was hit, ``FREE_SPACE`` where a beam went through, else ``NO_INFORMATION``.
    row, column : int
        Cell of the map that is cell (0, 0) of the window.

    Raises
    ------
    InvalidParameter
        A range that is negative or not finite.
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
        """Lay cell (0, 0) of the window on a cell of the map, keeping what both windows have."""
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
        """Clear and mark by one scan, with the laser at ``origin`` in the frame of the grid [m, rad]."""
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
        """Free the cells the robot stands on, in the frame of the grid [m]: nothing else can be there."""
        stamp_disc(
            self.cells,
            robot.x / self._resolution - self.column,
            robot.y / self._resolution - self.row,
            radius / self._resolution,
            FREE_SPACE,
        )

    def clear(self) -> None:
        """Forget everything seen."""
        self.cells.fill(NO_INFORMATION)

    def clear_beyond(self, centre: Pose2D, distance: float) -> None:
        """Forget what was seen farther than ``distance`` [m] from a place, in the frame of the grid."""
        rows, columns = np.indices(self.cells.shape, sparse=True)
        across = (columns + self.column + 0.5) * self._resolution - centre.x
        up = (rows + self.row + 0.5) * self._resolution - centre.y
        self.cells[np.hypot(across, up) > distance] = NO_INFORMATION

    @property
    def marked(self) -> NDArray[np.bool_]:
        """(height, width) bool: where something was hit."""
        return np.equal(self.cells, LETHAL_OBSTACLE)

    @property
    def seen(self) -> NDArray[np.bool_]:
        """(height, width) bool: where anything is known, free or not."""
        return np.not_equal(self.cells, NO_INFORMATION)
