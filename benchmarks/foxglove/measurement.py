"""CPU time of the endpoint of a cloud whose robots stand and publish, with and without a viewer.

Each robot publishes a scan of 360 beams and odometry at 10 Hz; its clone answers with its pose and transforms. The
viewer is a process of its own. The baseline is the server of ``foxglove-sdk``, which publishes as many channels.
"""

import asyncio
import contextlib
import subprocess
import sys
from collections.abc import AsyncIterator
from typing import TYPE_CHECKING

import psutil

from benchmarks.engine.talking_robot import TalkingRobot, talking_robot
from benchmarks.foxglove import sdk_server, viewer_process
from benchmarks.foxglove.viewer_process import TOPICS
from benchmarks.harness.cloud_under_test import LINGER, CloudUnderTest, logged_in
from benchmarks.harness.figures import Figure
from benchmarks.harness.free_ports import free_ports
from benchmarks.harness.json_process import JsonProcess, json_process
from benchmarks.harness.process_usage import endpoint_of, share_of_core
from ppaas.clock import monotonic
from ppaas.errors import Unavailable
from ppaas.geometry import Pose2D
from ppaas.maps.generate import office
from robots.demo.cloud_process import CloudProcess

if TYPE_CHECKING:
    from rich.progress import Progress

RATE = 10.0
"""Scans of a robot [Hz]."""

SECONDS, QUICK_SECONDS = 10.0, 2.0
"""Time for which CPU time is counted in each state [s]."""

SETTLING = 2.0
"""Time between a change and the count [s]: the first viewer makes the cloud read the definitions of its types."""

MOST_CPU, MOST_IDLE = 10.0, 1.0
"""Limits of the share of a core with a viewer that looks, and with one that does not [%]."""

MAP, PART = "bench-foxglove", "foxglove"


async def measure(progress: "Progress", robots: int, *, quick: bool) -> list[Figure]:
    """Return all figures."""
    seconds = QUICK_SECONDS if quick else SECONDS
    [port] = free_ports(1)
    arguments = ("--linger", str(LINGER), "--foxglove", str(port))
    async with CloudProcess(arguments=arguments) as cloud:
        target = await logged_in(cloud)
        async with _standing(progress, target, robots) as talking:
            figures = await _of_cloud(target, port, robots, seconds, talking)
    return [*figures, await _of_sdk(robots, seconds)]


async def _of_cloud(
    target: CloudUnderTest, port: int, robots: int, seconds: float, talking: asyncio.Event
) -> list[Figure]:
    """Return the figures: of a viewer that looks at nothing beside silent robots, and of one that looks."""
    assert target.pid is not None
    web, url = endpoint_of(target.pid), f"ws://127.0.0.1:{port}/?token={target.token}"
    silent = await share_of_core(web, seconds)
    async with _viewer(url, robots):
        await asyncio.sleep(2.0 * SETTLING)
        idle = await share_of_core(web, seconds) - silent
    talking.set()
    await asyncio.sleep(SETTLING)
    before = await share_of_core(web, seconds)
    async with _viewer(url, robots) as viewer:
        await viewer.ask("subscribe")
        await asyncio.sleep(SETTLING)
        await viewer.ask("count")
        looking = await share_of_core(web, seconds)
        rate = await viewer.ask("count") / seconds
    alone = (before + await share_of_core(web, seconds)) / 2.0
    note = f"{robots} robots, {rate:.0f} messages/s: {', '.join(TOPICS)}"
    return [
        Figure(PART, "endpoint without a viewer", round(alone, 2), "%", note="share of a core, before and after"),
        Figure(PART, "a viewer that looks", round(looking - alone, 2), "%", limit=MOST_CPU, note=note),
        Figure(PART, "time for each message", round(1e4 * (looking - alone) / rate, 1), "µs"),
        Figure(PART, "a viewer that looks at nothing", round(idle, 2), "%", limit=MOST_IDLE, note="silent robots"),
    ]


async def _of_sdk(robots: int, seconds: float) -> Figure:
    [port] = free_ports(1)
    command = [sys.executable, "-m", sdk_server.__name__, str(port), str(robots), str(RATE)]
    server = await asyncio.to_thread(subprocess.Popen, command, stderr=subprocess.DEVNULL)
    try:
        await _listening(port)
        async with _viewer(f"ws://127.0.0.1:{port}/", robots) as viewer:
            await viewer.ask("subscribe")
            await asyncio.sleep(1.0)
            await viewer.ask("count")
            share = await share_of_core(psutil.Process(server.pid), seconds)
            rate = await viewer.ask("count") / seconds
    finally:
        server.terminate()
        await asyncio.to_thread(server.wait)
    note = f"{rate:.0f} messages/s, which it need not decode"
    return Figure(PART, "server of foxglove-sdk", round(share, 2), "%", yardstick=True, note=note)


@contextlib.asynccontextmanager
async def _viewer(url: str, robots: int) -> AsyncIterator[JsonProcess]:
    async with json_process(viewer_process, url, str(robots * len(TOPICS))) as viewer:
        await viewer.hear()
        yield viewer


@contextlib.asynccontextmanager
async def _standing(progress: "Progress", target: CloudUnderTest, robots: int) -> AsyncIterator[asyncio.Event]:
    """Let robots stand, and publish once the event is set."""
    grid = office(seed=1, width=12.0, height=10.0)
    await target.publish(MAP, grid)
    async with contextlib.AsyncExitStack() as stack:
        talking, tasks = asyncio.Event(), []
        for number in progress.track(range(robots), description="robots"):
            start = Pose2D(1.0, 1.0, 0.0)
            robot = await stack.enter_async_context(talking_robot(target, f"bench{number}", MAP, grid, start))
            tasks.append(asyncio.create_task(_talk(robot, talking)))
        try:
            yield talking
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)


async def _talk(robot: TalkingRobot, talking: asyncio.Event) -> None:
    await talking.wait()
    due = monotonic()
    while True:
        with contextlib.suppress(Unavailable):  # a clone that is late publishes its pose with the next scan
            await robot.say()
        due = max(due + 1.0 / RATE, monotonic() - 1.0 / RATE)
        await asyncio.sleep(due - monotonic())


async def _listening(port: int) -> None:
    async with asyncio.timeout(20.0):
        while True:
            with contextlib.suppress(OSError):
                _, writer = await asyncio.open_connection("127.0.0.1", port)
                writer.close()
                return
            await asyncio.sleep(0.05)
