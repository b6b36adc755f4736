"""A robot explores by ``ppaas explore``, also after its container was killed, and its map is published."""

import asyncio
import json
from dataclasses import replace

import pytest

from ppaas.geometry import Pose2D
from ppaas.maps.formats.map_files import load_map
from ppaas.maps.grid import GridMap
from robots.cli.main import main
from robots.client.robot_file import RobotFile
from robots.demo.scorer import wrong_cells
from tests.support.cloud.cloud import RunningCloud
from tests.support.cloud.drive import driving
from tests.support.waiting import until
from tests.support.world.planar_world import walled_map

pytestmark = pytest.mark.journey

START = Pose2D(0.8, 0.8, 0.0)


def two_rooms() -> GridMap:
    """Return two small rooms with a door between them, in the frame of the robot's first pose."""
    rooms = walled_map(3.6, 2.4, [(1.7, 0.0, 1.9, 1.3)])
    return GridMap(rooms.data, replace(rooms.info, origin=START.inverse()))


async def test_two_rooms_are_explored_and_published_although_the_container_is_killed(
    cloud: RunningCloud, capsys: pytest.CaptureFixture[str]
) -> None:
    rest, rooms = await cloud.admin(), two_rooms()
    await rest.put_robot("columbus", RobotFile(map="new:rooms"))
    assert rest.token is not None
    async with driving(cloud.url, rest.token, "columbus", rooms, Pose2D(0.0, 0.0, 0.0)) as drive:
        command = ["explore", "columbus", "--json", "--url", cloud.url, "--token", rest.token]
        exploring = asyncio.create_task(asyncio.to_thread(main, command))
        await until(lambda: drive.world.robots[0].base.travelled > 0.2, 60)
        cloud.container().kill()
        assert await asyncio.wait_for(exploring, 120) == 0
        outcome = json.loads(capsys.readouterr().out)
        assert (outcome["state"], outcome["frontiers"]) == ("succeeded", 0)
        assert drive.scorer.collisions(0) == 0
        await rest.post("/v1/robots/columbus/map", {"publish": "rooms"})
    made = load_map(*[await rest.fetch(f"/v1/maps/rooms/{part}") for part in ("yaml", "image")])
    wrong, known = wrong_cells(made, rooms)
    assert known * made.info.resolution**2 > 0.8 * 3.6 * 2.4
    assert 100 * wrong <= known
