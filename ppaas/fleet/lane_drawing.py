"""Drawing: lanes that cross, meet or lie on each other, as one network of places and straight parts."""

from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput
from ppaas.polygons import Points, distances_to_edges
from ppaas.zones.shapes import lines_of
from ppaas.zones.zone import Lane, Zone

JOINS = 0.1
"""Distance within which an end, a corner or a crossing of lanes is the same place as another one [m]."""

STRAIGHT = JOINS / 2.0
"""Distance from a straight part within which corners of a lane are left out [m]."""


class LaneConflict(InvalidInput):
    """Lanes are too near to each other or too short for robots; ``lanes`` names those that are in conflict."""

    def __init__(self, text: str, lanes: Sequence[str] = ()) -> None:
        super().__init__(text)
        self.lanes = tuple(lanes)


class DrawnLane(NamedTuple):
    """Lane as it was drawn.

    Parameters
    ----------
    name : str
    points : (k, 2) float64 array
        Positions in the order of driving [m], at least two.
    one_way : bool
    """

    name: str
    points: Points
    one_way: bool


class Network(NamedTuple):
    """Places that straight parts of lanes connect.

    Parameters
    ----------
    places : (n, 2) float64 array
        x, y [m] of each.
    names : dict of tuple of int to str
        Name of the lane on each part along which robots may drive, from one place to another.
    """

    places: Points
    names: dict[tuple[int, int], str]

    def near(self) -> dict[int, list[int]]:
        """Return the places that parts connect with each place, in either direction, in ascending order."""
        found: dict[int, set[int]] = {}
        for one, other in self.names:
            found.setdefault(one, set()).add(other)
            found.setdefault(other, set()).add(one)
        return {place: sorted(others) for place, others in sorted(found.items())}


def lines_in(zones: Iterable[Zone]) -> list[DrawnLane]:
    """Return the lanes among zones, in their order."""
    return [
        DrawnLane(zone.name, np.array([position[:2] for position in line]), zone.rule.one_way)
        for zone in zones
        if isinstance(zone.rule, Lane)
        for line in lines_of(zone.geometry)
    ]


def network_of(lines: Sequence[DrawnLane], *, every_corner: bool = False) -> Network:
    """Return the network of some lanes.

    Lanes are connected where they cross, where an end or a corner of one is on another one, and where they lie on each
    other; all within `JOINS`.

    Parameters
    ----------
    lines : sequence of DrawnLane
    every_corner : bool
        Whether corners on straight parts are places, too.

    Raises
    ------
    LaneConflict
        A lane is so short that it is one place.
    """
    corners = [line.points if every_corner else _simple(line.points) for line in lines]
    starts = np.concatenate([points[:-1] for points in corners])
    ends = np.concatenate([points[1:] for points in corners])
    owners = [line for line, points in zip(lines, corners, strict=True) for _ in points[1:]]
    breaks = _breaks(starts, ends)
    places = _Places(2 * len(starts) + sum(map(len, breaks)))
    for points in corners:
        places.numbers(points)
    names: dict[tuple[int, int], str] = {}
    drawn: set[str] = set()
    for number, line in enumerate(owners):
        along = starts[number] + np.array(sorted(breaks[number]))[:, np.newaxis] * (ends[number] - starts[number])
        parts = [part for part in pairwise(places.numbers(along)) if part[0] != part[1]]
        drawn |= {line.name} if parts else set()
        for one, other in parts:
            names.setdefault((one, other), line.name)
            if not line.one_way:
                names.setdefault((other, one), line.name)
    for line in lines:
        if line.name not in drawn:
            text = f"lane {line.name!r} is shorter than {JOINS:g} m: draw it longer, or remove it"
            raise LaneConflict(text, [line.name])
    return Network(places.found.copy(), names)


class _Places:
    """Places by number, of which two are never within `JOINS`; ``most`` of them at most."""

    def __init__(self, most: int) -> None:
        self._all, self._count = np.empty((most, 2)), 0

    @property
    def found(self) -> Points:
        """All places, (n, 2)."""
        return self._all[: self._count]

    def numbers(self, points: Points) -> list[int]:
        """Return the numbers of points; each that is new is added."""
        return [self._number(point) for point in points]

    def _number(self, point: NDArray[np.float64]) -> int:
        apart = np.hypot(*(self.found - point).T)
        nearest = int(apart.argmin()) if self._count else 0
        if self._count and apart[nearest] <= JOINS:
            return nearest
        self._all[self._count] = point
        self._count += 1
        return self._count - 1


def _simple(points: Points) -> Points:
    """Return a line without corners that are nearer than `STRAIGHT` to it (Douglas and Peucker, 1973)."""
    kept = {0, len(points) - 1}
    spans = [(0, len(points) - 1)]
    while spans:
        first, last = spans.pop()
        if last - first < 2:
            continue
        off = distances_to_edges(points[first], points[last], points[first + 1 : last])
        farthest = first + 1 + int(off.argmax())
        if off.max() > STRAIGHT:
            kept.add(farthest)
            spans += [(first, farthest), (farthest, last)]
    return points[sorted(kept)]


def _breaks(starts: Points, ends: Points) -> list[set[float]]:
    """Return where each segment is divided, from 0 at its start to 1 at its end."""
    breaks = [{0.0, 1.0} for _ in starts]
    corners = np.concatenate([starts, ends])
    for number, (start, end) in enumerate(zip(starts, ends, strict=True)):
        near = corners[distances_to_edges(start, end, corners) <= JOINS]
        breaks[number].update(_along(start, end, near))
        breaks[number].update(_crossings(start, end, starts, ends))
    return breaks


def _along(start: NDArray[np.float64], end: NDArray[np.float64], points: Points) -> Iterator[float]:
    """Yield how far along a segment points are, from 0 to 1."""
    line = end - start
    yield from np.clip((points - start) @ line / max(float(line @ line), 1e-12), 0.0, 1.0).tolist()


def _crossings(start: NDArray[np.float64], end: NDArray[np.float64], starts: Points, ends: Points) -> Iterable[float]:
    """Return how far along a segment it crosses others, from 0 to 1."""
    line, others, offsets = end - start, ends - starts, starts - start
    turns = _cross(line, others)
    crosses = np.abs(turns) > 1e-12
    turns = np.where(crosses, turns, 1.0)
    own, other = _cross(offsets, others) / turns, _cross(offsets, line) / turns
    crosses &= (own >= 0.0) & (own <= 1.0) & (other >= 0.0) & (other <= 1.0)
    found: list[float] = own[crosses].tolist()
    return found


def _cross(one: NDArray[np.float64], other: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0])
