"""Placing: cells along lanes, as near to each other as robots may stand."""

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput
from ppaas.fleet.lane_drawing import LaneConflict, Network
from ppaas.fleet.robot_sizes import TINY
from ppaas.polygons import Points

# -- chains: the parts of a network between its ends and junctions -----------------------------------------------------


class Chain(NamedTuple):
    """Places one after the other, of which only the first and the last may be ends or junctions.

    Parameters
    ----------
    places : tuple of int
        Of a ring, the last is the first.
    name : str
        Name of the lane, of one of its first part if there are several.
    forth, back : bool
        Whether robots may drive along it, and the other way.
    """

    places: tuple[int, ...]
    name: str
    forth: bool
    back: bool


def chains_of(network: Network) -> list[Chain]:
    """Return the chains of a network; each part is in one of them."""
    near = network.near()
    keys = [place for place in near if _is_key(network, place, near[place])]
    left = {(min(part), max(part)) for part in network.names}
    found = []
    for start in [*keys, *near]:  # what is left after the key places are rings
        for other in near[start]:
            if (min(start, other), max(start, other)) in left:
                places = tuple(_walk(near, {start, *keys}, start, other))
                left -= {(min(part), max(part)) for part in pairwise(places)}
                found.append(_chain(network, places))
    return found


def _is_key(network: Network, place: int, near: list[int]) -> bool:
    """Return whether a place is an end, a junction, or where a lane becomes one-way."""
    if len(near) != 2:
        return True
    before, behind = near
    return _ways(network, before, place) != _ways(network, place, behind)


def _ways(network: Network, one: int, other: int) -> tuple[bool, bool]:
    return (one, other) in network.names, (other, one) in network.names


def _walk(near: dict[int, list[int]], ends: set[int], start: int, onward: int) -> Iterator[int]:
    before, here = start, onward
    yield start
    while here not in ends:
        yield here
        before, here = here, next(other for other in near[here] if other != before)
    yield here


def _chain(network: Network, places: tuple[int, ...]) -> Chain:
    one, other = places[:2]
    forth, back = _ways(network, one, other)
    name = network.names[one, other] if forth else network.names[other, one]
    return Chain(places, name, forth, back)


# -- cells along chains ------------------------------------------------------------------------------------------------

SHARPEST = math.radians(15.0)
"""Smallest angle between two lanes that meet [rad]."""

BENDS = 0.9
"""Cosine of the change of direction beyond which a corner gets a cell to itself."""

MOST_CELLS = 20_000
"""Largest number of cells along the lanes of a map."""

MOST_MEET = 4
"""Largest number of lanes that meet at a place: a cell has as many neighbours."""


class Placed(NamedTuple):
    """Cells along lanes.

    Parameters
    ----------
    centres : (v, 2) float64 array
        x, y [m] of each.
    names : dict of tuple of int to str
        Name of the lane of each move, from one cell to another.
    """

    centres: Points
    names: dict[tuple[int, int], str]


class _Fixed(NamedTuple):
    """Point of a chain that gets a cell: how far along it is, and how far the next cell has to be [m]."""

    along: float
    need: float


def placed_on(network: Network, spacing: float) -> Placed:
    """Return cells at all ends, junctions and corners of lanes, and between them.

    Neighbouring cells are from one to about two spacings apart. Corners that are nearer to each other than a spacing
    are cut.

    Parameters
    ----------
    network : Network
    spacing : float
        Least distance of the centres of two cells [m].

    Raises
    ------
    InvalidInput
        Ends or junctions are too near to each other, too many lanes meet, or there would be too many cells; the text
        names lanes and places.
    """
    return _Placing(network, spacing).run()


class _Placing:
    def __init__(self, network: Network, spacing: float) -> None:
        self._network, self._spacing = network, spacing
        self._chains = chains_of(network)
        self._lines = [_Polyline(network.places[list(chain.places)]) for chain in self._chains]
        self._centres: list[NDArray[np.float64]] = []
        self._names: dict[tuple[int, int], str] = {}
        self._of_place: dict[int, int] = {}

    def run(self) -> Placed:
        """Place all cells."""
        self._check_lengths()
        needs = self._needs()
        for number, (chain, line) in enumerate(zip(self._chains, self._lines, strict=True)):
            fixed = self._fixed(line, needs[number, 0], needs[number, 1])
            between = [at for one, other in pairwise(fixed) for at in self._between(chain, line, one, other)]
            self._connect(
                chain, [line.at(along) for along in sorted([*between, *(each.along for each in fixed[1:-1])])]
            )
        return Placed(np.array(self._centres), self._names)

    def _check_lengths(self) -> None:
        total = sum(line.length for line in self._lines)
        if total > MOST_CELLS * self._spacing:
            raise InvalidInput(
                f"the lanes are {total:.0f} m long: at {self._spacing:.2f} m they would have more than {MOST_CELLS} "
                "cells"
            )
        for chain, line in zip(self._chains, self._lines, strict=True):
            if chain.places[0] == chain.places[-1] and line.length < 3.0 * self._spacing:
                raise LaneConflict(
                    f"lane {chain.name!r} is a ring at {self._text(line.at(0.0))} that is {line.length:.2f} m long: "
                    f"robots of this size need {3.0 * self._spacing:.2f} m",
                    [chain.name],
                )

    def _needs(self) -> dict[tuple[int, int], float]:
        """Return how far the next cell has to be from the first and the last place of each chain [m]."""
        ends: dict[int, list[tuple[tuple[int, int], NDArray[np.float64]]]] = {}
        for number, (chain, line) in enumerate(zip(self._chains, self._lines, strict=True)):
            first = line.at(min(self._spacing, line.length)) - line.at(0.0)
            last = line.at(max(line.length - self._spacing, 0.0)) - line.at(line.length)
            ends.setdefault(chain.places[0], []).append(((number, 0), first))
            ends.setdefault(chain.places[-1], []).append(((number, 1), last))
        found = {}
        for place, leading in ends.items():
            if len(leading) > MOST_MEET:
                raise LaneConflict(
                    f"{len(leading)} lanes meet at {self._text(self._network.places[place])}, and at most {MOST_MEET} "
                    "may: let one of them end a little farther along another",
                    [self._chains[key[0]].name for key, _ in leading],
                )
            for key, leads in leading:
                angles = [_angle(leads, other) for also, other in leading if also != key]
                name = self._chains[key[0]].name
                found[key] = self._need(min(angles, default=math.pi), name, self._network.places[place])
        return found

    def _need(self, angle: float, name: str, place: NDArray[np.float64]) -> float:
        """Return how far cells must be from a place where lanes meet at an angle, to be as far from the other lane."""
        if angle < SHARPEST:
            raise LaneConflict(
                f"lane {name!r} meets another one at {self._text(place)} at {math.degrees(angle):.0f}°: at least "
                f"{math.degrees(SHARPEST):.0f}° are needed",
                [name],
            )
        return self._beside(angle)

    def _beside(self, angle: float) -> float:
        """Return how far along a line is a spacing away from another line at an angle to it."""
        return self._spacing / math.sin(min(angle, math.pi / 2.0))

    def _fixed(self, line: "_Polyline", first: float, last: float) -> list[_Fixed]:
        """Return the points of a chain that get cells: its ends, and corners that are far enough from each other."""
        found, end = [_Fixed(0.0, first)], _Fixed(line.length, last)
        for along, turn in line.corners():
            if math.pi - turn < SHARPEST:
                continue
            corner = _Fixed(along, self._beside(math.pi - turn))
            if all(line.apart(corner, other) >= max(corner.need, other.need) - TINY for other in (found[-1], end)):
                found.append(corner)
        return [*found, end]

    def _between(self, chain: Chain, line: "_Polyline", one: _Fixed, other: _Fixed) -> list[float]:
        """Return where cells are placed between two fixed ones: as many as there is room for."""
        length, s = other.along - one.along, self._spacing
        is_ring = chain.places[0] == chain.places[-1] and (one.along, other.along) == (0.0, line.length)
        for count in range(math.floor((length - one.need - other.need) / s + TINY) + 1, 0, -1):
            gaps = np.array([one.need, *[s] * (count - 1), other.need])
            more = (length - gaps.sum()) / len(gaps)
            places = one.along + np.cumsum(gaps + more)[:-1]
            chords = np.hypot(*np.diff([line.at(at) for at in (one.along, *places, other.along)], axis=0).T)
            if more > -TINY and chords.min() >= s - TINY and not (is_ring and count < 2):
                return [float(place) for place in places]
        need = max(one.need, other.need)
        if is_ring or line.apart(one, other) < need - TINY:
            span = f"{self._text(line.at(one.along))} and {self._text(line.at(other.along))}"
            raise LaneConflict(
                f"lane {chain.name!r} is too short between {span}: robots of this size need {need:.2f} m there; "
                "draw ends and junctions farther apart, or in one place",
                [chain.name],
            )
        return []

    def _connect(self, chain: Chain, points: Sequence[NDArray[np.float64]]) -> None:
        cells = [self._cell(chain.places[0]), *(self._add(point) for point in points), self._cell(chain.places[-1])]
        for one, other in pairwise(cells):
            if chain.forth:
                self._names.setdefault((one, other), chain.name)
            if chain.back:
                self._names.setdefault((other, one), chain.name)

    def _cell(self, place: int) -> int:
        if place not in self._of_place:
            self._of_place[place] = self._add(self._network.places[place])
        return self._of_place[place]

    def _add(self, point: NDArray[np.float64]) -> int:
        self._centres.append(point)
        return len(self._centres) - 1

    @staticmethod
    def _text(place: NDArray[np.float64]) -> str:
        return f"{place[0]:.2f}, {place[1]:.2f}"


class _Polyline:
    """Points one after the other, and how far along each is [m]."""

    def __init__(self, points: Points) -> None:
        self._points = points
        self._along = np.append(0.0, np.cumsum(np.hypot(*np.diff(points, axis=0).T)))

    @property
    def length(self) -> float:
        return float(self._along[-1])

    def at(self, along: float) -> NDArray[np.float64]:
        """Return the point at a distance along the line [m]."""
        return np.array([np.interp(along, self._along, self._points[:, axis]) for axis in (0, 1)])

    def apart(self, one: _Fixed, other: _Fixed) -> float:
        """Return the straight distance of two points of the line [m]."""
        return math.dist(self.at(one.along), self.at(other.along))

    def corners(self) -> Iterator[tuple[float, float]]:
        """Yield how far along the line its corners are [m], and by how much it turns there [rad]."""
        parts = np.diff(self._points, axis=0)
        for number, (one, other) in enumerate(pairwise(parts), 1):
            turn = _angle(one, other)
            if math.cos(turn) < BENDS:
                yield float(self._along[number]), turn


def _angle(one: NDArray[np.float64], other: NDArray[np.float64]) -> float:
    """Return the angle between two directions, from 0 to π [rad]."""
    return math.atan2(abs(one[0] * other[1] - one[1] * other[0]), float(one @ other))
