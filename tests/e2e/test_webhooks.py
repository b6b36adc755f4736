"""Webhooks of a real cloud: events of a robot arrive, verified; what did not, after a kill of the master."""

import asyncio
import os
import signal
from pathlib import Path

import pytest

from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridMap
from robots.client.cloud_url import path_of
from tests.support.cloud.cloud import publish_map, register_robot, running_cloud
from tests.support.cloud.drive import driving
from tests.support.endpoints.webhook_target import Target
from tests.support.waiting import patience, until
from tests.support.world.places import free_pose

pytestmark = pytest.mark.journey

OPTIONS = ("--webhook-allow-private", "--webhook-allow-http", "--adopt-within", "0")


async def test_events_arrive_and_outlive_the_master(tmp_path: Path, office_map: GridMap) -> None:
    start = free_pose(office_map, seed=1)
    async with Target().serving() as target:
        with running_cloud(tmp_path, *OPTIONS) as first:
            rest = await first.admin()
            await publish_map(rest, "office", office_map)
            token = await register_robot(rest, "tb1", "office", start)
            wanted = {"url": target.url, "events": ["goal.*", "task.done", "robot.connected"], "robots": ["tb*"]}
            hook = await rest.post("/v1/webhooks", wanted)
            target.secrets = [hook["secret"]]
            await rest.post(path_of("webhooks", hook["id"], "test"), {})
            await target.has(1)
            async with driving(first.url, token, "tb1", office_map, start) as drive:
                await target.has(2)
                await drive.send(Pose2D(*start), "mine")
                await drive.result()
                sent = await rest.post("/v1/robots/tb1/goals", {"pose": list(start)})
                await target.has(4)
                task = await rest.post("/v1/maps/office/tasks", {"kind": "go_to", "places": [list(start)]})
                await until(lambda: "task.done" in [event["type"] for event in target.events])
                target.hangs = True
                await rest.post(path_of("webhooks", hook["id"], "test"), {})
                await until(lambda: target.hanging)
                os.kill(first.pid, signal.SIGKILL)
                first.status = -signal.SIGKILL
                (tmp_path / "ready.json").unlink()
        target.hangs = False
        before = len(target.events)
        with running_cloud(tmp_path, *OPTIONS) as second:
            await target.has(before + 1)
            again = await second.admin()
            async with patience(30):
                while (await again.get(path_of("webhooks", hook["id"], "deliveries")))["items"]:
                    await asyncio.sleep(0.1)
    types = [event["type"] for event in target.events]
    assert types[:2] == ["webhook.test", "robot.connected"] and types[-1] == "webhook.test"
    goals = {event["data"]["goal"]["id"]: event for event in target.events if "goal" in event["data"]}
    assert {"mine", sent["id"]} <= goals.keys()
    assert {goal["type"] for goal in goals.values()} == {"goal.reached"}
    assert goals["mine"]["data"]["map"] == "office" and goals["mine"]["data"]["robot"] == "tb1"
    [done] = [event for event in target.events if event["type"] == "task.done"]
    assert done["data"]["task"]["id"] == task["id"]
