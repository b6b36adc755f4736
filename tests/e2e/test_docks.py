"""Docks in a real cloud: a robot docks until it is charged, also if its container is killed meanwhile, and undocks.

A robot with little charge does so by itself: it leaves a charger that lies for the next one, which somebody moved.
"""

import asyncio
import os
import signal
from typing import Any

import pytest

from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import Status
from ppaas.messages.base.std_msgs import String
from ppaas.messages.nav2_servers import DockPhase
from ppaas.zones.reading import geojson_of
from ppaas.zones.shapes import Point
from ppaas.zones.zone import Dock, Zone, ZoneSet
from robots.client.robot_file import RobotFile
from robots.sim.docks.charger import Charger, ChargerFault
from tests.support.cloud.cloud import RunningCloud, publish_map
from tests.support.cloud.docked_robot import docked_scene
from tests.support.waiting import patience, until
from tests.support.world.planar_world import walled_map

pytestmark = pytest.mark.journey

MAP = "garage"
GARAGE = walled_map(5.0, 4.0, [])
START = Pose2D(1.2, 1.2, 0.0)
DOCKED = Pose2D(4.2, 2.0, 0.0)
ZONES = ZoneSet([Zone(Point([DOCKED.x, DOCKED.y]), Dock(name="east wall", yaw=DOCKED.theta))])


async def test_a_robot_docks_until_it_is_charged_although_its_container_is_killed(cloud: RunningCloud) -> None:
    rest = await cloud.admin()
    await publish_map(rest, MAP, GARAGE)
    await rest.put_zones(MAP, geojson_of(ZONES))
    file = RobotFile(map=MAP, initial_pose=(START.x, START.y, START.theta), cores=0.5)
    await rest.put_robot("td", file)
    async with docked_scene(cloud.url, str(rest.token), "td", GARAGE, START, ZONES) as scene:
        said: list[str] = []
        await scene.operator.subscribe("docking_server/status", String, lambda text: said.append(text.data))
        docking = asyncio.create_task(scene.dock("east wall"))
        await until(lambda: any(each.state == DockPhase.CONTROLLING for each in scene.feedback), 60.0)
        (pid,) = [each["pid"] for each in await rest.items("/v1/containers") if each["robot"] == "td"]
        os.kill(pid, signal.SIGKILL)
        status, result = await docking
        assert (status.status, result.success) == (Status.SUCCEEDED, True), status.text
        assert scene.chargers[0].touches(scene.robot.base.pose)
        assert scene.battery.flow > 1.0
        await until(lambda: said[-1:] == ["docked at dock 'east wall'"])
        status, undocked = await scene.undock()
        assert (status.status, undocked.success) == (Status.SUCCEEDED, True), status.text
        assert scene.robot.base.pose.distance_to(DOCKED) > 0.6
        assert scene.battery.flow < 0.0
        await until(lambda: said[-1] == "")


async def test_a_robot_with_little_charge_leaves_a_charger_that_lies_and_docks_at_one_that_was_moved(
    cloud: RunningCloud,
) -> None:
    rest, liar, moved = await cloud.admin(), Pose2D(4.2, 1.0, 0.0), Pose2D(4.2, 2.8, 0.0)
    docks = [
        Zone(Point([pose.x, pose.y]), Dock(name=name, yaw=pose.theta))
        for name, pose in (("liar", liar), ("far", moved))
    ]
    await publish_map(rest, "shed", GARAGE)
    await rest.put_zones("shed", geojson_of(ZoneSet(docks)))
    file = RobotFile(map="shed", initial_pose=(START.x, START.y, START.theta), cores=0.5)
    await rest.put_robot("te", file)
    chargers = (Charger(liar, 0.2, fault=ChargerFault.LIAR), Charger(Pose2D(moved.x, moved.y + 0.2), 0.2))
    tasks = "/v1/maps/shed/tasks"
    async with docked_scene(cloud.url, str(rest.token), "te", GARAGE, START, chargers, charge=0.3) as scene:
        await until(lambda: scene.battery.flow > 1.0 and chargers[1].touches(scene.robot.base.pose), 150.0)

        async def trips(state: str) -> list[dict[str, Any]]:
            return [task for task in await rest.items(tasks) if task["trip"] == "charge" and task["state"] == state]

        [failed] = await trips("failed")
        assert "robot 'te': goal aborted" in failed["reason"]
        async with patience(30.0):
            while not (active := await trips("active")):
                await asyncio.sleep(0.2)
        await rest.post(tasks, {"kind": "go_to", "places": [[START.x, START.y]]})
        await rest.delete(f"{tasks}/{active[0]['id']}")
        await until(lambda: scene.robot.base.pose.distance_to(START) < 0.3)
        assert scene.battery.flow < 0.0
