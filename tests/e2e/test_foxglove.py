"""Viewers of Foxglove look at robots and drive them: its own client, and one that speaks ``foxglove.sdk.v1``."""

import asyncio
import json
import shutil
from pathlib import Path
from typing import Any

import msgspec
import pytest
from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed, InvalidStatus

from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridMap
from ppaas.messages.geometry_msgs import Pose
from robots.client.rest import RestClient
from tests.support.clients.foxglove_viewer import FoxgloveViewer, viewer_of
from tests.support.cloud.cloud import RunningCloud, publish_map, register_robot
from tests.support.cloud.drive import driving
from tests.support.world.places import free_pose, reachable_pose

pytestmark = pytest.mark.journey

FOLDER = Path(__file__).parent / "foxglove"
NEAR = 0.5
"""Largest distance of the pose that a viewer is shown at the end from the goal [m]."""


@pytest.fixture
def node() -> str:
    """Return the command of Node; ``make test`` installs Foxglove's client if Node is installed."""
    found = shutil.which("node")
    if found is None or not (FOLDER / "node_modules" / "@foxglove" / "ws-protocol").is_dir():
        pytest.skip("Node, or Foxglove's client in it, is not installed: install Node 20 or newer and run make test")
    return found


@pytest.mark.clients
async def test_the_client_of_foxglove_drives_a_robot_and_sees_it(
    node: str, cloud: RunningCloud, foxglove_port: int, office_map: GridMap
) -> None:
    rest = await cloud.admin()
    await publish_map(rest, "office", office_map)
    start = free_pose(office_map, seed=31)
    goal = reachable_pose(office_map, start, seed=32, at_least=1.0, at_most=2.0)
    token = await register_robot(rest, "tbfox", "office", start)
    url = f"ws://127.0.0.1:{foxglove_port}/?token={token}&robot=tbfox"
    async with driving(cloud.url, token, "tbfox", office_map, start) as drive:
        script = await asyncio.create_subprocess_exec(
            node, str(FOLDER / "viewer.mjs"), url, "tbfox", "office", json.dumps(msgspec.to_builtins(Pose.of(goal))),
            stdout=asyncio.subprocess.PIPE, stderr=asyncio.subprocess.PIPE,
        )  # fmt: skip
        output, errors = await script.communicate()
        assert script.returncode == 0, errors.decode() + drive.situation()
    check_found(json.loads(output), office_map, goal)


def check_found(found: dict[str, Any], grid: GridMap, goal: Pose2D) -> None:
    assert found["statuses"] == []
    assert {"clientPublish", "parameters", "services", "time"} <= set(found["serverInfo"]["capabilities"])
    assert found["schemas"]["map"] == ["cdr", "nav_msgs/msg/OccupancyGrid", "ros2msg"]
    assert found["schemas"]["scan"] == ["protobuf", "foxglove.LaserScan", "protobuf"]
    assert found["map"] == {"width": grid.data.shape[1], "cells": grid.data.size, "frame": "office"}
    assert found["result"] == 3
    assert (found["counts"]["model"], found["counts"]["map"]) == (1, 1)
    assert min(found["counts"][name] for name in ("scan", "tf", "plan", "amcl_pose")) >= 1
    assert found["times"] > 1
    seen = found["amcl_pose"]
    assert seen["frame"] == "office"
    assert Pose2D(seen["x"], seen["y"], 0.0).distance_to(goal) < NEAR
    assert found["set"] == [{"name": "/tbfox/viewer/limit", "value": 2, "type": "float64"}]
    assert found["called"]["value"] == "2.0"
    assert found["frequency"]["type"] == "float64"
    assert "/tbfox/amcl" in found["publishers"]["publisherIds"]


async def test_a_guest_sees_what_is_shared_and_drives_nothing(
    cloud: RunningCloud, foxglove_port: int, office_map: GridMap
) -> None:
    admin, guest = await cloud.admin(), RestClient(cloud.url)
    await publish_map(admin, "office", office_map)
    start = free_pose(office_map, seed=41)
    token = await register_robot(admin, "tbshown", "office", start)
    await admin.post("/v1/users", {"id": "foxguest", "password": "correct horse"})
    await guest.login("foxguest", "correct horse")
    share = {"role": "look", "subscribe": ["scan", "tf", "goal_pose", "map", "robot_description"]}
    await admin.put("/v1/robots/tbshown/shares/foxguest", share)
    assert guest.token is not None
    address = f"ws://127.0.0.1:{foxglove_port}/"
    async with driving(cloud.url, token, "tbshown", office_map, start):
        async with viewer_of(f"{address}?token={guest.token}") as viewer:
            await check_guest(viewer)
        await check_refusals(address, guest.token)


async def check_guest(viewer: FoxgloveViewer) -> None:
    await viewer.until_channel("/admin/tbshown/scan")
    names = {"model", "robot_description", "scan", "tf", "goal_pose", "map"}
    assert {channel["topic"] for channel in viewer.channels.values()} == {f"/admin/tbshown/{name}" for name in names}
    scan, tf = await viewer.message("/admin/tbshown/scan"), await viewer.message("/admin/tbshown/tf")
    assert (len(scan.ranges), scan.frame_id) == (360, "admin/tbshown/base_link")
    transform = tf.transforms[0]
    assert transform.child_frame_id.startswith("admin/tbshown/")
    model = await viewer.message("/admin/tbshown/model")
    assert model.entities[0].frame_locked and model.entities[0].id == "admin/tbshown"
    await viewer.publish("/admin/tbshown/goal_pose", "geometry_msgs/PoseStamped", {})
    for _ in ("advertised", "published"):
        assert "needs the role 'drive'" in await viewer.status()
    await viewer.send({"op": "subscribe", "subscriptions": [{"id": 77, "channelId": 123456}]})
    assert "unknown channel '123456'" in await viewer.status()
    await viewer.send({"op": "setParameters", "parameters": [{"name": "/admin/tbshown/a", "value": 1}]})
    assert "needs the role 'administer'" in await viewer.status()


async def check_refusals(address: str, token: str) -> None:
    async with viewer_of(f"{address}?token=wrong") as refused:
        assert "not-authenticated: the token is unknown or expired" in await refused.status()
        with pytest.raises(ConnectionClosed) as closed:
            await refused.status()
    assert closed.value.rcvd is not None and closed.value.rcvd.code == 1008
    with pytest.raises(InvalidStatus) as problem:
        async with connect(f"{address}?token={token}"):
            pass
    assert b"foxglove.sdk.v1" in problem.value.response.body
    async with viewer_of(f"{address}?token={token}") as giant:
        with pytest.raises(ConnectionClosed) as closed:
            await giant.send({"op": "unknown", "filler": "x" * (2 << 20)})
            await giant.status()
    assert closed.value.rcvd is not None and closed.value.rcvd.code == 1009
