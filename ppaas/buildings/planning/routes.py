"""Routes over the floors of a building: the best one, and others that take other lifts and ways."""

import heapq
import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import count as counter

import numpy as np

from ppaas.buildings.planning.network import BuildingLink, JunctionChain
from ppaas.buildings.planning.times import BuildingTimes, Matrix

MOST_PARTIAL = 20_000
"""Largest number of partial routes that are continued in the search for alternatives."""


@dataclass(frozen=True, slots=True)
class RouteStart:
    """Floor on which a route may begin.

    Parameters
    ----------
    floor : int
    seconds : (n,) array
        Times to the junctions of the floor [s]; infinite where there is no path.
    direct : float
        Time of the path to the goal on the same floor, through no door [s]; infinite if there is none.
    landing : int
        Number of the junction at which the robot leaves a lift that it is in; −1 if it is on the floor.
    """

    floor: int
    seconds: Matrix
    direct: float = math.inf
    landing: int = -1


@dataclass(frozen=True, slots=True)
class RouteEnd:
    """Floor and times of a goal, as ``Start``."""

    floor: int
    seconds: Matrix


@dataclass(frozen=True, slots=True)
class Route:
    """Route as junctions.

    Parameters
    ----------
    seconds : float
        Time from start to goal [s].
    start : RouteStart
    chain : JunctionChain
        Without junctions if it drives directly to the goal.
    """

    seconds: float
    start: RouteStart
    chain: JunctionChain


DIRECT = JunctionChain((), ())
"""The way of a robot that drives to its goal without a door, a lift or a way."""


def best_route(times: BuildingTimes, starts: Sequence[RouteStart], goal: RouteEnd) -> Route | None:
    """Return the shortest route; None if there is none."""
    best: Route | None = None
    for start in starts:
        total = start.seconds[:, None] + times.between(start.floor, goal.floor) + goal.seconds
        least = float(total.min(initial=math.inf))
        direct = start.direct if start.floor == goal.floor else math.inf
        if min(least, direct) >= (best.seconds if best else math.inf):
            continue
        if direct <= least:
            best = Route(direct, start, DIRECT)
        else:
            first, last = (int(each) for each in np.unravel_index(int(total.argmin()), total.shape))
            parts = times.network.parts
            chain = times.chain(parts[start.floor].start + first, parts[goal.floor].start + last)
            best = Route(least, start, chain)
    return best


# -- alternatives ------------------------------------------------------------------------------------------------------


def alternatives(
    times: BuildingTimes, starts: Sequence[RouteStart], goal: RouteEnd, count: int, first: str = ""
) -> list[Route]:
    """Return up to ``count`` routes, the best first, each with another sequence of lifts and ways.

    The first is the best of all; the others are the best ones that take no lift or way twice. They are found in the
    order of their times by A* over partial routes, whose bound is the time of the rest without this rule.

    Parameters
    ----------
    times : BuildingTimes
    starts : sequence of RouteStart
    goal : RouteEnd
    count : int
    first : str
        Id of a lift or way with which all of them begin; any if empty.
    """
    found: list[Route] = [] if first else _without_links(times, starts, goal)
    found += _Search(times, goal).routes(starts, count, first)
    found.sort(key=lambda each: each.seconds)
    best = None if first else best_route(times, starts, goal)
    if best is not None and all(each.chain.names != best.chain.names for each in found):
        found.insert(0, best)  # it takes a lift twice
    return found[:count]


def _without_links(times: BuildingTimes, starts: Sequence[RouteStart], goal: RouteEnd) -> list[Route]:
    """Return the best route that stays on its floor, if there is one."""
    best: Route | None = None
    for start in (each for each in starts if each.floor == goal.floor):
        total = start.seconds[:, None] + times.on_floor(goal.floor) + goal.seconds
        least = float(total.min(initial=math.inf))
        seconds = min(least, start.direct)
        if not math.isfinite(seconds) or (best is not None and seconds >= best.seconds):
            continue
        chain = DIRECT
        if start.direct > least:
            first = times.network.parts[goal.floor].start
            one, other = (first + int(each) for each in np.unravel_index(int(total.argmin()), total.shape))
            chain = times.without_passed(times.trail(goal.floor, one, other))
        best = Route(seconds, start, chain)
    return [] if best is None else [best]


@dataclass(frozen=True, slots=True)
class _Partial:
    """Route up to a portal: time so far, the portal, names of what it took, and the links with their floor of start."""

    seconds: float
    at: int
    names: tuple[str, ...]
    start: RouteStart
    links: tuple[BuildingLink, ...]


class _Search:
    def __init__(self, times: BuildingTimes, goal: RouteEnd) -> None:
        self._times, self._goal, self._network = times, goal, times.network
        self._rest = times.to_portals(goal.floor, goal.seconds)
        self._last = times.from_portals_of(goal.floor, goal.seconds)
        on_floor = (each for each in self._network.parts[goal.floor] if self._network.junctions[each].is_portal)
        self._local = {portal: number for number, portal in enumerate(on_floor)}

    def routes(self, starts: Sequence[RouteStart], count: int, first: str) -> list[Route]:
        queue: list[tuple[float, int, _Partial, bool]] = []
        order, found, seen = counter(), dict[tuple[str, ...], Route](), set[tuple[int, tuple[str, ...]]]()
        for start in starts:
            times = self._times.on_floor(start.floor)
            to_all = (start.seconds[:, None] + times).min(axis=0, initial=math.inf)
            self._push(queue, order, _Partial(0.0, -1, (), start, ()), to_all, first)
        for _ in range(MOST_PARTIAL):
            if not queue or len(found) == count:
                break
            _, _, partial, is_complete = heapq.heappop(queue)
            if is_complete:
                if partial.names not in found:
                    found[partial.names] = self._complete(partial)
                continue
            if (partial.at, partial.names) in seen:
                continue
            seen.add((partial.at, partial.names))
            floor = self._network.junctions[partial.at].floor
            if floor == self._goal.floor:
                total = partial.seconds + float(self._last[self._local[partial.at]])
                if math.isfinite(total):
                    done = _Partial(total, partial.at, partial.names, partial.start, partial.links)
                    heapq.heappush(queue, (total, next(order), done, True))
            part = self._network.parts[floor]
            self._push(queue, order, partial, self._times.on_floor(floor)[partial.at - part.start])
        return list(found.values())

    def _push(
        self, queue: list[tuple[float, int, _Partial, bool]], order: "counter[int]",
        partial: _Partial, to_all: Matrix, first: str = "",
    ) -> None:  # fmt: skip
        """Queue the routes that go on by each link of the floor, given the times from here to its junctions."""
        floor = partial.start.floor if partial.at < 0 else self._network.junctions[partial.at].floor
        part = self._network.parts[floor]
        for portal in part:
            for link, seconds in self._times.links[portal]:
                if link.name in partial.names or (first and link.name != first):
                    continue
                so_far = partial.seconds + float(to_all[portal - part.start]) + seconds
                bound = so_far + float(self._rest[self._times.slot(link.goal)])
                if math.isfinite(bound):
                    names, links = (*partial.names, link.name), (*partial.links, link)
                    heapq.heappush(
                        queue, (bound, next(order), _Partial(so_far, link.goal, names, partial.start, links), False)
                    )

    def _complete(self, partial: _Partial) -> Route:
        """Return the route of the links of a partial one, with the doors between them."""
        times, parts, start = self._times, self._network.parts, partial.start
        own = start.seconds + times.on_floor(start.floor)[:, partial.links[0].start - parts[start.floor].start]
        chain = times.trail(start.floor, parts[start.floor].start + int(own.argmin()), partial.links[0].start)
        for link, after in zip(partial.links, partial.links[1:], strict=False):
            chain += times.trail(self._network.junctions[link.goal].floor, link.goal, after.start)
        last, floor = partial.links[-1].goal, self._goal.floor
        rest = times.on_floor(floor)[last - parts[floor].start] + self._goal.seconds
        chain += times.trail(floor, last, parts[floor].start + int(rest.argmin()))
        return Route(partial.seconds, start, times.without_passed(chain))
