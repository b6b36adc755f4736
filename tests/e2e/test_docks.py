"""Docks in a real cloud: a robot docks until it is charged, also if its container is killed meanwhile, and undocks."""

import asyncio
import os
import signal

import pytest

from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import Status
from ppaas.messages.base.std_msgs import String
from ppaas.messages.geometry_msgs import PolygonStamped
from ppaas.messages.nav2_servers import DockPhase
from ppaas.zones.reading import geojson_of
from ppaas.zones.shapes import Point
from ppaas.zones.zone import Dock, Zone, ZoneSet
from robots.client.rest import RestClient
from robots.client.robot_file import RobotFile
from tests.support.cloud.cloud import RunningCloud, publish_map
from tests.support.cloud.docked_robot import docked_scene
from tests.support.waiting import until
from tests.support.world.planar_world import walled_map

pytestmark = pytest.mark.journey

MAP = "garage"
GARAGE = walled_map(5.0, 4.0, [])
START = Pose2D(1.2, 1.2, 0.0)
DOCKED = Pose2D(4.2, 2.0, 0.0)
ZONES = ZoneSet([Zone(Point([DOCKED.x, DOCKED.y]), Dock(name="east wall", yaw=DOCKED.theta))])


async def kill_container(rest: RestClient, robot: str) -> None:
    """Kill the container of a robot."""
    (pid,) = [each["pid"] for each in await rest.items("/v1/containers") if each["robot"] == robot]
    os.kill(pid, signal.SIGKILL)


async def test_a_robot_docks_until_it_is_charged_although_its_container_is_killed(cloud: RunningCloud) -> None:
    rest = await cloud.admin()
    await publish_map(rest, MAP, GARAGE)
    await rest.put_zones(MAP, geojson_of(ZONES))
    file = RobotFile(map=MAP, initial_pose=(START.x, START.y, START.theta), cores=0.5)
    await rest.put_robot("td", file)
    async with docked_scene(cloud.url, str(rest.token), "td", GARAGE, ZONES, file) as scene:
        said: list[str] = []
        await scene.operator.subscribe("docking_server/status", String, lambda text: said.append(text.data))
        docking = asyncio.create_task(scene.dock("east wall"))
        await until(lambda: any(each.state == DockPhase.CONTROLLING for each in scene.feedback), 60.0)
        await kill_container(rest, "td")
        status, result = await docking
        assert (status.status, result.success) == (Status.SUCCEEDED, True), status.text
        assert scene.docks.chargers[0].touches(scene.robot.base.pose)
        assert scene.parts.battery.flow > 1.0
        await until(lambda: said[-1:] == ["docked at dock 'east wall'"])
        status, undocked = await scene.undock()
        assert (status.status, undocked.success) == (Status.SUCCEEDED, True), status.text
        assert scene.robot.base.pose.distance_to(DOCKED) > 0.6
        assert scene.parts.battery.flow < 0.0
        await until(lambda: said[-1] == "")


STORE = "store"
STOREROOM = walled_map(7.0, 5.0, [])
UNDER = Pose2D(2.6, 2.5, 0.0)
LOAD = [[0.5, 0.35], [-0.5, 0.35], [-0.5, -0.35], [0.5, -0.35]]
SHELF = {
    "detection": "legs", "detector": {"spacing": 0.58}, "distance": -0.44, "blind_distance": 0.7,
    "staging_distance": 1.2, "docking_threshold": 0.03, "lateral_tolerance": 0.06, "load": LOAD,
}  # fmt: skip


async def test_a_robot_carries_a_shelf_elsewhere_although_its_container_is_killed(cloud: RunningCloud) -> None:
    rest, name = await cloud.admin(), "shelf 1"
    zones = ZoneSet([Zone(Point([UNDER.x, UNDER.y]), Dock(name=name, yaw=0.0, dock_type="shelf", charges=False))])
    await publish_map(rest, STORE, STOREROOM)
    await rest.put_zones(STORE, geojson_of(zones))
    parameters = {"docking_server": {"dock_types": {"shelf": SHELF}}}
    file = RobotFile(map=STORE, initial_pose=(1.4, 2.5, 0.0), cores=0.5, parameters=parameters)
    await rest.put_robot("carrier", file)
    async with docked_scene(cloud.url, str(rest.token), "carrier", STOREROOM, zones, file) as scene:
        outlines: list[PolygonStamped] = []
        await scene.operator.subscribe("local_costmap/published_footprint", PolygonStamped, outlines.append)
        status, result = await scene.dock(name)
        assert (status.status, result.success) == (Status.SUCCEEDED, True), status.text
        [shelf], lift = scene.docks.shelves, scene.parts.lift
        assert lift is not None and lift.shelf is shelf
        await until(lambda: bool(outlines) and width_of(outlines[-1]) > 0.9, 20.0)
        await kill_container(rest, "carrier")
        outlines.clear()
        await until(lambda: bool(outlines) and width_of(outlines[-1]) > 0.9, 30.0)
        await scene.drive(Pose2D(4.4, 2.5, 0.0))
        assert shelf.pose.x > 4.0
        status, undocked = await scene.undock()
        assert (status.status, undocked.success) == (Status.SUCCEEDED, True), status.text
        assert status.text.startswith("set down at (4.")
        assert lift.shelf is None and shelf.pose.x - scene.robot.base.pose.x > 1.0
        await until(lambda: width_of(outlines[-1]) < 0.5, 20.0)
        [row] = [each for each in await rest.items("/v1/robots") if each["id"] == "carrier"]
        assert not scene.docks.world.contacts.total(0), row


def width_of(outline: PolygonStamped) -> float:
    """Return the extent of an outline along x [m]."""
    across = [point.x for point in outline.polygon.points]
    return max(across) - min(across)
