"""Shortest times between the junctions of a building, kept until a length, a door or a lift changes.

Each floor has a matrix of the times between its junctions, and the building one between its portals, the landings of
lifts and the ends of ways. A door that closes changes the matrix of its floor and the one of the building alone.
"""

import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ppaas.buildings.planning.network import BuildingLink, BuildingNetwork, JunctionChain

Matrix = NDArray[np.float64]

STEP = 1e-6
"""Added to the time of every move between junctions [s]: of equal routes, the one with the fewest moves is found."""


@dataclass(frozen=True, slots=True)
class Traveller:
    """What a robot can do.

    Parameters
    ----------
    speed : float
        Mean speed [m/s].
    labels : mapping of str to str
        Labels, which some ways ask for.
    stairs : bool
        Whether it climbs stairs.
    avoid : frozenset of str
        Ids of lifts and ways that it does not take.
    """

    speed: float = 0.5
    labels: Mapping[str, str] = field(default_factory=dict)
    stairs: bool = False
    avoid: frozenset[str] = frozenset()

    def may_take(self, link: BuildingLink) -> bool:
        """Return whether it may take a lift or a way."""
        if link.name in self.avoid:
            return False
        if link.way is None:
            return True
        if link.way.kind == "stairs" and not self.stairs:
            return False
        return all(self.labels.get(name) == value for name, value in link.way.labels.items())


class BuildingState:
    """What is known of a building at a time: lengths on its floors, closed doors, and lifts out of order.

    Lengths that are not measured are lower bounds, the distances of the places less a slack.

    Parameters
    ----------
    network : BuildingNetwork
    slack : sequence of float, optional
        Largest error of the distance of two places on each floor, as a bound of the length between them [m].
    """

    def __init__(self, network: BuildingNetwork, slack: Sequence[float] | None = None) -> None:
        self.network = network
        self.lengths = [
            _bounds(network, floor, 0.0 if slack is None else slack[floor]) for floor in range(len(network.floors))
        ]
        self.measured = [len(part) < 2 for part in network.parts]
        self.closed: frozenset[tuple[str, str]] = frozenset()
        self.out_of_order: frozenset[str] = frozenset()
        self.waits: Mapping[tuple[str, str], float] = {}
        self.stamps, self.stamp = [0] * len(network.floors), 0

    def measure(self, floor: int, lengths: Matrix) -> None:
        """Replace the bounds of the lengths between the junctions of a floor by the lengths [m]; infinite if none."""
        self.lengths[floor], self.measured[floor] = lengths, True
        self._changed([floor])

    def close(self, doors: Iterable[tuple[str, str]]) -> None:
        """Close these doors, each a floor and a name, and open all others."""
        closed = frozenset(doors)
        different = closed ^ self.closed
        self.closed = closed
        self._changed({self.network.number_of[floor] for floor, _ in different if floor in self.network.number_of})

    def break_down(self, names: Iterable[str]) -> None:
        """Put these lifts and ways out of order, and all others into service."""
        broken = frozenset(names)
        if broken != self.out_of_order:
            self.out_of_order = broken
            self.stamp += 1

    def expect(self, waits: Mapping[tuple[str, str], float]) -> None:
        """Expect these waits for lifts [s], by lift and floor, instead of the mean ones; infinite: it is not taken."""
        if waits != self.waits:
            self.waits = dict(waits)
            self.stamp += 1

    def _changed(self, floors: Iterable[int]) -> None:
        for floor in floors:
            self.stamps[floor] += 1
            self.stamp += 1


class BuildingTimes:
    """Shortest times of a robot between the junctions of a building, computed as they are asked for.

    Parameters
    ----------
    state : BuildingState
        May change at any time.
    traveller : Traveller
    """

    def __init__(self, state: BuildingState, traveller: Traveller) -> None:
        self.state, self.network, self.traveller = state, state.network, traveller
        network = self.network
        self._slot = {number: slot for slot, number in enumerate(network.portals)}
        self._local = [np.array([n - part.start for n in part if n in self._slot], int) for part in network.parts]
        self._slots = [np.array([self._slot[n] for n in part if n in self._slot], int) for part in network.parts]
        floors = len(network.floors)
        self._moves: list[Matrix | None] = [None] * floors
        self._on_floor: list[Matrix | None] = [None] * floors
        self._seen = [-1] * floors
        self._stamp = -1
        self._links_of: tuple[frozenset[str], Mapping[tuple[str, str], float]] | None = None
        count = len(network.portals)
        self._portal_moves = self._portals = np.full((count, count), math.inf)
        self._between: dict[tuple[int, int], Matrix] = {}
        self._metres: dict[tuple[int, int], Matrix] = {}
        self._chains: dict[tuple[int, int], JunctionChain] = {}
        self.links: list[list[tuple[BuildingLink, float]]] = []

    def between(self, floor: int, other: int) -> Matrix:
        """Return the times from each junction of a floor to each junction of another, or of the same [s]."""
        self._refresh()
        found = self._between.get((floor, other))
        if found is None:
            out, into = self.on_floor(floor)[:, self._local[floor]], self.on_floor(other)[self._local[other]]
            over = self._portals[np.ix_(self._slots[floor], self._slots[other])]
            found = least_sums(least_sums(out, over), into)
            if floor == other:
                found = np.minimum(found, self.on_floor(floor))
            self._between[floor, other] = found
        return found

    def metres_between(self, floor: int, other: int) -> Matrix:
        """Return ``between`` as the lengths that the robot would drive in these times [m]."""
        self._refresh()
        found = self._metres.get((floor, other))
        if found is None:
            found = self._metres[floor, other] = self.between(floor, other) * self.traveller.speed
        return found

    def on_floor(self, floor: int) -> Matrix:
        """Return the times between the junctions of a floor, without any lift or way [s]."""
        self._refresh()
        found = self._on_floor[floor]
        if found is None:
            moves = self._moves[floor] = self._floor_moves(floor)
            found = self._on_floor[floor] = _closure(moves)
        return found

    def to_portals(self, floor: int, seconds: Matrix) -> Matrix:
        """Return the least times from all portals to an end, given its times to the junctions of its floor [s]."""
        self._refresh()
        last = self.from_portals_of(floor, seconds)
        return _least(self._portals[:, self._slots[floor]] + last)

    def from_portals_of(self, floor: int, seconds: Matrix) -> Matrix:
        """Return the times from the portals of a floor to an end on it, given its times to the junctions there [s]."""
        return _least(self.on_floor(floor)[self._local[floor]] + seconds)

    def slot(self, portal: int) -> int:
        """Return the place of a portal in results of ``to_portals``."""
        return self._slot[portal]

    def chain(self, start: int, goal: int) -> JunctionChain:
        """Return the shortest way from one junction to another; there must be one."""
        self._refresh()
        found = self._chains.get((start, goal))
        if found is None:
            found = self._chains[start, goal] = self.without_passed(self._find_chain(start, goal))
        return found

    def without_passed(self, junctions: Sequence[int]) -> JunctionChain:
        """Return a way without the junctions at which the robot only drives by."""
        names = list[str]()
        for one, other in itertools.pairwise(junctions):
            if self.network.junctions[one].floor != self.network.junctions[other].floor:
                names.append(self.link_between(one, other).name)
        driven = [True, *map(self.network.is_driven, junctions, junctions[1:]), True]
        kept = (each for number, each in enumerate(junctions) if not (driven[number] and driven[number + 1]))
        return JunctionChain(tuple(kept), tuple(names))

    def link_between(self, one: int, other: int) -> BuildingLink:
        """Return the fastest link between two junctions on different floors; there must be one."""
        found = [(seconds, link) for link, seconds in self.links[one] if link.goal == other]
        return min(found, key=lambda each: each[0])[1]

    def trail(self, floor: int, start: int, goal: int) -> list[int]:
        """Return the junctions on the shortest way on a floor, both ends included; there must be one."""
        times, first = self.on_floor(floor), self.network.parts[floor].start
        moves = self._moves[floor]
        assert moves is not None
        return [first + each for each in _trail(moves, times, start - first, goal - first)]

    # -- making ----------------------------------------------------------------------------------------------------

    def _refresh(self) -> None:
        if self._stamp == self.state.stamp:
            return
        self._stamp = self.state.stamp
        self._between.clear()
        self._metres.clear()
        self._chains.clear()
        if self._links_of != (self.state.out_of_order, self.state.waits):
            self._use_links()
        for floor, stamp in enumerate(self.state.stamps):
            if self._seen[floor] != stamp:
                self._on_floor[floor], self._seen[floor] = None, stamp
                slots, local = self._slots[floor], self._local[floor]
                self._portal_moves[np.ix_(slots, slots)] = self.on_floor(floor)[np.ix_(local, local)]
        np.fill_diagonal(self._portal_moves, math.inf)
        self._portals = _closure(self._portal_moves)

    def _use_links(self) -> None:
        """List the lifts and ways that the robot may take and that are in service."""
        self._links_of = self.state.out_of_order, self.state.waits
        self._seen = [-1] * len(self._seen)
        self._portal_moves = np.full_like(self._portal_moves, math.inf)
        self.links = [[] for _ in self.network.junctions]
        for link in self.network.links:
            seconds = self.seconds_with_wait(link)
            if self.traveller.may_take(link) and link.name not in self.state.out_of_order and math.isfinite(seconds):
                self.links[link.start].append((link, seconds))
                at = self._slot[link.start], self._slot[link.goal]
                self._portal_moves[at] = min(self._portal_moves[at], seconds)

    def seconds_with_wait(self, link: BuildingLink) -> float:
        """Return the time that a lift or a way takes, with the wait that is expected now [s]."""
        seconds, waits = self.seconds_of(link), self.state.waits
        if link.way is not None or not waits:
            return seconds
        names = (self.network.floors[self.network.junctions[each].floor] for each in (link.start, link.goal))
        usual = self.network.layout.building.lift(link.name).wait
        wait, there = (waits.get((link.name, floor), usual) for floor in names)
        return seconds - usual + wait if math.isfinite(there) else math.inf

    def seconds_of(self, link: BuildingLink) -> float:
        """Return the time that a link takes [s]."""
        return link.seconds + link.metres / self.traveller.speed + STEP

    def _floor_moves(self, floor: int) -> Matrix:
        moves = self.state.lengths[floor] / self.traveller.speed + STEP
        first, name = self.network.parts[floor].start, self.network.floors[floor]
        for door in self.network.doors:
            if self.network.junctions[door.start].floor == floor and (name, door.name) not in self.state.closed:
                at = door.start - first, door.goal - first
                moves[at] = min(moves[at], self.seconds_of(door))
        np.fill_diagonal(moves, math.inf)
        return moves

    def _find_chain(self, start: int, goal: int) -> list[int]:
        here, there = self.network.junctions[start].floor, self.network.junctions[goal].floor
        first, last = self.network.parts[here].start, self.network.parts[there].start
        out, into = self.on_floor(here)[start - first, self._local[here]], self.on_floor(there)[:, goal - last]
        over = out[:, None] + self._portals[np.ix_(self._slots[here], self._slots[there])] + into[self._local[there]]
        if here == there and not (over.size and over.min() < into[start - first]):
            return self.trail(here, start, goal)
        leaving, entering = np.unravel_index(int(over.argmin()), over.shape)
        slots = int(self._slots[here][leaving]), int(self._slots[there][entering])
        portals = [self.network.portals[each] for each in _trail(self._portal_moves, self._portals, *slots)]
        chain = self.trail(here, start, portals[0])
        for one, other in itertools.pairwise(portals):
            floor = self.network.junctions[one].floor
            same = floor == self.network.junctions[other].floor
            chain += self.trail(floor, one, other)[1:] if same else [other]
        return chain + self.trail(there, portals[-1], goal)[1:]


def _bounds(network: BuildingNetwork, floor: int, slack: float) -> Matrix:
    places = np.array([network.junctions[n].place[:2] for n in network.parts[floor]]).reshape(-1, 2)
    apart = np.hypot(*(places[:, None] - places).T)
    bounds: Matrix = np.maximum(apart - slack, 0.0)
    return bounds


def _closure(moves: Matrix) -> Matrix:
    """Return the shortest times of all pairs, given the times of single moves (algorithm of Floyd and Warshall)."""
    times = moves.copy()
    np.fill_diagonal(times, 0.0)
    for middle in range(len(times)):
        np.minimum(times, times[:, middle, None] + times[middle], out=times)
    return times


def least_sums(one: Matrix, other: Matrix) -> Matrix:
    """Return the (n, m) least sums over what is between, given (n, k) and (k, m) times."""
    sums = np.full((len(one), other.shape[1]), math.inf)
    for middle, times in enumerate(other):
        np.minimum(sums, one[:, middle, None] + times, out=sums)
    return sums


def _least(sums: Matrix) -> Matrix:
    """Return the least number of each row; infinite for empty rows."""
    least: Matrix = sums.min(axis=1, initial=math.inf)
    return least


def _trail(moves: Matrix, times: Matrix, start: int, goal: int) -> list[int]:
    trail = [start]
    while trail[-1] != goal and len(trail) <= len(times):
        trail.append(int((moves[trail[-1]] + times[:, goal]).argmin()))
    return trail
