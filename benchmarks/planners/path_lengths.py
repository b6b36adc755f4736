"""Time over length of the path, one thread against many: Fig. 3 of the paper on PPaaS.

There the curve of many threads is timed from the request to the answer, through a container of as many cores. So here
a container is asked over its robot's WebSocket.
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
PLANNER, BASELINE = "dijkstra", "navfn"
"""Whose curves there are: ours, and ROS's planner, which the paper compares with."""

Pose = tuple[float, float, float]
Ask = Callable[[Pose, Pose], Awaitable[float]]
"""Asks for a path; returns the seconds that it took."""


@dataclass(frozen=True, slots=True)
class PathQuestion:
    """Where a path begins and ends, and how long it is [m]."""

    start: Pose
    goal: Pose
    length: float


class _Response(msgspec.Struct):
    values: msgspec.Raw = msgspec.Raw()
    result: bool = True


def default_map() -> GridMap:
    """Return a warehouse of 120 m by 80 m, made up: 3.8 million cells."""
    return warehouse(seed=1, width=120.0, height=80.0)


def questions(costmap: Costmap, points: int = POINTS) -> list[PathQuestion]:
    """Return paths to one goal that are longer and longer, in equal steps, up to nearly the longest there is."""
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
    """Return what plans in this process."""
    chosen = create(planner)

    async def ask(start: Pose, goal: Pose) -> float:
        request = PlanRequest(Pose2D(*start), Pose2D(*goal), threads=threads)
        began = monotonic()
        chosen.plan(costmap, request)
        return monotonic() - began

    return ask


def local_ways(costmap: Costmap, threads: Sequence[int]) -> dict[str, Ask]:
    """Return our planner in this process by its curve, one for each number of threads."""
    return {f"{PLANNER}, {on_threads(n)}": local(costmap, PLANNER, n) for n in threads}


def remote(socket: ClientConnection) -> Ask:
    """Return what asks the container of a robot, from the request to the answer."""

    async def ask(start: Pose, goal: Pose) -> float:
        frame = compute_path_call(start, goal)
        began = monotonic()
        await socket.send(frame)
        answer = await socket.recv(decode=False)
        seconds = monotonic() - began
        told = msgspec.json.decode(answer, type=_Response)
        if not told.result:
            raise Unavailable(f"the container did not plan: {bytes(told.values).decode()}")
        return seconds

    return ask


async def measure(grid: GridMap, cores: int, progress: Progress, points: int = POINTS) -> dict[str, Any]:
    """Ask all for the same paths, in turn; the least of several runs counts.

    Parameters
    ----------
    grid : GridMap
        Published in a cloud of the bench's own.
    cores : int
        Size of the robot's container, which plans on as many threads.
    progress : Progress
    points : int
        How many lengths.

    Returns
    -------
    dict
        ``length_m`` of the paths, and in ``seconds`` by curve one number each.

    Raises
    ------
    PPaaSError
        The cloud does not start, or does not plan.
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
    """Do the same without a cloud, with each number of threads; return what ``measure`` returns."""
    return await _sample(local_ways(costmap, threads), questions(costmap), costmap, progress)


async def _sample(
    ways: dict[str, Ask], asked: Sequence[PathQuestion], costmap: Costmap, progress: Progress
) -> dict[str, Any]:
    seconds = {name: [float("inf")] * len(asked) for name in ways}
    for run in progress.track(range(-1, RUNS), description="paths, longer and longer"):
        for number, question in enumerate(asked):
            for name, ask in ways.items():
                taken = await ask(question.start, question.goal)
                if run >= 0:  # the first of each compiles, loads, and touches its memory
                    seconds[name][number] = min(seconds[name][number], taken)
    return {
        "cells": costmap.data.size,
        "length_m": [question.length for question in asked],
        "seconds": seconds,
        "cpus": cpus(),
    }


def chart(told: dict[str, Any]) -> tuple[str, list[Line], Axis, Axis]:
    """Return what a chart shows of it."""
    lines = [
        Line(name, [(length, 1e3 * one) for length, one in zip(told["length_m"], seconds, strict=True)])
        for name, seconds in told["seconds"].items()
    ]
    title = f"Planning time over path length, on a map of {told['cells']:,} cells"
    return title, lines, Axis("path length [m]"), Axis("planning time [ms], logarithmic", logarithmic=True)
