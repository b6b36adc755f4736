"""Search for a person who vanished: where the person may be, and where to look next.

The person may be in any place that could have been reached on foot since and that the robot has not seen to be empty
(the contaminated area of pursuit and evasion: Guibas, Latombe, LaValle, Lin, Motwani, *Visibility-Based Pursuit-Evasion
in a Polygonal Environment*, 1997). The robot goes where that area begins, nearest to the place and direction in which
the person was last seen.
"""

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D, wrap_angle
from ppaas.maps.grid import GridInfo
from ppaas.messages.people_coordination import SensorView
from ppaas.people.following.places import Places

CELL = 0.25
"""Edge of a cell of the area [m]."""

REACH = 12.0
"""Half the edge of the square around the place where the person was last seen that is searched [m]."""

BEGIN = 0.5
"""Radius of the area at the beginning [m]."""

SLOWEST, FASTEST = 0.8, 1.5
"""Limits of the speed at which the area grows: the person may walk faster than when last seen [m/s]."""

RAY = math.radians(2.0)
"""Angle between two rays of a view [rad]."""

AROUND = 0.4
"""Distance from the robot within which nobody is, whatever its sensors see [m]."""

FROM_LAST, ASIDE, TURN, KEEP, AGAIN = 0.7, 6.0, 0.7, 1.5, 6.0
"""Costs of a place to look at, besides the distance to drive: of the distance from where the person was last seen
[1/m], of the direction opposite to the person's [m], of the angle to turn [m/rad], of another place than before
[m], and of a place that the robot has just looked at [m]."""

FORGOTTEN = 20.0
"""Time in which the last of these falls to zero [s]."""

KEPT = 1.0
"""Distance within which a place is the one of before [m]."""

NEAR = 0.75
"""Distance of a place for the robot from the one to look at [m]."""

FACED = 0.15
"""Angle to a place up to which the robot looks at it [rad]."""

LOOKS = 0.7
"""Part of the range of its sensors from which the robot looks at a place by turning."""

Cells = NDArray[np.bool_]


class SearchArea:
    """Area in which a person may be.

    Parameters
    ----------
    places : Places
        Places of the map.
    last : tuple of float
        Where the person was last believed to be, x, y [m].
    velocity : tuple of float
        Velocity then [m/s].
    now : float
        Time of that [s].
    """

    def __init__(self, places: Places, last: tuple[float, float], velocity: tuple[float, float], now: float) -> None:
        self._places, self._last, self._velocity = places, last, velocity
        self._updated, self._growth = now, 0.0
        self._rounds = 0
        self._target: tuple[float, float] | None = None
        self._looks_at = False
        self._speed = min(max(math.hypot(*velocity), SLOWEST), FASTEST)
        found = places.walkable(*last, REACH, CELL)
        self._free, self._info = found or (np.zeros((1, 1), np.bool_), GridInfo(CELL, 1, 1, Pose2D(*last)))
        self._centres = self._info.to_world(np.argwhere(np.ones(self._free.shape, np.bool_))).reshape(
            *self._free.shape, 2
        )
        self._looked = np.full(self._free.shape, -np.inf)
        self._area: Cells = self._free & (self._from(last) <= BEGIN)
        if not self._area.any() and self._free.any():
            self._area = self._free & (self._from(last) <= self._from(last)[self._free].min())

    @property
    def area(self) -> float:
        """Size of the area in which the person may be [m²]."""
        return float(self._area.sum()) * self._info.resolution**2

    def may_be_at(self, x: float, y: float, within: float = 0.0) -> bool:
        """Return whether the person may be at a point, or within a distance of it [m]."""
        cell = self._info.cell_of(x, y)
        if cell is None or not within:
            return cell is not None and bool(self._area[cell])
        return bool((self._area & (self._from((x, y)) <= within)).any())

    def update(self, now: float, robot: Pose2D, views: Iterable[SensorView]) -> None:
        """Grow the area for the time since the last update, and remove what the robot sees now.

        Parameters
        ----------
        now : float
            [s]
        robot : Pose2D
            Pose of the robot.
        views : iterable of SensorView
            Views of its detectors.
        """
        self._growth += self._speed * max(now - self._updated, 0.0)
        self._updated = now
        while self._growth >= self._info.resolution:
            self._growth -= self._info.resolution
            self._rounds += 1
            # Alternating neighbourhoods of four and eight grow octagons, close to circles.
            self._area = _grown(self._area, diagonal=self._rounds % 2 == 0) & self._free
        self._area &= self._from(robot[:2]) > AROUND
        for view in views:
            seen = self._seen(robot, view)
            self._looked[seen] = now
            self._area &= ~seen
        target = self._target
        if target is not None and self._looks_at and _off(robot, target) <= FACED:
            self.skip()  # it is in view, although no ray meets its cell

    def next_place(self, robot: Pose2D, views: Iterable[SensorView]) -> Pose2D | None:
        """Return the pose from which the robot looks next; None if the person is nowhere in the area.

        Parameters
        ----------
        robot : Pose2D
            Pose of the robot.
        views : iterable of SensorView
            Views of its detectors.
        """
        most = LOOKS * max((view.range_max for view in views), default=0.0)
        while (cell := self._best(robot)) is not None:
            x, y = self._centres[cell].tolist()
            self._target = x, y
            heading = math.atan2(y - robot.y, x - robot.x)
            near = robot.distance_to(Pose2D(x, y)) <= most
            self._looks_at = near and self._places.sees((robot.x, robot.y), (x, y))
            if self._looks_at:
                return Pose2D(robot.x, robot.y, heading)
            place = self._standable_near(cell)
            if place is not None:
                return Pose2D(*place, heading)
            self.skip()
        return None

    def skip(self) -> None:
        """Give up the place of `next_place`, which the robot does not get to."""
        if self._target is not None:
            self._area &= self._from(self._target) > NEAR

    # -- helpers -------------------------------------------------------------------------------------------------------

    def _from(self, point: tuple[float, float]) -> NDArray[np.float64]:
        """Return the distance of each cell from a point [m]."""
        offsets = self._centres - point
        distances: NDArray[np.float64] = np.hypot(offsets[..., 0], offsets[..., 1])
        return distances

    def _seen(self, robot: Pose2D, view: SensorView) -> Cells:
        """Return the cells that a sensor sees."""
        sensor = robot @ Pose2D(view.x, view.y, view.yaw)
        half = 0.5 * min(max(view.field_of_view, RAY), 2.0 * math.pi)
        angles = np.linspace(-half, half, max(math.ceil(2.0 * half / RAY), 2))
        sight = self._places.sight(sensor, angles, view.range_max)
        offsets = self._centres - (sensor.x, sensor.y)
        apart = np.hypot(offsets[..., 0], offsets[..., 1])
        bearing = (np.arctan2(offsets[..., 1], offsets[..., 0]) - sensor.theta + math.pi) % (2.0 * math.pi) - math.pi
        ray = np.rint((bearing + half) / (angles[1] - angles[0])).astype(np.int64)
        within = (ray >= 0) & (ray < len(angles)) & (apart >= view.range_min) & (apart <= view.range_max)
        seen: Cells = within & (apart <= 0.5 * self._info.resolution + sight[np.clip(ray, 0, len(angles) - 1)])
        return seen

    def _best(self, robot: Pose2D) -> tuple[int, int] | None:
        """Return the cell of the area that is the best to look at."""
        drive = self._driving_distances(robot)
        costs = drive + FROM_LAST * self._from(self._last)
        speed = math.hypot(*self._velocity)
        if speed > 0.0:
            offsets = self._centres - self._last
            along = offsets @ np.array(self._velocity) / speed
            costs += 0.5 * ASIDE * (1.0 - along / np.maximum(self._from(self._last), CELL))
        offsets = self._centres - robot[:2]
        bearing = np.arctan2(offsets[..., 1], offsets[..., 0]) - robot.theta
        costs += TURN * np.abs((bearing + math.pi) % (2.0 * math.pi) - math.pi)
        costs += AGAIN * np.maximum(1.0 - (self._updated - self._looked) / FORGOTTEN, 0.0)
        if self._target is not None:
            costs += KEEP * (self._from(self._target) > KEPT)
        costs = np.where(self._area, costs, np.inf)
        best = np.unravel_index(int(np.argmin(costs)), costs.shape)
        return (int(best[0]), int(best[1])) if np.isfinite(costs[best]) else None

    def _driving_distances(self, robot: Pose2D) -> NDArray[np.float64]:
        """Return the length of the robot's shortest path to each cell [m], in steps of a cell; infinite if none."""
        distances = np.full(self._free.shape, np.inf)
        reached: Cells = self._from(robot[:2]) <= max(float(self._from(robot[:2]).min()), self._info.resolution)
        front = reached
        left = self._area & ~reached
        distances[reached] = 0.0
        rounds = 0
        while front.any() and left.any():
            rounds += 1
            front = _grown(front, diagonal=rounds % 2 == 0) & self._free & ~reached
            reached = reached | front
            left = left & ~front
            distances[front] = rounds * self._info.resolution
        return distances

    def _standable_near(self, cell: tuple[int, int]) -> tuple[float, float] | None:
        """Return the nearest place for the robot to a cell."""
        margin = math.ceil(NEAR / self._info.resolution)
        rows, columns = (slice(max(edge - margin, 0), edge + margin + 1) for edge in cell)
        centres = self._centres[rows, columns].reshape(-1, 2)
        free = self._places.standable(centres)
        if not free.any():
            return None
        apart = np.hypot(*(centres - self._centres[cell]).T)
        x, y = centres[int(np.argmin(np.where(free, apart, np.inf)))].tolist()
        return x, y


def _off(robot: Pose2D, point: tuple[float, float]) -> float:
    """Return the angle between the heading of the robot and a point [rad]."""
    return abs(wrap_angle(math.atan2(point[1] - robot.y, point[0] - robot.x) - robot.theta))


def _grown(cells: Cells, *, diagonal: bool) -> Cells:
    """Return the cells with their neighbours, four or eight of each."""
    grown = cells.copy()
    grown[1:] |= cells[:-1]
    grown[:-1] |= cells[1:]
    beside = grown if diagonal else cells
    wider = grown.copy()
    wider[:, 1:] |= beside[:, :-1]
    wider[:, :-1] |= beside[:, 1:]
    return wider
