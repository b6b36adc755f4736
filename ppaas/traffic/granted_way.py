"""The way that a robot is granted, as cells in the order in which it drives through them, and as a path."""

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D, Poses, poses_along
from ppaas.messages.fleet.traffic import MapPoint, TrafficGrants
from ppaas.traffic.room_in_cells import Point, beside, nearest_in_cell

# -- the way that a robot is granted -----------------------------------------------------------------------------------

REACHED = 0.1
"""Distance from the centre of a cell at which it counts as reached, also from a spur [m]. Local planners of robots in
traffic drive nearer."""

STRAY = 0.4
"""Distance from the way beyond which a robot has left it, as a part of the distance between two cells."""

STRAIGHT_ON, SHARPEST_CURVE = 0.9, -0.2
"""Cosines of the change of direction at a point: the robot drives straight on through it, and in a curve down to the
second one. Beyond that it turns in place."""

BEHIND = 2
"""Number of points that are kept behind the robot, so that the curve that it drives on is known."""


@dataclass(slots=True)
class WayPoint:
    """Centre of a cell [m], and whether the robot drives around the corner there in a curve."""

    x: float
    y: float
    curved: bool = False

    @property
    def point(self) -> Point:
        """Its coordinates."""
        return self.x, self.y


class GrantedWay:
    """What a robot holds by the grants of the traffic node, and how far it has come.

    The robot alone decides what it gives back: the rest of its way, at a stop. That begins another *revision* of the
    way, for which grants of the one before are not valid. Points are numbered from 0 in each revision.

    Parameters
    ----------
    radius : float
        Radius of the robot [m].

    Attributes
    ----------
    grants : TrafficGrants or None
        The newest that are valid.
    epoch, number : int
        Epoch and number of them.
    revision : int
        Revision of the way.
    free : bool
        Whether the robot drives freely, because it is alone.
    reached : int
        Number of points that the robot has reached. On a spur it reaches no further ones.
    """

    def __init__(self, radius: float) -> None:
        self._radius = radius
        self.grants: TrafficGrants | None = None
        self.epoch = self.number = self.revision = 0
        self.free = False
        self.reached = 0
        self._anchor: Point = (math.nan, math.nan)
        self._first = 0
        self._points: list[WayPoint] = []
        self._spur: tuple[int, MapPoint] | None = None

    @property
    def end(self) -> int:
        """Number of points granted so far."""
        return self._first + len(self._points)

    @property
    def spacing(self) -> float:
        """Distance of neighbouring cells [m]; 0 before the first grants."""
        return 0.0 if self.grants is None else self.grants.spacing

    @property
    def first(self) -> int:
        """Number of the first point that the robot holds: the last one that it has reached, if any."""
        return max(self.reached - 1, 0)

    @property
    def held(self) -> list[MapPoint]:
        """Points that the robot holds, from the one that it has reached last."""
        return [MapPoint(each.x, each.y) for each in self._points[self.first - self._first :]]

    @property
    def ahead(self) -> int:
        """Number of points that the robot has not reached."""
        return self.end - self.reached

    @property
    def last(self) -> Point:
        """Centre of the last cell of the way [m]."""
        return self._points[-1].point

    def stop_near(self, goal: Pose2D) -> Pose2D:
        """Return the pose nearest to a goal at which the robot is wholly in the last cell of the way, with a margin."""
        return Pose2D(*nearest_in_cell((goal.x, goal.y), self.last, beside(self.spacing, self._radius)), goal.theta)

    def leads_to(self, goal_id: str) -> bool:
        """Return whether the way ends in the cell of a goal."""
        grants = self.grants
        if grants is None or not grants.at_goal or grants.revision != self.revision or not self._points:
            return False
        return grants.goal_id == goal_id

    def take(self, grants: TrafficGrants, pose: Pose2D) -> bool:
        """Take grants at the robot's pose; return False if they are older than others, or no way can be driven by them.

        There is no way through a cell that comes twice in a row.
        """
        if (grants.epoch, grants.number) <= (self.epoch, self.number):
            return False
        if any(one == other for one, other in itertools.pairwise(grants.way)):
            return False
        self.grants, self.epoch, self.number = grants, grants.epoch, grants.number
        if grants.revision != self.revision:
            return True
        if grants.free and not self.free:
            self.give_back(pose)
            self.free = True
        if not self._points:
            self._anchor = pose.x, pose.y
        skipped = max(self.end - grants.first, 0)
        if grants.first <= self.end and not self.free:
            for each in grants.way[skipped:]:
                self._append(each, pose)
        return True

    def give_back(self, pose: Pose2D) -> None:
        """Begin another revision, in which the robot holds the cells that it touches, where it stands."""
        self.revision += 1
        self.free = False
        self.reached = self._first = 0
        self._points = []
        self._spur = None
        self._anchor = pose.x, pose.y

    def advance(self, pose: Pose2D) -> bool:
        """Take the pose of the robot; return whether it has reached another point, or come back from a spur."""
        before, spur = self.reached, self._spur
        if spur is not None and self.is_recalled and (self.reached < spur[0] or self._is_back(spur, pose)):
            self._spur = None
        end = self.end if self._spur is None else self._spur[0]
        while self.reached < end and self._has_reached(self.reached, pose):
            self.reached += 1
        behind = max(self.reached - BEHIND, self._first) - self._first
        del self._points[:behind]
        self._first += behind
        return self.reached > before or self._spur is not spur

    # -- the spur ------------------------------------------------------------------------------------------------------

    @property
    def spur_to(self) -> MapPoint | None:
        """Goal to which the robot may drive from the centre of the last cell; None if it is granted no spur."""
        grants = self.grants
        if grants is None or grants.revision != self.revision or not self._points or not grants.spur:
            return None
        return grants.spur[0]

    @property
    def spur(self) -> list[MapPoint]:
        """End of the spur that the robot has taken and not come back from, or nothing."""
        return [] if self._spur is None else [self._spur[1]]

    @property
    def is_recalled(self) -> bool:
        """True if the robot has to drive back to the centre of the cell in which its spur begins."""
        if self._spur is None:
            return False
        number, place = self._spur
        return self.spur_to != place or self.end > number

    def take_spur(self, place: MapPoint) -> None:
        """Take the spur to a place that was granted: the robot may be anywhere on it from now on."""
        self._spur = self.end, place

    def stop_at(self, goal: Pose2D, is_free: Callable[[Point, Point], bool]) -> Pose2D:
        """Return the pose at which the robot stops at its goal: on the spur that it is granted, or else in its cell.

        Parameters
        ----------
        goal : Pose2D
            Goal to which the way leads.
        is_free : callable
            Takes both ends of a spur; returns whether the robot sees nothing on it. Then the robot takes the spur.
        """
        place = self.spur_to
        if place is None or not is_free(self.last, (place.x, place.y)):
            return self.stop_near(goal)
        self.take_spur(place)
        return Pose2D(place.x, place.y, goal.theta)

    def _spur_line(self, number: int, place: MapPoint) -> tuple[Point, Point]:
        """Return both ends of a spur that begins at the point before a number."""
        return self._points[self._index(number - 1)].point, (place.x, place.y)

    def _is_back(self, spur: tuple[int, MapPoint], pose: Pose2D) -> bool:
        (x, y), _ = self._spur_line(*spur)
        return math.hypot(pose.x - x, pose.y - y) <= REACHED

    def off(self, pose: Pose2D) -> float:
        """Return the distance of the robot from its way [m]; a robot that drives freely is never off it."""
        if self.free or not self.spacing:
            return 0.0
        ends = [self._start, *(each.point for each in self._points[self._index(self.reached) :])]
        parts = list(itertools.pairwise(ends)) if len(ends) > 1 else [(ends[0], ends[0])]
        if self._spur is not None:
            parts.append(self._spur_line(*self._spur))
        return min(_distance_to(pose, *part) for part in parts)

    def is_stray(self, pose: Pose2D) -> bool:
        """Return whether the robot has left its way."""
        return self.off(pose) > max(STRAY * self.spacing, REACHED)

    def leg(self) -> tuple[list[WayPoint], bool]:
        """Return the points from behind the robot to where it next has to stop, and whether the way ends there.

        It stops at the end, and turns in place where it drives back, or learnt too late of a corner for a curve. From a
        spur it drives back first.
        """
        points = self._points
        if self.is_recalled and self._spur is not None:
            centre, place = self._spur_line(*self._spur)
            return [WayPoint(*place), WayPoint(*centre)], False
        begin = max(self._index(self.reached) - 1, 0)
        if begin > 0 and points[begin].curved:
            begin -= 1
        start = [] if self.reached else [WayPoint(*self._anchor)]
        leg = start + points[begin : self._index(self.reached)]
        for index in range(self._index(self.reached), len(points)):
            leg.append(points[index])
            if index + 1 < len(points) and not points[index].curved and self._turns_at(index):
                return leg, False
        return leg, True

    @property
    def _start(self) -> Point:
        return self._points[self._index(self.reached) - 1].point if self.reached else self._anchor

    def _index(self, number: int) -> int:
        return number - self._first

    def _append(self, point: MapPoint, pose: Pose2D) -> None:
        """Append a point; the robot turns in a curve in the cell before it, unless it is in that already."""
        points = self._points
        points.append(WayPoint(point.x, point.y))
        corner = len(points) - 2
        if corner >= 1 and SHARPEST_CURVE <= self._onward(corner) < STRAIGHT_ON:
            ahead = self._first + corner - self.reached
            near = math.hypot(pose.x - points[corner].x, pose.y - points[corner].y) < self.spacing / 2.0
            points[corner].curved = ahead > 0 or (ahead == 0 and not near)

    def _turns_at(self, index: int) -> bool:
        return index == 0 or self._onward(index) < STRAIGHT_ON

    def _onward(self, index: int) -> float:
        """Return the cosine of the change of direction at a point."""
        (ax, ay), (bx, by), (cx, cy) = (each.point for each in self._points[index - 1 : index + 2])
        return ((bx - ax) * (cx - bx) + (by - ay) * (cy - by)) / (
            math.hypot(bx - ax, by - ay) * math.hypot(cx - bx, cy - by)
        )

    def _has_reached(self, number: int, pose: Pose2D) -> bool:
        here = self._points[self._index(number)]
        if number == 0:
            return math.hypot(pose.x - here.x, pose.y - here.y) <= REACHED
        before = self._points[self._index(number) - 1]
        dx, dy = here.x - before.x, here.y - before.y
        length = math.hypot(dx, dy)
        return ((pose.x - before.x) * dx + (pose.y - before.y) * dy) / length >= length - REACHED


def _distance_to(pose: Pose2D, begin: Point, end: Point) -> float:
    """Return the distance of a pose from a line between two points [m]."""
    dx, dy = end[0] - begin[0], end[1] - begin[1]
    squared = dx * dx + dy * dy
    along = 0.0 if squared == 0.0 else ((pose.x - begin[0]) * dx + (pose.y - begin[1]) * dy) / squared
    along = min(max(along, 0.0), 1.0)
    return math.hypot(pose.x - begin[0] - along * dx, pose.y - begin[1] - along * dy)


# -- paths along a granted way -----------------------------------------------------------------------------------------

STEP = 0.05
"""Distance of the poses of a path [m]."""


def path_along(leg: Sequence[WayPoint], spacing: float, pose: Pose2D, goal: Pose2D | None = None) -> Poses:
    """Return the path of a robot along a leg of its way, from the nearest point of the leg on, (n, 7).

    Parameters
    ----------
    leg : sequence of WayPoint
        From behind the robot to where it stops; at least one. Its curved points have neighbours on both sides.
    spacing : float
        Distance of neighbouring cells [m]; curves begin and end at half of it.
    pose : Pose2D
        Pose of the robot.
    goal : Pose2D, optional
        Pose in which it is to stop, in the last cell of the leg.
    """
    points = np.array([*_points(leg, spacing), *([] if goal is None else [(goal.x, goal.y)])])
    dense = _with_steps(points)
    nearest = int(np.argmin(np.hypot(dense[:, 0] - pose.x, dense[:, 1] - pose.y)))
    rest = dense[nearest:]
    if len(rest) == 1:
        rest = np.concatenate([[[pose.x, pose.y]], rest])
    return poses_along(rest, None if goal is None else goal.theta)


def _points(leg: Sequence[WayPoint], spacing: float) -> Iterator[Point]:
    for index, here in enumerate(leg):
        if here.curved and 0 < index < len(leg) - 1:
            yield from _curve(leg[index - 1], here, leg[index + 1], spacing)
        else:
            yield here.point


def _curve(before: WayPoint, here: WayPoint, after: WayPoint, spacing: float) -> Iterator[Point]:
    """Yield points of the arc that touches both lines of a corner, at most half a spacing from it.

    Its radius is at most a spacing: then robots that keep that distance from both lines keep it from the arc too.
    """
    come, go = _unit(before, here), _unit(here, after)
    turn = math.atan2(come[0] * go[1] - come[1] * go[0], come[0] * go[0] + come[1] * go[1])
    half = math.tan(abs(turn) / 2.0)
    radius = min(spacing / 2.0 / half, spacing)
    begin = here.x - radius * half * come[0], here.y - radius * half * come[1]
    side = math.copysign(1.0, turn)
    for angle in np.linspace(0.0, abs(turn), max(math.ceil(radius * abs(turn) / STEP), 2)).tolist():
        along, across = radius * math.sin(angle), side * radius * (1.0 - math.cos(angle))
        yield begin[0] + along * come[0] - across * come[1], begin[1] + along * come[1] + across * come[0]


def _unit(one: WayPoint, other: WayPoint) -> Point:
    dx, dy = other.x - one.x, other.y - one.y
    length = math.hypot(dx, dy)
    return dx / length, dy / length


def _with_steps(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return points no farther than `STEP` from each other along the lines between points, each once."""
    lengths = np.hypot(*np.diff(points, axis=0).T)
    far = np.append(True, lengths > 1e-6)
    points, lengths = points[far], lengths[far[1:]]
    along = np.append(0.0, np.cumsum(lengths))
    places = np.unique(np.append(np.arange(0.0, along[-1], STEP), along))
    return np.stack([np.interp(places, along, points[:, k]) for k in (0, 1)], axis=1)
