"""Latency of a stop: from the REST call to zero at the robot, beside an echo of a frame of that size."""

import asyncio
import time

import msgspec
from rich.progress import Progress
from websockets.asyncio.client import ClientConnection

from benchmarks.engine.driving_robot import grid_to_drive_on
from benchmarks.harness.cloud_under_test import CORES, CloudUnderTest, own_cloud
from benchmarks.harness.figures import Figure, median_and_p99
from benchmarks.service.plan_requests import echo
from benchmarks.wire.site import MAP, START, opened
from robots.client.cloud_url import path_of

PART = "stop"
ROBOT = "bench-stop"
SAMPLES, QUICK = 100, 5
WARM = 5
"""Number of samples that are not counted."""

LIMIT = 50.0
"""Largest acceptable median from the call to the robot [ms]."""

SETTLED = 0.25
"""Time after a release in which velocities that were sent before it have arrived [s]."""


async def measure(progress: Progress, quick: bool) -> list[Figure]:
    """Stop and release a robot with a real clone, again and again."""
    async with own_cloud() as target:
        await target.publish(MAP, grid_to_drive_on())
        url = await target.register(ROBOT, MAP, (START.x, START.y, START.theta), CORES)
        async with opened(url) as [robot]:
            await robot.send('{"op":"subscribe","topic":"cmd_vel"}')
            times, size = [], 0
            for number in progress.track(range(WARM + (QUICK if quick else SAMPLES)), description=PART):
                taken, size = await _stop(target, robot)
                times += [taken] if number >= WARM else []
    return figures(times, await _echoed(size, len(times)), size)


async def _stop(target: CloudUnderTest, robot: ClientConnection) -> tuple[float, int]:
    """Stop the robot and release it; return the time until zero was there [s], and its size [bytes]."""
    began = time.perf_counter()
    order = asyncio.create_task(target.rest.post(path_of("robots", ROBOT, "stop"), {}))
    size = len(await robot.recv(decode=False))
    taken = time.perf_counter() - began
    await order
    await target.rest.post(path_of("robots", ROBOT, "release"), {})
    await _emptied(robot)
    return taken, size


async def _emptied(robot: ClientConnection) -> None:
    """Take the velocities that are still on their way."""
    while True:
        try:
            async with asyncio.timeout(SETTLED):
                await robot.recv(decode=False)
        except TimeoutError:
            return


async def _echoed(size: int, count: int) -> list[float]:
    """Return the times of exchanges of frames of a size [bytes] with an echo server [s]."""
    times = []
    async with echo("websockets", size) as server, opened(f"ws://{server.address}") as [plain]:
        for _ in range(count):
            began = time.perf_counter()
            await plain.send("x" * size)
            await plain.recv(decode=False)
            times.append(time.perf_counter() - began)
    return times


def figures(stops: list[float], echoes: list[float], size: int) -> list[Figure]:
    """Return the figures, from times until zero was at the robot, and of exchanges with an echo server [s]."""
    note = f"POST /v1/robots/ID/stop until cmd_vel of {size} bytes"
    plain = median_and_p99(PART, "websockets, echo", echoes, note="a frame of that size")
    median, p99 = median_and_p99(PART, "call to zero at the robot", stops, note=note)
    return [
        msgspec.structs.replace(median, limit=LIMIT),
        p99,
        *(msgspec.structs.replace(figure, yardstick=True) for figure in plain),
    ]
