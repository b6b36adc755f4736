"""Times to publish and fetch a large map over REST, and to push a changed one to the robots that drive on it."""

import asyncio
import contextlib
import json
import math
import os
import re
import shutil
import statistics
import tempfile
from collections.abc import AsyncIterator, Awaitable, Callable, Sequence
from http import HTTPStatus
from pathlib import Path

import numpy as np
from rich.progress import Progress
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import InvalidStatus

from benchmarks.harness.cloud_under_test import CloudUnderTest
from benchmarks.harness.figures import Figure, median_of
from ppaas.clock import monotonic
from ppaas.geometry import Pose2D
from ppaas.maps.grid import FREE, OCCUPIED, GridInfo, GridMap
from robots.client.cloud_url import path_of

MAPS = "maps"
SIDE, QUICK_SIDE = 8192, 1024
PUBLICATIONS, QUICK_PUBLICATIONS = 7, 2
RATIO_LIMIT = 2.0
YAML = b"image: map.pgm\nresolution: 0.05\norigin: [0, 0, 0]\n"
LARGE_MAP = "bench-large"


async def measure_publishing(target: CloudUnderTest, progress: Progress, quick: bool) -> list[Figure]:
    """Copy the file and publish it in turns, each time with other cells, so that the cloud must store it."""
    side = QUICK_SIDE if quick else SIDE
    copied, synced, published, fetched = [], [], [], []
    with tempfile.TemporaryDirectory(prefix="ppaas-bench-") as name:
        folder = Path(name)
        image = folder / "map.pgm"
        for run in progress.track(
            range(QUICK_PUBLICATIONS if quick else PUBLICATIONS), description=f"a map of {side}²"
        ):
            await asyncio.to_thread(_write, image, side, run)
            copied.append(await asyncio.to_thread(_copy, image, folder / f"copy-{run}", sync=False))
            synced.append(await asyncio.to_thread(_copy, image, folder / f"synced-{run}", sync=True))
            await asyncio.to_thread(os.sync)
            began = monotonic()
            await target.rest.upload_map(LARGE_MAP, YAML, image)
            published.append(monotonic() - began)
            began = monotonic()
            await target.rest.fetch_to(path_of("maps", LARGE_MAP, "image"), folder / "fetched")
            fetched.append(monotonic() - began)
    await target.rest.delete(path_of("maps", LARGE_MAP))
    return _figures(side, copied, synced, published, fetched)


def _figures(side: int, *samples: Sequence[float]) -> list[Figure]:
    copied, synced, published, fetched = samples
    ratios = [ours / copy for ours, copy in zip(published, synced, strict=True)]
    ratio = statistics.median(ratios)
    return [
        median_of(MAPS, f"publish {side}²", published, note="over REST: sent, hashed, checked, synced"),
        median_of(MAPS, f"fetch {side}²", fetched, note="over REST: proved to be what was published"),
        median_of(MAPS, "copy the file", copied, yardstick=True, note="into the page cache"),
        median_of(MAPS, "copy the file, synced", synced, yardstick=True, note="as lasting as a map that is published"),
        Figure(
            MAPS,
            "publish over copy, synced",
            round(ratio, 2),
            "×",
            round(min(ratios), 2),
            round(max(ratios), 2),
            RATIO_LIMIT,
            note="run by run",
        ),
    ]


def _write(path: Path, side: int, run: int) -> None:
    row = bytes([run]) + b"\xfe" * (side - 1)
    with path.open("wb") as file:
        file.write(b"P5\n%d %d\n255\n" % (side, side))
        for _ in range(side):
            file.write(row)


def _copy(source: Path, target: Path, *, sync: bool) -> float:
    """Copy a file to a new one, as a new map version is written; return the time [s]."""
    os.sync()  # exclude earlier writes of other processes
    began = monotonic()
    shutil.copyfile(source, target)
    if sync:
        with target.open("rb") as file:
            os.fsync(file.fileno())
    return monotonic() - began


# -- time to push a changed map to the robots that drive on it, and how much of the map is sent ------------------------

PUSH = "push"
PUSHED_MAP = "bench-push"
ROBOTS, QUICK_ROBOTS = 20, 3
PUSHES, QUICK_PUSHES = 10, 2
CHANGED = 200
"""Edge of the square that changes [cells]."""

SIDES = re.compile(rb'"(?:width|height)": ?([0-9]+)')
"""Sides of the rectangle in a message, which the bench does not decode: a robot does so on its own computer."""

LIMIT_MS = 200.0
SHARE_LIMIT = 1.0
"""Largest share of the map that is sent to a robot [% of a byte a cell]."""

READY_TIMEOUT = 240.0
"""Time limit for all robots to have containers [s]: the layers of a large map take some seconds."""


async def measure_push(target: CloudUnderTest, progress: Progress, quick: bool) -> list[Figure]:
    """Publish a version in which a square has changed, then go back and forth between both versions.

    The first time, the machine makes the layers of the version and compares the maps. Later they are in its cache, and
    what remains is the push: the request, the orders, the swap in each container, and the message to its robot.
    """
    side, robots, runs = (QUICK_SIDE, QUICK_ROBOTS, QUICK_PUSHES) if quick else (SIDE, ROBOTS, PUSHES)
    before, after = _grid(side, FREE), _grid(side, OCCUPIED)
    await target.publish(PUSHED_MAP, before)
    old = (await target.rest.get(path_of("maps", PUSHED_MAP)))["version"]
    seconds, sizes = [], []
    async with _robots(target, robots) as sockets:
        progress.console.log(f"{robots} robots are on a map of {side}²")
        first, _ = await _pushed(sockets, target.publish(PUSHED_MAP, after))
        new = (await target.rest.get(path_of("maps", PUSHED_MAP)))["version"]
        for run in progress.track(range(runs), description="pushing"):
            took, size = await _pushed(sockets, target.rest.roll_back_map(PUSHED_MAP, (old, new)[run % 2]))
            seconds.append(took)
            sizes.append(size)
    await _removed(target)
    share = 100.0 * max(sizes) / side**2
    what = f"{CHANGED}² of {side}² to {robots} robots"
    return [
        median_of(PUSH, what, seconds, limit=LIMIT_MS, note="from the request until the last robot has the change"),
        Figure(
            PUSH,
            "sent to a robot",
            round(share, 3),
            "%",
            limit=None if quick else SHARE_LIMIT,
            note=f"{max(sizes)} bytes of JSON",
        ),
        Figure(PUSH, "the first time", round(first, 2), "s", note="upload, check, layers and comparison included"),
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
async def _robots(target: CloudUnderTest, count: int) -> AsyncIterator[list[ClientConnection]]:
    async with contextlib.AsyncExitStack() as stack:
        sockets = []
        for number in range(count):
            url = await target.register(f"push-{number}", PUSHED_MAP, (2.0 + number, 5.0, 0.0))
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


async def _until(target: CloudUnderTest, met: Callable[[int], bool]) -> None:
    """Wait until the number of robots on the map that have a container meets a condition."""
    while True:
        running = await target.rest.items("/v1/containers")
        if met(sum(one["state"] == "ready" and one["map"]["id"] == PUSHED_MAP for one in running)):
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


async def _removed(target: CloudUnderTest) -> None:
    """Remove the map once its robots have lost their containers."""
    await _until(target, lambda ready: ready == 0)
    await target.rest.delete(path_of("maps", PUSHED_MAP))
