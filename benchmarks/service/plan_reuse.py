"""How much sooner a plan that is kept reaches a robot than one that is computed, on a large map.

Each planner is asked for one way across the map: first to compute it every time, then to reuse what is kept where that
is expected to be sooner. All is measured where the path arrives: at the end of a robot's WebSocket, and of a REST
connection. Where criterion (a) refuses, because computing takes no longer, nothing may have become slower by it.
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

from benchmarks.harness.cloud_under_test import Target, own_cloud
from benchmarks.harness.figures import Figure, median_of
from benchmarks.harness.plan_calls import RestAsker, compute_path_call, ends
from ppaas.clock import monotonic
from ppaas.maps.generate import warehouse
from ppaas.maps.grid import GridMap

PART = "reuse"
MAP, ROBOT = "bench-reuse", "bench-reuser"
EDGE, QUICK_EDGE = 4096, 512
RESOLUTION = 0.05
SAMPLES, QUICK = 7, 3
PLANNERS = ("dijkstra", "navfn", "theta_star")
TIMES = 10.0
"""How many times sooner a kept plan must be there than one that is computed."""

CORES = 1.0


class _Origin(msgspec.Struct):
    origin: str
    seconds: float = 0.0


class _Response(msgspec.Struct):
    values: _Origin


Ask = Callable[[bool], Awaitable[str]]
"""Asks once, and returns where the plan came from; told whether a kept one will do."""


@dataclass(slots=True)
class _Taken:
    """Seconds that answers took, and where their plans came from."""

    computed: list[float] = field(default_factory=list)
    asked: list[float] = field(default_factory=list)
    origins: Counter[str] = field(default_factory=Counter)


async def measure(progress: Progress, quick: bool) -> list[Figure]:
    """Start a cloud, and ask each planner in each way."""
    edge = (QUICK_EDGE if quick else EDGE) * RESOLUTION
    grid = warehouse(seed=1, width=edge, height=edge, resolution=RESOLUTION)
    found: list[Figure] = []
    async with own_cloud() as target, contextlib.AsyncExitStack() as stack:
        ways = await _ways(target, grid, stack)
        for name, ask in progress.track(list(ways.items()), description="kept and computed plans"):
            found += _figures(name, await _sample(ask, QUICK if quick else SAMPLES))
    return found


async def _ways(target: Target, grid: GridMap, stack: contextlib.AsyncExitStack) -> dict[str, Ask]:
    start, goal = ends(grid)
    await target.publish(MAP, grid)
    url = await target.register(ROBOT, MAP, start, CORES)
    socket = await stack.enter_async_context(connect(f"{url}&role=operator", max_size=None, compression=None))
    ways: dict[str, Ask] = {}
    for planner in PLANNERS:
        ways[f"{planner}, REST"] = _by_rest(target, {"start": start, "goal": goal, "planner": planner, "timeout": 60})
        ways[f"{planner}, WebSocket"] = _by_socket(socket, compute_path_call(start, goal, planner=planner, timeout=60))
    return ways


def _by_rest(target: Target, body: dict[str, object]) -> Ask:
    def exchange(reuse: bool) -> bytes:
        # A connection of its own: one that waits while another way is measured is hung up on.
        with contextlib.closing(RestAsker(target.url, target.token, f"/v1/maps/{MAP}/plans")) as rest:
            return rest.exchange(json.dumps(body | {"reuse": reuse}).encode())

    async def ask(reuse: bool) -> str:
        # In a thread, so that the WebSocket beside it is kept alive.
        return msgspec.json.decode(await asyncio.to_thread(exchange, reuse), type=_Origin).origin

    return ask


def _by_socket(socket: ClientConnection, frame: str) -> Ask:
    call = json.loads(frame)

    async def ask(reuse: bool) -> str:
        await socket.send(json.dumps(call | {"args": call["args"] | {"reuse": reuse}}))
        return msgspec.json.decode(await socket.recv(decode=False), type=_Response).values.origin

    return ask


async def _sample(ask: Ask, count: int) -> _Taken:
    taken = _Taken()
    await ask(False)  # it may have compiled, or prepared the map
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
