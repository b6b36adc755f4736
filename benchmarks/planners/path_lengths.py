"""Planning time over path length, on one thread and on several: Fig. 3 of the paper on PPaaS.

In the paper, the curve of several threads is timed from the request to the answer of a container with as many cores, so
this bench also requests paths from a container over its robot's WebSocket.
"""

import contextlib
from collections.abc import Awaitable, Callable, Sequence
from dataclasses import dataclass
from typing import Any

import msgspec
import numpy as np
from rich.progress import Progress
from websockets.asyncio.client import ClientConnection, connect

from benchmarks.harness.cloud_under_test import own_cloud
from benchmarks.harness.plan_calls import compute_path_call
from benchmarks.planners.field import farthest, grow
from benchmarks.planners.grids import goal_in
from benchmarks.planners.timing import RUNS, cpus, on_threads
from ppaas.clock import monotonic
from ppaas.costmap.build_layers import build_layers
from ppaas.costmap.costmap import Costmap
from ppaas.decoding import from_json
from ppaas.errors import Unavailable
from ppaas.geometry import Pose2D
from ppaas.maps.generate import warehouse
from ppaas.maps.grid import GridMap
from ppaas.planners import create, planner_names
from ppaas.planners.base import PlanRequest
from ppaas.planners.path import path_length, path_poses
from robots.pictures.line_chart import Axis, Line

MAP, ROBOT = "bench-lengths", "bench-lengths"
POINTS = 12
"""Number of path lengths."""
PLANNER, BASELINE = "dijkstra", "navfn"
"""Our planner, and ROS's planner, with which the paper compares."""

Pose = tuple[float, float, float]
Ask = Callable[[Pose, Pose], Awaitable[float]]
"""Requests a path; returns its time [s]."""


@dataclass(frozen=True, slots=True)
class PathQuestion:
    """Start and goal of a path, and its length [m]."""

    start: Pose
    goal: Pose
    length: float


class _Response(msgspec.Struct):
    values: msgspec.Raw = msgspec.Raw()
    result: bool = True


def default_map() -> GridMap:
    """Return a generated warehouse of 120 m by 80 m: 3.8 million cells."""
    return warehouse(seed=1, width=120.0, height=80.0)


def questions(costmap: Costmap, points: int = POINTS) -> list[PathQuestion]:
    """Return paths to one goal with evenly increasing lengths, up to nearly the longest on the map."""
    edge = farthest(grow(costmap, goal_in(costmap), cpus()))
    field = grow(costmap, edge, cpus())
    cells = field.path_from(farthest(field))
    asked = []
    for share in np.linspace(1.0 - 1.0 / points, 0.0, points):
        way = cells[round(share * (len(cells) - 1)) :]
        start, end = (tuple(costmap.info.to_world(cell).tolist()) for cell in (way[0], way[-1]))
        length = path_length(path_poses(costmap, way, Pose2D(*start), Pose2D(*end)))
        asked.append(PathQuestion((*start, 0.0), (*end, 0.0), length))
    return asked


def local(costmap: Costmap, planner: str, threads: int) -> Ask:
    """Return a planner in this process."""
    chosen = create(planner)

    async def ask(start: Pose, goal: Pose) -> float:
        request = PlanRequest(Pose2D(*start), Pose2D(*goal), threads=threads)
        began = monotonic()
        chosen.plan(costmap, request)
        return monotonic() - began

    return ask


def local_ways(costmap: Costmap, threads: Sequence[int]) -> dict[str, Ask]:
    """Return our planner in this process for each number of threads, by the name of its curve."""
    return {f"{PLANNER}, {on_threads(n)}": local(costmap, PLANNER, n) for n in threads}


def remote(socket: ClientConnection) -> Ask:
    """Return a client of a robot's container, timed from the request to the answer."""

    async def ask(start: Pose, goal: Pose) -> float:
        frame = compute_path_call(start, goal)
        began = monotonic()
        await socket.send(frame)
        answer = await socket.recv(decode=False)
        seconds = monotonic() - began
        told = from_json(answer, _Response)
        if not told.result:
            raise Unavailable(f"the container computed no path: {bytes(told.values).decode()}")
        return seconds

    return ask


async def measure(grid: GridMap, cores: int, progress: Progress, points: int = POINTS) -> dict[str, Any]:
    """Request the same paths from all in turn; the minimum of several runs counts.

    Parameters
    ----------
    grid : GridMap
        Map, published in a cloud that the bench starts.
    cores : int
        Size of the robot's container, which plans on as many threads.
    progress : Progress
    points : int
        Number of path lengths.

    Returns
    -------
    dict
        ``length_m`` of the paths, and ``seconds`` by curve, one number for each path.

    Raises
    ------
    PPaaSError
        The cloud does not start, or computes no path.
    """
    costmap = build_layers(grid).costmap
    costmap.data.setflags(write=False)
    asked = questions(costmap, points)
    async with contextlib.AsyncExitStack() as stack:
        target = await stack.enter_async_context(own_cloud())
        await target.publish(MAP, grid)
        url = await target.register(ROBOT, MAP, asked[0].start, float(cores))
        socket = await stack.enter_async_context(connect(f"{url}&role=operator", max_size=None, compression=None))
        ways = local_ways(costmap, sorted({1, cores}))
        ways[f"{PLANNER}, container of {cores} cores, request to answer"] = remote(socket)
        if BASELINE in planner_names():
            ways[f"{BASELINE}, 1 thread"] = local(costmap, BASELINE, 1)
        return await _sample(ways, asked, costmap, progress)


async def measure_locally(costmap: Costmap, threads: Sequence[int], progress: Progress) -> dict[str, Any]:
    """Measure only this process, with each number of threads; return the result of ``measure``."""
    return await _sample(local_ways(costmap, threads), questions(costmap), costmap, progress)


async def _sample(
    ways: dict[str, Ask], asked: Sequence[PathQuestion], costmap: Costmap, progress: Progress
) -> dict[str, Any]:
    seconds = {name: [float("inf")] * len(asked) for name in ways}
    for run in progress.track(range(-1, RUNS), description="paths, longer and longer"):
        for number, question in enumerate(asked):
            for name, ask in ways.items():
                taken = await ask(question.start, question.goal)
                if run >= 0:  # the first run is a warm-up
                    seconds[name][number] = min(seconds[name][number], taken)
    return {
        "cells": costmap.data.size,
        "length_m": [question.length for question in asked],
        "seconds": seconds,
        "cpus": cpus(),
    }


def chart(told: dict[str, Any]) -> tuple[str, list[Line], Axis, Axis]:
    """Return title, lines and axes of the chart."""
    lines = [
        Line(name, [(length, 1e3 * one) for length, one in zip(told["length_m"], seconds, strict=True)])
        for name, seconds in told["seconds"].items()
    ]
    title = f"Planning time over path length, on a map of {told['cells']:,} cells"
    return title, lines, Axis("path length [m]"), Axis("planning time [ms], logarithmic", logarithmic=True)
