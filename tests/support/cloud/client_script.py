"""Runs scripts with third-party clients, which operate a simulated robot and print their results."""

import asyncio
import json
import os
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager
from typing import Any, NamedTuple

import msgspec

from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridMap
from ppaas.messages.geometry_msgs import Pose
from tests.support.cloud.cloud import RunningCloud, publish_map, register_robot
from tests.support.cloud.drive import Drive, driving
from tests.support.world.places import free_pose, reachable_pose


class Found(NamedTuple):
    """JSON output of the script, and its error output."""

    told: dict[str, Any]
    errors: bytes


class Operated(NamedTuple):
    """A robot that a script operated, which is still connected, and the poses that the script was given."""

    found: Found
    drive: Drive
    start: Pose2D
    near: Pose2D


async def operate(command: Sequence[str], cloud: RunningCloud, grid: GridMap, robot: str, seed: int) -> Found:
    """Run a script as operator of a robot, with a WebSocket URL and the poses ``near``, ``far`` and ``back``."""
    async with operating(command, cloud, grid, robot, seed) as operated:
        return operated.found


@asynccontextmanager
async def operating(
    command: Sequence[str], cloud: RunningCloud, grid: GridMap, robot: str, seed: int, **variables: str
) -> AsyncIterator[Operated]:
    """Run a script like ``operate``, in an environment with some more variables, and leave the robot connected."""
    rest = await cloud.admin()
    await publish_map(rest, "office", grid)
    start = free_pose(grid, seed=seed)
    near = reachable_pose(grid, start, seed=seed + 1, at_least=0.6, at_most=1.2)
    far = reachable_pose(grid, start, seed=seed + 2, at_least=3.0)
    token = await register_robot(rest, robot, "office", start)
    url = f"{cloud.ws_url}/?robot={robot}&role=operator&token={token}"
    poses = {name: msgspec.to_builtins(Pose.of(pose)) for name, pose in (("near", near), ("far", far), ("back", start))}
    async with driving(cloud.url, token, robot, grid, start) as drive:
        script = await asyncio.create_subprocess_exec(
            *command, url, json.dumps(poses), env=os.environ | variables,
            stdout=asyncio.subprocess.PIPE, stderr=asyncio.subprocess.PIPE,
        )  # fmt: skip
        output, errors = await script.communicate()
        assert script.returncode == 0, errors.decode() + drive.situation()
        yield Operated(Found(json.loads(output), errors), drive, start, near)
