"""First use of a cloud on a new computer: times until each planner answers and until a robot drives, without a cache.

The first cloud has nothing but a wheel of compiled kernels, the second one has to compile them. The yardstick is a
start of the second one again.
"""

import asyncio
import os
import subprocess
import tempfile
import zipfile
from collections.abc import Coroutine, Mapping
from pathlib import Path
from typing import Any

from rich.progress import Progress

from benchmarks.harness.cloud_under_test import logged_in
from benchmarks.harness.figures import Figure
from benchmarks.harness.plan_calls import ends
from benchmarks.service import fleet
from ppaas.clock import monotonic
from ppaas.errors import Unavailable
from ppaas.maps.generate import warehouse
from ppaas.planners.registry import PLANNERS
from robots.demo.cloud_process import CloudProcess

PART = "first"
PLAN_LIMIT_S, DRIVE_LIMIT_S = 5.0, 8.0
Times = dict[str, float]


async def measure(progress: Progress, quick: bool) -> list[Figure]:
    """Measure a cloud with a wheel of kernels and, unless quick, one that compiles them, twice."""
    with tempfile.TemporaryDirectory() as folder:
        packages, cache, empty = (Path(folder, name) for name in ("packages", "cache", "empty"))
        await asyncio.to_thread(_unpack_wheel, packages)
        shipped = await _first_use({"PYTHONPATH": str(packages), "NUMBA_CACHE_DIR": str(empty)}, progress)
        figures = _figures("with a wheel", shipped, within_limits=True)
        if not quick:
            own = {"NUMBA_CACHE_DIR": str(cache)}
            figures += _figures("compiling", await _first_use(own, progress))
            figures += _figures("again", await _first_use(own, progress), yardstick=True)
    return figures


def _unpack_wheel(folder: Path) -> None:
    """Put the kernels of this computer into a folder of packages."""
    from engine.runtimes.compilation import kernel_wheel, rest_compiler  # noqa: PLC0415

    subprocess.run(rest_compiler.COMMAND, check=True, stdout=subprocess.DEVNULL)
    with zipfile.ZipFile(kernel_wheel.build_wheel(folder)) as wheel:
        wheel.extractall(folder)


async def _first_use(environment: Mapping[str, str], progress: Progress) -> Times:
    """Return the times from the start of a cloud until it was up, each planner had answered, and a robot drove [s]."""
    began = monotonic()
    task = progress.add_task("first use of a cloud", total=None)
    times: Times = {}
    lost: list[str] = []

    async def noted(name: str, work: Coroutine[Any, Any, object]) -> None:
        try:
            await work
        except Unavailable as error:
            lost.append(f"{name}: {error}")
        times[name] = monotonic() - began

    async with CloudProcess(environment=os.environ | environment, arguments=("--linger", "0.1")) as cloud:
        times["up"] = monotonic() - began
        target, grid = await logged_in(cloud), warehouse(seed=1)
        await target.publish(fleet.MAP, grid)
        start, goal = ends(grid)
        async with asyncio.TaskGroup() as group:
            for planner in PLANNERS.names():
                group.create_task(noted(planner, target.rest.plan(fleet.MAP, start, goal, planner=planner)))
            group.create_task(noted("drives", fleet.SimulatedFleet(target, grid, 1).drive_off()))
    progress.remove_task(task)
    for text in lost:
        progress.console.print(f"lost: {text}")
    return times | {"lost": float(len(lost))}


def _figures(how: str, times: Times, *, within_limits: bool = False, yardstick: bool = False) -> list[Figure]:
    limits = dict.fromkeys(times, PLAN_LIMIT_S) | {"drives": DRIVE_LIMIT_S, "lost": 0.0}
    names = {"up": "ppaas up, ready", "drives": "first cmd_vel of a robot", "lost": "requests lost"}
    return [
        Figure(
            PART, f"{names.get(name, f'first path of {name}')}, {how}", round(value, 2), "" if name == "lost" else "s",
            limit=limits[name] if within_limits else None, yardstick=yardstick, note="since the start of `ppaas up`",
        )
        for name, value in times.items()
    ]  # fmt: skip
