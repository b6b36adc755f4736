"""Commands of robots continue under logins, a map of 1.7 million cells for three subscribers, and a slow reader."""

import asyncio
import itertools
import json
import os
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np
import pytest

from ppaas.geometry import Pose2D
from ppaas.maps.generate import office, warehouse
from ppaas.maps.grid import GridMap
from robots.client.rest import RestClient
from tests.stress.conftest import Figure
from tests.support.cloud.cloud import RunningCloud, publish_map, register_robot, running_cloud
from tests.support.cloud.drive import Drive, driving
from tests.support.waiting import until
from tests.support.world.places import free_pose, reachable_pose

pytestmark = pytest.mark.joint

SECONDS = float(os.environ.get("PPAAS_JOINT_SECONDS", "5"))
COMMAND_TIMEOUT = 0.5
"""Time without a command after which a robot's base stops [s]: the load makes no gap longer, unless gaps were nearly as
long before it, on a computer that does other work."""

DRIVERS = 2
SUBSCRIBERS = 3


async def test_commands_continue_under_logins_giant_maps_and_a_slow_reader(tmp_path: Path, figure: Figure) -> None:
    small, giant = office(seed=1, width=12.0, height=10.0), warehouse(seed=1, width=50.0, height=31.0, resolution=0.03)
    assert giant.data.size > 1_700_000
    with running_cloud(tmp_path) as cloud:
        rest = await cloud.admin()
        await publish_map(rest, "small", small)
        await publish_map(rest, "giant", giant)
        quiet, loud = asyncio.Event(), asyncio.Event()
        async with asyncio.TaskGroup() as group:
            drives = [group.create_task(drive_on(cloud, rest, small, n, quiet, loud)) for n in range(DRIVERS)]
            group.create_task(make_load(cloud, rest, giant, quiet, loud))
        p99 = [task.result() for task in drives]
    figure("99 % of the gaps between commands are shorter than, quiet, ms", _milliseconds(before for before, _ in p99))
    figure("99 % of the gaps between commands are shorter than, loaded, ms", _milliseconds(after for _, after in p99))
    assert all(after < max(COMMAND_TIMEOUT, 2.0 * before) for before, after in p99), p99


def _milliseconds(seconds: Iterable[float]) -> str:
    return " and ".join(f"{1e3 * one:.0f}" for one in seconds)


async def drive_on(
    cloud: RunningCloud, rest: RestClient, grid: GridMap, number: int, quiet: asyncio.Event, loud: asyncio.Event
) -> tuple[float, float]:
    """Drive back and forth; return the 99th percentile of the gaps between commands before and under the load [s]."""
    start = free_pose(grid, seed=50 + number)
    goal = reachable_pose(grid, start, seed=60 + number, at_least=4.0)
    token = await register_robot(rest, f"d{number}", "small", start)
    async with driving(cloud.url, token, f"d{number}", grid, start) as drive:
        roaming = asyncio.create_task(roam(drive, itertools.cycle((goal, start))))
        await until(lambda: len(drive.commands) > 5)
        await asyncio.sleep(SECONDS)
        quiet.set()
        before = p99_gap(drive)
        drive.commands.clear()
        await loud.wait()
        roaming.cancel()
        return before, p99_gap(drive)


async def roam(drive: Drive, goals: Iterator[Pose2D]) -> None:
    for goal in goals:
        await drive.go(goal)


def p99_gap(drive: Drive) -> float:
    times = [time for time, _ in drive.commands]
    return float(np.percentile(np.diff(times), 99))


async def make_load(
    cloud: RunningCloud, rest: RestClient, grid: GridMap, quiet: asyncio.Event, loud: asyncio.Event
) -> None:
    """Load the cloud from another process, so that this test does not distort the measurement."""
    token = await register_robot(rest, "giant", "giant", free_pose(grid, seed=70))
    await quiet.wait()
    load = await asyncio.create_subprocess_exec(
        sys.executable, "-m", "tests.support.stress.load", cloud.url, token, "giant", str(SECONDS),
        stdout=asyncio.subprocess.PIPE,
    )  # fmt: skip
    output, _ = await load.communicate()
    assert load.returncode == 0
    done = json.loads(output)
    assert done["logins"] > 0 and done["maps"] >= SUBSCRIBERS, done
    loud.set()
