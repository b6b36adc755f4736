"""CPU time of path requests by REST, beside a FastAPI server that answers with the same number of bytes.

Each request has another heading at its start, so each plan is new and is stored. Cloud and yardstick take the same
requests from the same clients, first from one and then from many at once.
"""

import contextlib
import itertools
import json
import math
import random
import statistics
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields

import cbor2
import msgspec
import psutil
from rich.progress import Progress

from benchmarks.harness.cloud_under_test import CloudUnderTest
from benchmarks.harness.figures import Figure
from benchmarks.harness.plan_calls import RouteRequests
from benchmarks.harness.process_usage import cpu_of, endpoint_of
from benchmarks.service.plan_requests import echo
from ppaas.clock import monotonic
from ppaas.costmap.build_layers import build_layers
from ppaas.decoding import from_json
from ppaas.errors import PlanningError
from ppaas.geometry import Pose2D
from ppaas.maps.generate import warehouse
from ppaas.maps.grid import GridMap
from ppaas.planners.base import PlanRequest
from ppaas.planners.grid.dijkstra import Dijkstra

PART = "load"
MAP = "bench-load"
SIDES = 64.0, 40.0
"""Sides of the warehouse [m]."""

SMALL, LONG = (105, 125), (925, 949)
"""Numbers of poses of small and of long plans, from and to."""

PAIRS = 16
"""Number of different starts and goals."""

CLIENTS = 64
ROUNDS = 3
"""Number of loads on the cloud and on the yardstick in turn."""

SECONDS, QUICK_SECONDS = 6.0, 0.6
"""Time of all loads of a kind on each, about [s]."""

TRIAL = 192
"""Number of requests that show how many a load has."""

PLANNED = 2
"""Number of times that each path is planned without a cloud after each load."""

SMALL_LIMIT, LONG_LIMIT, ENDPOINT_LIMIT, RATE_LIMIT = 3.0, 4.0, 2.0, 3000.0
"""Bars: CPU time beside the echo, and plans a second."""

Body = dict[str, object]


class _Answer(msgspec.Struct):
    pid: int


@dataclass(frozen=True, slots=True)
class Costs:
    """CPU time of a request [ms], and the rate of requests [1/s].

    Parameters
    ----------
    whole, endpoint, container : float
        Of all processes, of the endpoint, and of the container that plans.
    rate : float
        Requests a second.
    size : int
        Size of an answer [bytes].
    """

    whole: float
    endpoint: float
    container: float
    rate: float
    size: float


@dataclass(frozen=True, slots=True)
class Way:
    """A kind of request.

    Parameters
    ----------
    name, route : str
        Name of the figures, and path of the route.
    bodies : callable
        Returns bodies without end.
    planning : callable, optional
        Returns the CPU time of the planner for one of them, in this process and without a cloud [ms].
    whole, endpoint, rate : float, optional
        Bars: CPU time of all processes and of the endpoint beside the echo, and requests a second from many clients.
    accept : str
        Media type of the answers.
    clients : tuple of int
        Numbers of clients of the loads, one after the other.
    """

    name: str
    route: str
    bodies: Callable[[], Iterator[Body]]
    planning: Callable[[], float] | None = None
    whole: float | None = None
    endpoint: float | None = None
    rate: float | None = None
    accept: str = "*/*"
    clients: tuple[int, ...] = (CLIENTS,)


async def measure(target: CloudUnderTest, progress: Progress, quick: bool) -> list[Figure]:
    """Put the same loads on the cloud and on the yardstick; measures nothing of a cloud that already runs."""
    found = list[Figure]()
    if target.pid is None:
        return found
    grid = warehouse(seed=1, width=SIDES[0], height=SIDES[1])
    await target.publish(MAP, grid)
    for way in progress.track(ways_of(grid), description="load of plans"):
        for clients in way.clients:
            found += await _measure(target, way, clients, QUICK_SECONDS if quick else SECONDS)
    return found


async def _measure(target: CloudUnderTest, way: Way, clients: int, seconds: float) -> list[Figure]:
    assert target.pid is not None
    serving = [endpoint_of(target.pid), psutil.Process(target.pid)]
    cloud = _Load(f"{target.url}{way.route}", target.token, way, serving)
    size = round((await _loaded(cloud, clients, seconds / ROUNDS)).size)  # to warm up
    taken, planning = list[tuple[Costs, Costs]](), list[float]()
    async with echo("fastapi", size) as server:
        plain = _Load(f"http://{server.address}/", "none", way, [psutil.Process(server.pid)])
        await _loaded(plain, clients, seconds / ROUNDS)
        for _ in range(ROUNDS):
            one = await _loaded(cloud, clients, seconds / ROUNDS)
            taken.append((one, await _loaded(plain, clients, seconds / ROUNDS)))
            planning += [] if way.planning is None else [way.planning()]
    served, echoed = (_mean([pair[which] for pair in taken]) for which in (0, 1))
    return figures(way, clients, served, echoed, statistics.mean(planning) if planning else None)


def _mean(costs: list[Costs]) -> Costs:
    return Costs(
        **{field.name: statistics.mean(getattr(each, field.name) for each in costs) for field in fields(Costs)}
    )


def figures(way: Way, clients: int, cloud: Costs, plain: Costs, planning: float | None) -> list[Figure]:
    """Return the figures of a kind of request: CPU times, and these beside the echo of the same bytes.

    ``planning`` is the CPU time of the planner without a cloud [ms], if it is known.
    """
    name = f"{way.name}, {clients} client{'s' * (clients > 1)}"
    parts = f"endpoint {cloud.endpoint:.2f}, container {cloud.container:.2f}; {cloud.size:,.0f} bytes"
    ratio = cloud.whole / plain.whole
    made = [
        Figure(PART, f"{name}: CPU time", round(cloud.whole, 3), "ms", note=parts),
        Figure(PART, f"{name}: FastAPI, echo", round(plain.whole, 3), "ms", yardstick=True, note="the same bytes"),
        Figure(PART, f"{name}: beside it", round(ratio, 2), "x", limit=way.whole, note="all processes, with planning"),
        Figure(PART, f"{name}: endpoint beside it", round(cloud.endpoint / plain.whole, 2), "x", limit=way.endpoint),
    ]
    if planning is not None:
        ratio, note = (cloud.whole - planning) / plain.whole, f"planning alone, in this process: {planning:.2f} ms"
        made.append(Figure(PART, f"{name}: beside it, beyond planning", round(ratio, 2), "x", note=note))
    if clients > 1:
        rate, note = round(cloud.rate), f"echo {plain.rate:,.0f}; the clients share the cores"
        made.append(Figure(PART, f"{name}: rate", rate, "/s", limit=way.rate, floor=True, note=note))
    return made


# -- loads -------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class _Load:
    """Where requests go, and the processes that serve them: the endpoint, and all whose children count too."""

    url: str
    token: str
    way: Way
    processes: list[psutil.Process]

    async def send(self, count: int, clients: int) -> RouteRequests:
        bodies = (json.dumps(body).encode() for body in itertools.islice(self.way.bodies(), count))
        requests = RouteRequests(self.url, self.token, bodies, {"Accept": self.way.accept})
        await requests.run(clients)
        return requests


async def _loaded(load: _Load, clients: int, seconds: float) -> Costs:
    """Return the costs of a load that takes some seconds, after a shorter one that shows their number."""
    began = monotonic()
    answer = (await load.send(TRIAL, clients)).answers[-1]
    count = max(round(TRIAL * seconds / (monotonic() - began)), TRIAL)
    every = [child for each in load.processes for child in each.children(recursive=True)]
    processes = {each.pid: each for each in (*load.processes, *every)}
    before, began = {pid: cpu_of(each) for pid, each in processes.items()}, monotonic()
    requests = await load.send(count, clients)
    wall = monotonic() - began
    used = {pid: (cpu_of(each) - before[pid]) * 1e3 / count for pid, each in processes.items()}
    planner = used.get(_pid_in(answer), 0.0)
    return Costs(sum(used.values()), used[load.processes[0].pid], planner, count / wall, requests.size / count)


def _pid_in(answer: bytes) -> int:
    """Return the process id of the container that made an answer; 0 if there is none."""
    if answer[:1] == b"{":
        return from_json(answer, _Answer).pid
    found: int = cbor2.loads(answer)["pid"] if answer[:1] != b"[" else 0
    return found


# -- requests ----------------------------------------------------------------------------------------------------------


def ways_of(grid: GridMap) -> list[Way]:
    """Return the kinds of requests: small and long plans, and requests for many paths at once."""
    small, long = pairs_of(grid, *SMALL), pairs_of(grid, *LONG)
    one, other = planning_time(grid, small), planning_time(grid, long)
    plans = f"/v1/maps/{MAP}/plans"
    return [
        Way("small plans", plans, lambda: _paths(small), one, SMALL_LIMIT, rate=RATE_LIMIT, clients=(1, CLIENTS)),
        Way("long plans", plans, lambda: _paths(long), other, LONG_LIMIT, ENDPOINT_LIMIT, clients=(1, CLIENTS)),
        Way("long plans as CBOR", plans, lambda: _paths(long), other, accept="application/cbor"),
        Way("long plans as polylines", f"{plans}?poses=polyline", lambda: _paths(long), other),
        Way("cost matrices, 4 by 4", f"/v1/maps/{MAP}/cost_matrix", lambda: _matrices(small[:4])),
    ]


def planning_time(grid: GridMap, pairs: "list[Pair]") -> Callable[[], float]:
    """Return a function that plans each path in this process, and returns the CPU time for one [ms]."""
    costmap, planner = build_layers(grid).costmap, Dijkstra()
    requests = [PlanRequest(Pose2D(*start, 0.0), Pose2D(*goal, 0.5)) for start, goal in pairs]

    def measured() -> float:
        began = time.process_time()
        for _ in range(PLANNED):
            for request in requests:
                planner.plan(costmap, request)
        return (time.process_time() - began) * 1e3 / (PLANNED * len(requests))

    measured()  # to warm up
    return measured


Pair = tuple[tuple[float, float], tuple[float, float]]


def pairs_of(grid: GridMap, least: int, most: int) -> list[Pair]:
    """Return starts and goals [m] between which plans have so many poses."""
    costmap, planner, chance, found = build_layers(grid).costmap, Dijkstra(), random.Random(1), list[Pair]()
    while len(found) < PAIRS:
        distance, angle = chance.uniform(0.75, 0.95) * most * grid.info.resolution, chance.uniform(-math.pi, math.pi)
        start = chance.uniform(0.5, SIDES[0] - 0.5), chance.uniform(0.5, SIDES[1] - 0.5)
        goal = start[0] + distance * math.cos(angle), start[1] + distance * math.sin(angle)
        with contextlib.suppress(PlanningError):
            result = planner.plan(costmap, PlanRequest(Pose2D(*start, 0.0), Pose2D(*goal, 0.0)))
            if least <= len(result.poses) <= most:
                found.append((start, goal))
    return found


def _paths(pairs: list[Pair]) -> Iterator[Body]:
    """Yield path requests; each has another heading, so that its plan is a new one."""
    for start, goal in itertools.cycle(pairs):
        yield {"start": [*start, round(random.uniform(-3.1, 3.1), 9)], "goal": [*goal, 0.5], "reuse": False}


def _matrices(pairs: list[Pair]) -> Iterator[Body]:
    starts, goals = ([list(pair[which]) for pair in pairs] for which in (0, 1))
    while True:
        yield {"starts": starts, "goals": goals}
