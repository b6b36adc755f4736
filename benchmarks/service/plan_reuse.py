"""Speed-up of stored plans over computed ones, on a large map.

Each planner gets the same request across the map: first without reuse, then with reuse allowed where it is expected
to be faster. Times are measured at the client, over a robot's WebSocket and over REST. Where criterion (a) prefers to
compute, as it is as fast, the request must not become slower.
"""

import asyncio
import contextlib
import json
import statistics
from collections import Counter
from collections.abc import Awaitable, Callable
from dataclasses import dataclass, field

import msgspec
from rich.progress import Progress
from websockets.asyncio.client import ClientConnection, connect

from benchmarks.harness.cloud_under_test import CloudUnderTest, own_cloud
from benchmarks.harness.figures import Figure, median_of
from benchmarks.harness.plan_calls import RestAsker, compute_path_call, ends
from ppaas.clock import monotonic
from ppaas.decoding import from_json
from ppaas.maps.generate import warehouse
from ppaas.maps.grid import GridMap

PART = "reuse"
MAP, ROBOT = "bench-reuse", "bench-reuser"
EDGE, QUICK_EDGE = 4096, 512
RESOLUTION = 0.05
SAMPLES, QUICK = 7, 3
PLANNERS = ("dijkstra", "navfn", "theta_star")
TIMES = 10.0
"""Smallest acceptable speed-up of a stored plan over a computed one."""

CORES = 1.0


class _Origin(msgspec.Struct):
    origin: str
    seconds: float = 0.0


class _Response(msgspec.Struct):
    values: _Origin


Ask = Callable[[bool], Awaitable[str]]
"""Sends one request, with or without reuse allowed; returns the origin of the plan."""


@dataclass(slots=True)
class _Taken:
    """Times of the answers [s], and origins of their plans."""

    computed: list[float] = field(default_factory=list)
    asked: list[float] = field(default_factory=list)
    origins: Counter[str] = field(default_factory=Counter)


async def measure(progress: Progress, quick: bool) -> list[Figure]:
    """Start a cloud, and measure each planner over WebSocket and REST."""
    edge = (QUICK_EDGE if quick else EDGE) * RESOLUTION
    grid = warehouse(seed=1, width=edge, height=edge, resolution=RESOLUTION)
    found: list[Figure] = []
    async with own_cloud() as target, contextlib.AsyncExitStack() as stack:
        ways = await _ways(target, grid, stack)
        for name, ask in progress.track(list(ways.items()), description="kept and computed plans"):
            found += _figures(name, await _sample(ask, QUICK if quick else SAMPLES))
    return found


async def _ways(target: CloudUnderTest, grid: GridMap, stack: contextlib.AsyncExitStack) -> dict[str, Ask]:
    start, goal = ends(grid)
    await target.publish(MAP, grid)
    url = await target.register(ROBOT, MAP, start, CORES)
    socket = await stack.enter_async_context(connect(f"{url}&role=operator", max_size=None, compression=None))
    ways: dict[str, Ask] = {}
    for planner in PLANNERS:
        ways[f"{planner}, REST"] = _by_rest(target, {"start": start, "goal": goal, "planner": planner, "timeout": 60})
        ways[f"{planner}, WebSocket"] = _by_socket(socket, compute_path_call(start, goal, planner=planner, timeout=60))
    return ways


def _by_rest(target: CloudUnderTest, body: dict[str, object]) -> Ask:
    def exchange(reuse: bool) -> bytes:
        # A new connection: the server would close one that is idle while the other way is measured.
        with contextlib.closing(RestAsker(target.url, target.token, f"/v1/maps/{MAP}/plans")) as rest:
            return rest.exchange(json.dumps(body | {"reuse": reuse}).encode())

    async def ask(reuse: bool) -> str:
        # In a thread, to keep the WebSocket alive meanwhile.
        return from_json(await asyncio.to_thread(exchange, reuse), _Origin).origin

    return ask


def _by_socket(socket: ClientConnection, frame: str) -> Ask:
    call = json.loads(frame)

    async def ask(reuse: bool) -> str:
        await socket.send(json.dumps(call | {"args": call["args"] | {"reuse": reuse}}))
        return from_json(await socket.recv(decode=False), _Response).values.origin

    return ask


async def _sample(ask: Ask, count: int) -> _Taken:
    taken = _Taken()
    await ask(False)  # warm-up: may compile kernels, or prepare the map
    for _ in range(count):
        began = monotonic()
        await ask(False)
        taken.computed.append(monotonic() - began)
    for _ in range(count):
        began = monotonic()
        taken.origins[await ask(True)] += 1
        taken.asked.append(monotonic() - began)
    return taken


def _figures(name: str, taken: _Taken) -> list[Figure]:
    origins = ", ".join(f"{count} {origin}" for origin, count in sorted(taken.origins.items()))
    figures = [
        median_of(PART, f"{name}, computed", taken.computed),
        median_of(PART, f"{name}, where a kept one will do", taken.asked, note=origins),
    ]
    if not taken.origins["computed"]:
        times = statistics.median(taken.computed) / statistics.median(taken.asked)
        figures.append(Figure(PART, f"{name}, sooner", round(times, 1), "×", limit=TIMES, floor=True))
    return figures
