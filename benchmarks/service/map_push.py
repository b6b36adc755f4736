"""Time to push a changed map to the robots that drive on it, and how much of the map is sent."""

import asyncio
import contextlib
import json
import math
import re
from collections.abc import AsyncIterator, Awaitable, Callable
from http import HTTPStatus

import numpy as np
from rich.progress import Progress
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import InvalidStatus

from benchmarks.harness.cloud_under_test import Target
from benchmarks.harness.figures import Figure, median_of
from ppaas.clock import monotonic
from ppaas.geometry import Pose2D
from ppaas.maps.grid import FREE, OCCUPIED, GridInfo, GridMap
from robots.client.rest_paths import path_of

PART = "push"
MAP = "bench-push"
SIDE, QUICK_SIDE = 8192, 1024
ROBOTS, QUICK_ROBOTS = 20, 3
RUNS, QUICK_RUNS = 10, 2
CHANGED = 200
"""Edge of the square that changes [cells]."""

SIDES = re.compile(rb'"(?:width|height)": ?([0-9]+)')
"""Sides of the rectangle in a message, which the bench does not decode: a robot does so on its own computer."""

LIMIT_MS = 200.0
SHARE_LIMIT = 1.0
"""Largest share of the map that is sent to a robot [% of a byte a cell]."""

READY_TIMEOUT = 240.0
"""Time limit for all robots to have containers [s]: the layers of a large map take some seconds."""


async def measure(target: Target, progress: Progress, quick: bool) -> list[Figure]:
    """Publish a version in which a square has changed, then go back and forth between both versions.

    The first time, the machine makes the layers of the version and compares the maps. Later they are in its cache, and
    what remains is the push: the request, the orders, the swap in each container, and the message to its robot.
    """
    side, robots, runs = (QUICK_SIDE, QUICK_ROBOTS, QUICK_RUNS) if quick else (SIDE, ROBOTS, RUNS)
    before, after = _grid(side, FREE), _grid(side, OCCUPIED)
    await target.publish(MAP, before)
    old = (await target.rest.get(path_of("maps", MAP)))["version"]
    seconds, sizes = [], []
    async with _robots(target, robots) as sockets:
        progress.console.log(f"{robots} robots are on a map of {side}²")
        first, _ = await _pushed(sockets, target.publish(MAP, after))
        new = (await target.rest.get(path_of("maps", MAP)))["version"]
        for run in progress.track(range(runs), description="pushing"):
            took, size = await _pushed(sockets, target.rest.roll_back_map(MAP, (old, new)[run % 2]))
            seconds.append(took)
            sizes.append(size)
    await _removed(target)
    share = 100.0 * max(sizes) / side**2
    what = f"{CHANGED}² of {side}² to {robots} robots"
    return [
        median_of(PART, what, seconds, limit=LIMIT_MS, note="from the request until the last robot has the change"),
        Figure(
            PART,
            "sent to a robot",
            round(share, 3),
            "%",
            limit=None if quick else SHARE_LIMIT,
            note=f"{max(sizes)} bytes of JSON",
        ),
        Figure(PART, "the first time", round(first, 2), "s", note="upload, check, layers and comparison included"),
    ]


def _grid(side: int, value: int) -> GridMap:
    """Return a hall with a square of one value, away from the robots and from round numbers."""
    cells = np.full((side, side), FREE, np.int8)
    cells[[0, -1]] = cells[:, [0, -1]] = OCCUPIED
    begin = side // 2 + 33
    cells[begin : begin + CHANGED, begin : begin + CHANGED] = value
    cells[begin, begin] = OCCUPIED  # so that both versions have an obstacle there
    return GridMap(cells, GridInfo(0.05, side, side, Pose2D(0.0, 0.0)))


@contextlib.asynccontextmanager
async def _robots(target: Target, count: int) -> AsyncIterator[list[ClientConnection]]:
    async with contextlib.AsyncExitStack() as stack:
        sockets = []
        for number in range(count):
            url = await target.register(f"push-{number}", MAP, (2.0 + number, 5.0, 0.0))
            socket = await stack.enter_async_context(await _connected(url))
            await socket.send(
                json.dumps({"op": "subscribe", "topic": "map_updates", "type": "map_msgs/OccupancyGridUpdate"})
            )
            sockets.append(socket)
        async with asyncio.timeout(READY_TIMEOUT):
            await _until(target, lambda ready: ready == count)
        yield sockets


async def _connected(url: str) -> ClientConnection:
    """Connect; try again while the layers are made for the first robot, which takes longer than a robot may wait."""
    async with asyncio.timeout(READY_TIMEOUT):
        while True:
            try:
                return await connect(url, max_size=None, open_timeout=READY_TIMEOUT)
            except InvalidStatus as refused:
                if refused.response.status_code != HTTPStatus.SERVICE_UNAVAILABLE:
                    raise
                await asyncio.sleep(1.0)


async def _until(target: Target, met: Callable[[int], bool]) -> None:
    """Wait until the number of robots on the map that have a container meets a condition."""
    while True:
        running = await target.rest.items("/v1/containers")
        if met(sum(one["state"] == "ready" and one["map"]["id"] == MAP for one in running)):
            return
        await asyncio.sleep(0.2)


async def _pushed(sockets: list[ClientConnection], change: Awaitable[object]) -> tuple[float, int]:
    """Change the map; return the time until the last robot has all changed cells [s], and the bytes sent to one."""
    receiving = [asyncio.create_task(_changes(socket)) for socket in sockets]
    began = monotonic()
    await change
    received = await asyncio.gather(*receiving)
    return max(at for at, _ in received) - began, max(size for _, size in received)


async def _changes(socket: ClientConnection) -> tuple[float, int]:
    """Return when all changed cells have arrived, and the size of their messages [bytes]."""
    cells, size = 0, 0
    while cells < CHANGED**2:
        frame = await socket.recv(decode=False)
        if b"map_updates" in frame[:200] or b"map_updates" in frame[-200:]:
            size += len(frame)
            cells += math.prod(int(found[1]) for found in SIDES.finditer(frame[:500]))
    return monotonic(), size


async def _removed(target: Target) -> None:
    """Remove the map once its robots have lost their containers."""
    await _until(target, lambda ready: ready == 0)
    await target.rest.delete(path_of("maps", MAP))
