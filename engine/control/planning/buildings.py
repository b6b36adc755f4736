"""Plans over the floors of a building, from lengths and paths on its maps that planning containers compute.

Lengths between the places of lifts, ways and doors are asked for once per map version, and only on floors that a route
may cross: until then they are bounded by distances. The paths on floors are ordinary plans of the maps.
"""

import asyncio
import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import pairwise, product
from typing import Any

import msgspec
import numpy as np

from engine.control.planning.building_requests import (
    BuildingRoute,
    BuildingScene,
    BuildingSpot,
    FloorPath,
    KeptLengths,
)
from engine.control.planning.planning import Planning
from engine.control.planning.requests import CostRequest
from ppaas.buildings.layout import Place
from ppaas.buildings.planning.legs import Leg, legs_of
from ppaas.buildings.planning.network import BuildingNetwork
from ppaas.buildings.planning.routes import Route, RouteEnd, RouteStart, alternatives
from ppaas.buildings.planning.sessions import Session, starts_from_car, with_begun_first, without_margin
from ppaas.buildings.planning.times import BuildingState, BuildingTimes, Matrix, least_sums
from ppaas.decoding import from_json
from ppaas.errors import NoValidPath
from ppaas.plans.path_service import PathRequest

PLANNER = "hub_labels"
"""Planner of the paths on floors."""

NEAR = 0.5
"""Distance up to which an end in an occupied cell is moved to a free one [m]."""

SLACK = 2.0
"""Largest error of the distance of two places as a bound of the length between them [m]: both may be moved by `NEAR`,
and to the middle of a cell."""

MOST_AT_ONCE = 50_000
"""Largest number of lengths of a request."""


class BuildingPlanning:
    """Plans over floors.

    Parameters
    ----------
    planning : Planning
        Computes lengths and paths on maps.
    kept : KeptLengths
        Lengths of earlier requests.
    """

    def __init__(self, planning: Planning, kept: KeptLengths) -> None:
        self._planning, self._kept = planning, kept

    async def plan(
        self, user: str, scene: BuildingScene, start: BuildingSpot, goal: BuildingSpot,
        *, count: int = 1, session: Session | None = None,
    ) -> list[BuildingRoute]:  # fmt: skip
        """Return up to ``count`` routes by other lifts and ways, the best first; the first one has its paths.

        A robot with a ``session`` that waits for a lift, or is in its car, keeps it unless another route is clearly
        faster; ``start`` is not used if it is in the car.

        Raises
        ------
        NoValidPath
            There is no route.
        InvalidBuilding, InvalidInput
            There is no such floor or lift.
        PlanningError, QuotaExceeded, Queued, Starting, Unavailable
            As ``Planning.compute_path`` raises them.
        """
        times = self._times(scene)
        inside = session is not None and session.inside
        starts = starts_from_car(times, session) if session is not None and session.inside else []
        floors = [self._floor(scene, times, spot) for spot in ((goal,) if inside else (start, goal))]
        # The lengths between the junctions of both floors, too: a route may pass by a junction there.
        end, begun, _ = await asyncio.gather(
            self._goal(user, scene, times, goal),
            self._starts(user, scene, times, () if inside else (start,), goal),
            self._measure(user, scene, times, set(floors)),
        )
        starts += begun
        routes = await self._routes(user, scene, times, (starts, end), count, session=session)
        if not routes:
            raise NoValidPath(_no_route(scene, start, goal))
        ends = start.place, goal.place
        found = list[BuildingRoute]()
        for route in routes:
            shown = without_margin(times, route, session) if inside and session is not None else route
            legs = legs_of(times, route, end, ends, session)
            found.append(BuildingRoute(shown.seconds, route.chain.names, legs, []))
        return [replace(found[0], paths=await self.paths(user, scene, found[0].legs)), *found[1:]]

    async def costs(
        self, user: str, scene: BuildingScene, starts: Sequence[BuildingSpot], goals: Sequence[BuildingSpot]
    ) -> Matrix:
        """Return the (n, m) times from each start to each goal [s], infinite without a route; raises as ``plan``."""
        times = self._times(scene)
        network = times.network
        crossed = [floor for floor, part in enumerate(network.parts) if len(part) > 1]
        begins, ends, direct, _ = await asyncio.gather(
            self._from_all(user, scene, times, starts),
            self._from_all(user, scene, times, goals),
            self._direct(user, scene, starts, goals),
            self._measure(user, scene, times, crossed),
        )
        costs = direct / times.traveller.speed
        for here, there in product({spot.floor for spot in starts}, {spot.floor for spot in goals}):
            rows, columns = _on(starts, here), _on(goals, there)
            between = times.between(network.number_of[here], network.number_of[there])
            out, into = np.stack([begins[row] for row in rows]), np.stack([ends[column] for column in columns])
            found = least_sums(least_sums(out, between), into.T)
            costs[np.ix_(rows, columns)] = np.minimum(costs[np.ix_(rows, columns)], found)
        return costs

    async def paths(self, user: str, scene: BuildingScene, legs: Sequence[Leg]) -> list[FloorPath | None]:
        """Return the path of each leg that is a drive; raises as ``Planning.compute_path``."""
        return list(await asyncio.gather(*(self._path(user, scene, leg) for leg in legs)))

    # -- parts -----------------------------------------------------------------------------------------------------

    def _times(self, scene: BuildingScene) -> BuildingTimes:
        network = BuildingNetwork(scene.layout)
        state = BuildingState(network, [SLACK] * len(network.floors))
        for number, name in enumerate(network.floors):
            if name not in scene.maps:
                state.measure(number, np.full_like(state.lengths[number], math.inf))
            elif (kept := self._kept.get(_key(scene, network, number))) is not None:
                state.measure(number, kept)
        state.close(scene.closed)
        state.expect(scene.waits)
        return BuildingTimes(state, scene.traveller)

    async def _routes(
        self, user: str, scene: BuildingScene, times: BuildingTimes,
        ends: tuple[Sequence[RouteStart], RouteEnd], count: int,
        *, session: Session | None,
    ) -> list[Route]:  # fmt: skip
        """Return the best routes, for which floors are measured until no route depends on a bound."""
        while True:
            routes = alternatives(times, *ends, count)
            if session is not None and not session.inside:
                routes = with_begun_first(times, *ends, routes, session)
            unknown = {floor for route in routes for floor in _crossed(times, route)}
            unknown = {floor for floor in unknown if not times.state.measured[floor]}
            if not unknown:
                return routes
            await self._measure(user, scene, times, unknown)

    async def _measure(self, user: str, scene: BuildingScene, times: BuildingTimes, floors: Iterable[int]) -> None:
        """Measure the lengths between the junctions of floors, those that are not known."""
        wanted = [floor for floor in floors if not times.state.measured[floor]]

        async def measure(floor: int) -> None:
            places = [times.network.junctions[number].place for number in times.network.parts[floor]]
            lengths = await self._lengths(user, scene, times.network.floors[floor], places, places)
            self._kept.put(_key(scene, times.network, floor), lengths)
            times.state.measure(floor, lengths)

        await asyncio.gather(*map(measure, wanted))

    async def _starts(
        self, user: str, scene: BuildingScene, times: BuildingTimes, spots: Iterable[BuildingSpot], goal: BuildingSpot
    ) -> list[RouteStart]:
        starts = list[RouteStart]()
        for spot in spots:
            floor = self._floor(scene, times, spot)
            places = [times.network.junctions[number].place for number in times.network.parts[floor]]
            same = spot.floor == goal.floor
            to = [*places, goal.place] if same else places
            seconds = (await self._lengths(user, scene, spot.floor, [spot.place], to))[0] / times.traveller.speed
            starts.append(RouteStart(floor, seconds[: len(places)], float(seconds[-1]) if same else math.inf))
        return starts

    async def _goal(self, user: str, scene: BuildingScene, times: BuildingTimes, spot: BuildingSpot) -> RouteEnd:
        [seconds] = await self._from_all(user, scene, times, [spot])
        return RouteEnd(times.network.number_of[spot.floor], seconds)

    async def _from_all(
        self, user: str, scene: BuildingScene, times: BuildingTimes, spots: Sequence[BuildingSpot]
    ) -> list[Matrix]:
        """Return the times between each place and the junctions of its floor, in either direction [s]."""
        found: dict[BuildingSpot, Matrix] = {}

        async def ask(floor: str) -> None:
            own = [spot for spot in dict.fromkeys(spots) if spot.floor == floor]
            part = times.network.parts[self._floor(scene, times, own[0])]
            to = [times.network.junctions[number].place for number in part]
            lengths = await self._lengths(user, scene, floor, [spot.place for spot in own], to)
            found.update(zip(own, lengths / times.traveller.speed, strict=True))

        await asyncio.gather(*(ask(floor) for floor in {spot.floor for spot in spots}))
        return [found[spot] for spot in spots]

    async def _direct(
        self, user: str, scene: BuildingScene, starts: Sequence[BuildingSpot], goals: Sequence[BuildingSpot]
    ) -> Matrix:
        """Return the lengths of the paths on one floor, through no door [m]; infinite between floors."""
        direct = np.full((len(starts), len(goals)), math.inf)

        async def ask(floor: str) -> None:
            rows, columns = _on(starts, floor), _on(goals, floor)
            places = [starts[row].place for row in rows], [goals[column].place for column in columns]
            direct[np.ix_(rows, columns)] = await self._lengths(user, scene, floor, *places)

        await asyncio.gather(*(ask(floor) for floor in {spot.floor for spot in starts} & {to.floor for to in goals}))
        return direct

    async def _lengths(
        self, user: str, scene: BuildingScene, floor: str, starts: Sequence[Place], goals: Sequence[Place]
    ) -> Matrix:
        """Return the (n, m) lengths of the paths on a floor whose doors are shut [m]; infinite without a path."""
        lengths = np.full((len(starts), len(goals)), math.inf)
        rows = max(1, MOST_AT_ONCE // max(len(goals), 1))
        for first in range(0, len(starts) if goals else 0, rows):
            part = tuple(starts[first : first + rows])
            request = CostRequest(
                part, tuple(goals), scene.timeout, dict(scene.labels), {**_on_floors(scene), "lengths": True}
            )
            answer = await self._planning.compute_costs(user, scene.maps[floor], request)
            found = from_json(answer.costs, list[list[float | None]])
            lengths[first : first + rows] = [[math.inf if each is None else each for each in row] for row in found]
        return lengths

    async def _path(self, user: str, scene: BuildingScene, leg: Leg) -> FloorPath | None:
        if leg.kind != "drive":
            return None
        request = PathRequest(
            leg.start, leg.goal, PLANNER, NEAR, scene.timeout, scene.reuse, dict(scene.labels),
            parameters=_on_floors(scene),
        )  # fmt: skip
        return FloorPath(request, *await self._planning.compute_path(user, scene.maps[leg.floor], request))

    def _floor(self, scene: BuildingScene, times: BuildingTimes, spot: BuildingSpot) -> int:
        scene.layout.building.floor(spot.floor)
        if spot.floor not in scene.maps:
            raise NoValidPath(f"floor {spot.floor!r} has no map that you may read")
        return times.network.number_of[spot.floor]


def _key(scene: BuildingScene, network: BuildingNetwork, floor: int) -> tuple[str, ...]:
    version = scene.maps[network.floors[floor]]
    places = [network.junctions[number].place for number in network.parts[floor]]
    given = msgspec.json.encode((_on_floors(scene), places), order="sorted").decode()
    return version.id, version.version, given


def _on(spots: Sequence[BuildingSpot], floor: str) -> list[int]:
    """Return the numbers of the places on a floor."""
    return [number for number, spot in enumerate(spots) if spot.floor == floor]


def _on_floors(scene: BuildingScene) -> dict[str, Any]:
    return {**scene.parameters, "shut_doors": True}


def _crossed(times: BuildingTimes, route: Route) -> list[int]:
    """Return the floors on which a route drives between two junctions."""
    chain, junctions = route.chain.junctions, times.network.junctions
    if route.start.landing >= 0:
        chain = (route.start.landing, *chain)
    pairs = pairwise(chain)
    return [junctions[one].floor for one, other in pairs if times.network.is_driven(one, other)]


def _no_route(scene: BuildingScene, start: BuildingSpot, goal: BuildingSpot) -> str:
    text = (
        f"no route leads from x={start.x:.3f} y={start.y:.3f} on floor {start.floor!r} to x={goal.x:.3f} "
        f"y={goal.y:.3f} on floor {goal.floor!r}: check that both places are free, and which lifts and ways this robot "
        "may take"
    )
    if scene.closed or scene.traveller.avoid:
        text += "; without the closed doors and the lifts to avoid there may be one"
    broken = sorted({lift for (lift, _), wait in scene.waits.items() if math.isinf(wait)})
    if broken:
        text += f"; lifts that do not serve robots now: {', '.join(broken)}"
    return text
