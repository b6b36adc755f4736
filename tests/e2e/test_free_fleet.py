"""A robot of the cloud is driven over Zenoh as free_fleet of Open-RMF drives robots with Navigation2."""

import asyncio
import math
import os
import socket
from pathlib import Path

import pytest

from ppaas.geometry import Pose2D, yaw_of
from ppaas.maps.grid import GridMap
from tests.support.cloud.cloud import RunningCloud, publish_map, register_robot
from tests.support.cloud.drive import driving
from tests.support.ros2.bridge_process import COMMAND, bridge_process
from tests.support.ros2.free_fleet_peer import FreeFleetPeer
from tests.support.waiting import patience, until
from tests.support.world.places import free_pose, reachable_pose

pytestmark = pytest.mark.journey

SUCCEEDED, CANCELED, ABORTED = 4, 5, 6
"""Statuses of ``action_msgs/GoalStatus``."""


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as listener:
        return int(listener.getsockname()[1])


async def ended(peer: FreeFleetPeer, goal: object) -> int:
    async with patience(90.0):
        while (status := await asyncio.to_thread(peer.result, goal)) is None:
            pass
        return status


async def test_free_fleet_drives_a_robot(cloud: RunningCloud, office_map: GridMap, tmp_path: Path) -> None:
    rest = await cloud.admin()
    await publish_map(rest, "office", office_map)
    start = free_pose(office_map, seed=70)
    goal = reachable_pose(office_map, start, seed=71, at_least=0.6, at_most=1.2)
    token = await register_robot(rest, "ff1", "office", start)
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    options = ("ff1", "--name", "ff1=nav2_tb3", "--listen", endpoint, "--url", cloud.url, "--token", token)
    command = (*COMMAND[:-1], "free-fleet")
    async with driving(cloud.url, token, "ff1", office_map, start) as drive:
        with bridge_process(*options, command=command, log=tmp_path / "log", env=os.environ):
            peer = FreeFleetPeer(endpoint, "nav2_tb3")
            try:
                await until(lambda: peer.transforms)
                last = peer.transforms[-1]
                assert (last.header.frame_id, last.child_frame_id) == ("map", "base_footprint")
                turn = last.rotation
                seen = Pose2D(last.translation.x, last.translation.y, yaw_of(turn.x, turn.y, turn.z, turn.w))
                assert math.dist(seen[:2], start[:2]) < 0.3
                first = await asyncio.to_thread(peer.go, goal.x, goal.y)
                assert await ended(peer, first) == SUCCEEDED
                assert drive.scorer.error(0, goal) < 0.3
                assert peer.distances and peer.distances[-1] < peer.distances[0]
                outside = await asyncio.to_thread(peer.go, -50.0, 0.0)
                assert outside is None or await ended(peer, outside) == ABORTED
                back = await asyncio.to_thread(peer.go, start.x, start.y)
                assert await asyncio.to_thread(peer.result, back, 0.5) is None, "it drives"
                assert await asyncio.to_thread(peer.stop) == 0
                assert await ended(peer, back) == CANCELED
                assert await asyncio.to_thread(peer.result, [1] * 16) == 0, "a goal that nobody has sent is unknown"
            finally:
                peer.close()
