"""Overhead of a path request over the wire beyond the planning time, compared with echo servers."""

import asyncio
import contextlib
import json
import sys
from collections.abc import AsyncIterator, Awaitable, Callable
from typing import NamedTuple

import msgspec
from rich.progress import Progress
from websockets.asyncio.client import ClientConnection, connect

from benchmarks.harness.cloud_under_test import CloudUnderTest
from benchmarks.harness.figures import Figure, median_of
from benchmarks.harness.plan_calls import RestAsker, compute_path_call, ends, make_plan_call
from benchmarks.service import echo_server
from ppaas.clock import monotonic
from ppaas.costmap.build_layers import build_layers
from ppaas.decoding import from_json
from ppaas.geometry import Pose2D
from ppaas.maps.generate import warehouse
from ppaas.maps.grid import GridMap
from ppaas.planners.base import PlanRequest
from ppaas.planners.grid.dijkstra import Dijkstra

PART = "plans"
MAP = "bench-plans"
ROBOT = "bench-asker"
REQUESTS, QUICK = 200, 20
WARM = 10
"""Number of warm-up requests."""

LIMIT_MS = 1.0

Ask = Callable[[], Awaitable[float]]
"""Sends one request; returns the time reported by the planner [s]."""


async def measure(target: CloudUnderTest, progress: Progress, quick: bool) -> list[Figure]:
    """Request the same path in all ways in turn, repeatedly."""
    grid = warehouse(seed=1)
    start, goal = ends(grid)
    await target.publish(MAP, grid)
    url = await target.register(ROBOT, MAP, start)
    async with contextlib.AsyncExitStack() as stack:
        socket = await stack.enter_async_context(connect(f"{url}&role=operator", max_size=None, compression=None))
        frame, exact = make_plan_call(start, goal), compute_path_call(start, goal)
        await socket.send(frame)
        answer = str(await socket.recv())
        poses = answer.count('"position"')
        body = json.dumps({"start": start, "goal": goal}).encode()
        rest = stack.enter_context(contextlib.closing(RestAsker(target.url, target.token, f"/v1/maps/{MAP}/plans")))
        rest_size = len(rest.exchange(body))
        plain = await stack.enter_async_context(echo("websockets", len(answer)))
        fast = await stack.enter_async_context(echo("fastapi", rest_size))
        plain_socket = await stack.enter_async_context(
            connect(f"ws://{plain.address}", max_size=None, compression=None)
        )
        fast_rest = stack.enter_context(contextlib.closing(RestAsker(f"http://{fast.address}", "none", "/")))
        ways: dict[str, Ask] = {
            "planner": in_process(grid, start, goal),
            "ws": lambda: _ask_socket(socket, frame),
            "rest": lambda: _ask_rest(rest, body),
            "ws exact": lambda: _ask_socket(socket, exact),  # not right after "ws", which would make it faster
            "ws echo": lambda: _ask_socket(plain_socket, frame),
            "rest echo": lambda: _ask_rest(fast_rest, body),
        }
        samples = await sample(ways, QUICK if quick else REQUESTS, progress)
    return figures(samples, poses, len(answer), rest_size)


async def sample(ways: dict[str, Ask], count: int, progress: Progress) -> dict[str, list[tuple[float, float]]]:
    """Return (total time, time of the planner) [s] of each way; they take turns to share the state of the machine."""
    samples: dict[str, list[tuple[float, float]]] = {name: [] for name in ways}
    for number in progress.track(range(count + WARM), description="plan requests"):
        for name, ask in ways.items():
            began = monotonic()
            planning = await ask()
            if number >= WARM:
                samples[name].append((monotonic() - began, planning))
    return samples


def figures(samples: dict[str, list[tuple[float, float]]], poses: int, ws_size: int, rest_size: int) -> list[Figure]:
    """Return the figures of the samples."""
    total = {name: [all_ for all_, _ in taken] for name, taken in samples.items()}
    rest_planner = [planning for _, planning in samples["rest"]]
    exact_more, rest_more = ([all_ - planning for all_, planning in samples[name]] for name in ("ws exact", "rest"))
    # make_plan reports no time, so the time of the same path by compute_path, requested soon after, is used.
    clone_planner = [planning for _, planning in samples["ws exact"]]
    ws_more = [seconds - planning for seconds, planning in zip(total["ws"], clone_planner, strict=True)]
    return [
        median_of(PART, "planner, called in this process", total["planner"], note=f"{poses} poses"),
        median_of(PART, "planner, in its container", rest_planner, note="by its own word"),
        median_of(PART, "WebSocket, beyond its planner's time", exact_more, limit=LIMIT_MS, note="compute_path"),
        median_of(PART, "WebSocket, beyond it, as ROS", ws_more, limit=LIMIT_MS, note=f"make_plan, {ws_size:,} bytes"),
        median_of(PART, "websockets, echo", total["ws echo"], yardstick=True, note="the same bytes"),
        median_of(PART, "REST, beyond its planner's time", rest_more, limit=LIMIT_MS, note=f"{rest_size:,} bytes"),
        median_of(PART, "FastAPI, echo", total["rest echo"], yardstick=True, note="the same bytes"),
    ]


# -- the ways ----------------------------------------------------------------------------------------------------------


def in_process(grid: GridMap, start: tuple[float, float, float], goal: tuple[float, float, float]) -> Ask:
    """Return a planner in this process, on the same costmap as in a container."""
    costmap, planner = build_layers(grid).costmap, Dijkstra()
    request = PlanRequest(Pose2D(*start), Pose2D(*goal))

    async def ask() -> float:
        return planner.plan(costmap, request).seconds

    return ask


async def _ask_socket(socket: ClientConnection, frame: str) -> float:
    await socket.send(frame)
    return _planner_seconds(await socket.recv(decode=False), _Response)


class _Planned(msgspec.Struct):
    seconds: float = 0.0


class _Response(msgspec.Struct):
    values: _Planned


def _planner_seconds(answer: bytes, kind: type[_Planned] | type[_Response]) -> float:
    """Return the planner's time in an answer plus the time to decode it here, which is not the cloud's [s]."""
    began = monotonic()
    if answer[:1] != b"{":
        return 0.0
    told = from_json(answer, kind)
    return (told.values if isinstance(told, _Response) else told).seconds + monotonic() - began


async def _ask_rest(asker: RestAsker, body: bytes) -> float:
    return _planner_seconds(asker.exchange(body), _Planned)


class EchoServer(NamedTuple):
    """An echo server: its host and port, and its process id."""

    address: str
    pid: int


@contextlib.asynccontextmanager
async def echo(kind: str, size: int) -> AsyncIterator[EchoServer]:
    """Run an echo server with answers of a size in its own process."""
    process = await asyncio.create_subprocess_exec(
        sys.executable, "-m", echo_server.__name__, kind, str(size),
        stdin=asyncio.subprocess.PIPE, stdout=asyncio.subprocess.PIPE,
    )  # fmt: skip
    assert process.stdin is not None and process.stdout is not None
    try:
        yield EchoServer(f"127.0.0.1:{int(await process.stdout.readline())}", process.pid)
    finally:
        process.stdin.close()
        await process.wait()
