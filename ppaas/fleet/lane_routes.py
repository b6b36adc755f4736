"""Lane routes: shortest ways from place to place along the lanes of a map."""

import heapq
import math
from collections.abc import Iterable
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ppaas.errors import InvalidInput, NotFound, NoValidPath
from ppaas.fleet.lane_drawing import lines_in, network_of
from ppaas.geometry import Pose2D, Poses, poses_along
from ppaas.polygons import Points
from ppaas.zones.zone import Zone

MOST = 65_535
"""Largest number of places, and of parts of lanes: ``nav2_msgs`` has 16 bits for each."""

SPACING = 0.1
"""Distance between two poses of a path [m]."""


class LanePlace(NamedTuple):
    """Place on lanes: its number, from 1, and x, y [m]."""

    number: int
    x: float
    y: float


class LaneRoute(NamedTuple):
    """Way along lanes.

    Parameters
    ----------
    places : tuple of LanePlace
        Places in the order of driving, at least one.
    parts : tuple of int
        Numbers of the straight parts of lanes between them.
    """

    places: tuple[LanePlace, ...]
    parts: tuple[int, ...]

    @property
    def points(self) -> Points:
        """Positions of the places, (n, 2) [m]."""
        return np.array([place[1:] for place in self.places])

    @property
    def length(self) -> float:
        """Length [m]."""
        return float(np.hypot(*np.diff(self.points, axis=0).T).sum())

    def poses(self, start: Pose2D | None = None, goal: Pose2D | None = None) -> Poses:
        """Return the path along the route, (n, 7): from a pose to it, and from it to another."""
        points = [start[:2]] if start is not None else []
        points += [(place.x, place.y) for place in self.places]
        points += [goal[:2]] if goal is not None else []
        along = [np.array(points[:1])]
        for one, other in pairwise(points):
            steps = math.ceil(math.dist(one, other) / SPACING)
            along.append(np.linspace(one, other, steps + 1)[1:])
        return poses_along(np.concatenate(along), None if goal is None else goal.theta)


class LaneGraph:
    """Places of a map where lanes begin, bend, meet or end, numbered from 1, and the straight parts between them.

    Parameters
    ----------
    zones : iterable of Zone
        Zones of the map; those that are no lanes are ignored.

    Raises
    ------
    InvalidInput
        The map has no lanes, or too many.
    """

    def __init__(self, zones: Iterable[Zone]) -> None:
        lines = lines_in(zones)
        if not lines:
            raise InvalidInput("the map has no lanes: draw zones of the kind 'lane'")
        network = network_of(lines)
        if max(len(network.places), len(network.names)) > MOST:
            raise InvalidInput(f"the lanes of the map have more than {MOST} places or parts")
        self._places = network.places
        self._next: dict[int, list[tuple[int, int, float]]] = {}
        for number, (one, other) in enumerate(network.names, 1):
            length = math.dist(network.places[one], network.places[other])
            self._next.setdefault(one, []).append((other, number, length))

    def check(self, number: int) -> int:
        """Return the number of a place; raises ``NotFound`` if there is none."""
        if not 1 <= number <= len(self._places):
            raise NotFound("node", str(number), advice=f"nodes are numbered from 1 to {len(self._places)}")
        return number

    def nearest(self, pose: Pose2D) -> int:
        """Return the number of the place nearest to a pose."""
        return int(np.argmin(np.hypot(*(self._places - pose[:2]).T))) + 1

    def route(self, start: int, goal: int) -> LaneRoute:
        """Return the shortest way from place to place in the direction of lanes (Dijkstra, 1959).

        Raises
        ------
        NotFound
            There is no such place.
        NoValidPath
            No way leads from one to the other.
        """
        first, last = self.check(start) - 1, self.check(goal) - 1
        came: dict[int, tuple[int, int]] = {}
        lengths, waiting, done = {first: 0.0}, [(0.0, first)], set()
        while waiting:
            length, place = heapq.heappop(waiting)
            if place == last:
                return self._way(first, last, came)
            if place in done:
                continue
            done.add(place)
            for other, part, far in self._next.get(place, ()):
                if length + far < lengths.get(other, math.inf):
                    lengths[other], came[other] = length + far, (place, part)
                    heapq.heappush(waiting, (length + far, other))
        raise NoValidPath(f"no lanes lead from node {start} to node {goal}")

    def between(self, start: Pose2D, goal: Pose2D) -> LaneRoute:
        """Return the shortest way between the places nearest to two poses.

        The first part is left out if ``start`` is beside it, and the last one if ``goal`` is: nobody drives back to the
        place that is nearest. Raises as ``route`` does.
        """
        found = self.route(self.nearest(start), self.nearest(goal))
        if found.parts and _is_beside(start, *found.places[:2]):
            found = LaneRoute(found.places[1:], found.parts[1:])
        if found.parts and _is_beside(goal, *found.places[-2:]):
            found = LaneRoute(found.places[:-1], found.parts[:-1])
        return found

    def _way(self, first: int, last: int, came: dict[int, tuple[int, int]]) -> LaneRoute:
        places, parts = [last], []
        while places[-1] != first:
            before, part = came[places[-1]]
            places.append(before)
            parts.append(part)
        listed = tuple(LanePlace(place + 1, *self._places[place].tolist()) for place in reversed(places))
        return LaneRoute(listed, tuple(reversed(parts)))


def _is_beside(pose: Pose2D, begin: LanePlace, end: LanePlace) -> bool:
    """Return whether a pose is beside a part of a lane, not before its begin or beyond its end."""
    along = np.array((end.x - begin.x, end.y - begin.y))
    share = float(along @ (pose.x - begin.x, pose.y - begin.y)) / max(float(along @ along), 1e-12)
    return 0.0 < share < 1.0
