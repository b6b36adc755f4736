"""Log of a cloud as JSON: every line of every process is an object, and a request is found in it by its id."""

import asyncio
import json
import re
from pathlib import Path
from typing import Any

import httpx
import pytest
from websockets.asyncio.client import ClientConnection, connect

from ppaas.maps.grid import GridMap
from tests.support.cloud.cloud import RunningCloud, publish_map, register_robot, running_cloud
from tests.support.cloud.joined_machine import JoinedMachine, ticket
from tests.support.waiting import PATIENCE
from tests.support.world.places import free_pose

pytestmark = pytest.mark.journey


def records(log: Path) -> list[dict[str, Any]]:
    """Return the records of a log; each line is one."""
    return [json.loads(line) for line in log.read_text().splitlines()]


async def send_transforms_of_two_clocks(socket: ClientConnection) -> None:
    """Send transforms whose times go back, of which the clone writes to its log, until cancelled."""
    while True:
        for seconds in (1000, 10):
            pose = {"translation": {"x": 0.0, "y": 0.0, "z": 0.0}, "rotation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}}
            header = {"stamp": {"secs": seconds, "nsecs": 0}, "frame_id": "odom"}
            moved = {"header": header, "child_frame_id": "base_link", "transform": pose}
            await socket.send(json.dumps({"op": "publish", "topic": "tf", "msg": {"transforms": [moved]}}))
        await asyncio.sleep(0.2)


async def of_robot(cloud: RunningCloud, robot: str) -> dict[str, Any]:
    """Return a record that names a robot, once there is one."""
    async with asyncio.timeout(PATIENCE):
        while True:
            for record in records(cloud.log):
                if record.get("robot") == robot:
                    return record
            await asyncio.sleep(0.1)


async def test_every_line_of_a_cloud_is_an_object_and_a_request_is_found_by_its_id(
    tmp_path: Path, office_map: GridMap
) -> None:
    with running_cloud(tmp_path, "--log-format", "json") as cloud:
        rest = await cloud.admin()
        await publish_map(rest, "ward", office_map)
        token = await register_robot(rest, "tb1", "ward", free_pose(office_map, seed=3))
        async with httpx.AsyncClient(base_url=cloud.url, timeout=PATIENCE) as client:
            answer = await client.get("/v1/robots/nobody/goals/g7", headers={"X-Request-ID": "night-shift.7"})
            assert (answer.status_code, answer.headers["X-Request-ID"]) == (401, "night-shift.7")
        async with connect(f"{cloud.ws_url}/?robot=tb1&token={token}") as socket:
            sending = asyncio.create_task(send_transforms_of_two_clocks(socket))
            container = await of_robot(cloud, "admin:tb1")
            sending.cancel()
    written = records(cloud.log)
    [failed] = [record for record in written if record.get("request") == "night-shift.7"]
    assert {"robot": "nobody", "goal": "g7", "level": "INFO"}.items() <= failed.items()
    assert "401 not-authenticated" in failed["message"]
    assert "the clock of frame 'base_link' was set back" in container["message"]
    assert {"master", "agent", failed["process"], container["process"]} <= {record["process"] for record in written}
    assert all(re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}Z", record["time"]) for record in written)
    assert all(record.keys() >= {"level", "logger", "message"} for record in written)


async def test_every_line_of_a_joined_machine_is_an_object(tmp_path: Path) -> None:
    with running_cloud(tmp_path, "--listen-machines", "127.0.0.1:0") as cloud:
        machine = JoinedMachine(tmp_path / "hall", "hall")
        machine.start(ticket(tmp_path / "data"), "--log-format", "json")
        await machine.is_in(await cloud.admin())
        machine.end()
    processes = {record["process"] for record in records(machine.log)}
    assert processes == {"agent"}
