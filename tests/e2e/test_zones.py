"""Zones of a map in a real cloud: a robot obeys zones that are put, changed and removed while it drives."""

import asyncio

import pytest

from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import Status
from ppaas.zones.reading import geojson_of
from ppaas.zones.shapes import LineString
from ppaas.zones.zone import Lane, OneWay, SpeedZone, Zone, ZoneSet
from robots.client.robot_file import RobotFile
from tests.support.cloud.cloud import RunningCloud, publish_map
from tests.support.cloud.drive import Drive, driving
from tests.support.waiting import until
from tests.support.world.planar_world import walled_map
from tests.support.zones import rectangle

pytestmark = pytest.mark.journey

MAP = "ring"
RING = walled_map(7.0, 4.0, [(1.6, 1.5, 5.4, 2.5)])
"""Two aisles around a shelf."""

WEST, EAST = Pose2D(0.8, 0.75, 0.0), Pose2D(6.2, 0.75, 0.0)

SOUTH = Zone(LineString([[6.0, 0.8], [1.0, 0.8]]), OneWay(name="south aisle", width=1.3))
"""Only westward."""

SLOW = rectangle(SpeedZone(name="north aisle", max_speed=0.25), 2.0, 2.6, 5.0, 3.9)


AROUND = Zone(LineString([[0.8, 0.75], [0.8, 3.25], [6.2, 3.25], [6.2, 0.75]]), Lane(name="north of the shelf"))


async def result_of(drive: Drive, goal_id: str) -> int:
    """Return the result of a goal; a robot that gives way has goals of its own."""
    while True:
        status = (await drive.result(150.0)).status
        if status.goal_id.id == goal_id:
            return status.status


async def watch(drive: Drive) -> tuple[list[float], list[float]]:
    """Drive east; return y of the robot's true positions beside the shelf, and its speeds in the slow zone."""
    places: list[float] = []
    speeds: list[float] = []
    base = drive.world.robots[0].base
    await drive.send(EAST, "east")
    result = asyncio.create_task(result_of(drive, "east"))
    while not result.done():
        await asyncio.sleep(0.05)
        if 2.3 < base.pose.x < 4.7:
            places.append(base.pose.y)
            if base.pose.y > 2.9:
                speeds.append(base.wheels.linear)
    assert (await result) == Status.SUCCEEDED, drive.situation()
    return places, speeds


async def test_a_robot_obeys_zones_that_come_and_go_while_it_is_connected(cloud: RunningCloud) -> None:
    rest = await cloud.admin()
    await publish_map(rest, MAP, RING)
    file = RobotFile(map=MAP, initial_pose=(WEST.x, WEST.y, WEST.theta), cores=0.25, traffic=True)
    await rest.put_robot("tz", file)
    async with driving(cloud.url, str(rest.token), "tz", RING, WEST) as drive:
        await until(lambda: bool(drive.poses))
        await rest.put_zones(MAP, geojson_of(ZoneSet([SOUTH, SLOW])))
        assert (await rest.get(f"/v1/maps/{MAP}/zones"))["in_force"] == ["south aisle", "north aisle"]
        await asyncio.sleep(3.0)  # the containers go on with the version
        places, speeds = await watch(drive)
        assert places and min(places) > 2.5, "it takes the aisle in which it may drive east"
        assert speeds and max(speeds) < 0.3
        await drive.send(WEST, "west")
        assert await result_of(drive, "west") == Status.SUCCEEDED
        await rest.put_zones(MAP, geojson_of(ZoneSet([AROUND])))
        await asyncio.sleep(3.0)
        places, _ = await watch(drive)
        assert places and min(places) > 3.1 and max(places) < 3.4, "along the lane"
        await drive.send(WEST, "west again")
        assert await result_of(drive, "west again") == Status.SUCCEEDED
        await rest.remove_zones(MAP)
        await asyncio.sleep(3.0)
        places, _ = await watch(drive)
        assert max(places) < 1.5, "the short way"
