"""Commands of floors.md are run as they stand."""

import asyncio
from pathlib import Path

import pytest

from ppaas.buildings.building import Building, Floor, json_of
from ppaas.geometry import Pose2D
from ppaas.maps.formats.map_files import load_map
from ppaas.maps.grid import GridMap
from robots.client.robot_file import RobotFile, load_robot_file
from tests.support.cloud.cloud import RunningCloud, publish_map
from tests.support.cloud.drive import driving
from tests.support.documents import blocks, run_shell
from tests.support.waiting import patience, until

PAGE = "docs/floors.md"


@pytest.fixture
def office() -> GridMap:
    """Return the map of the examples."""
    return load_map(Path("docs/examples/office.yaml").read_bytes(), Path("docs/examples/office.pgm").read_bytes())


@pytest.fixture
def robot() -> RobotFile:
    """Return the robot of the examples."""
    return load_robot_file(Path("docs/examples/tb1.json"))


@pytest.mark.journey
async def test_a_robot_is_moved_by_the_command_of_the_page(
    cloud: RunningCloud, office: GridMap, robot: RobotFile, tmp_path: Path
) -> None:
    rest = await cloud.admin()
    for name in ("office", "office-2"):
        await publish_map(rest, name, office)
    await rest.put_robot("tb1", robot)
    command = blocks(PAGE, "sh")[0]
    printed = await asyncio.to_thread(run_shell, f"export PPAAS_TOKEN={rest.token}\n{command}", tmp_path, cloud)
    assert "office-2" in printed
    robot = await rest.get("/v1/robots/tb1")
    assert (robot["map"], robot["initial_pose"]) == ("office-2", [2.0, 2.0, 0.0])


@pytest.mark.journey
async def test_a_robot_is_sent_to_a_floor_by_the_command_of_the_page(
    cloud: RunningCloud, office: GridMap, robot: RobotFile, tmp_path: Path
) -> None:
    rest = await cloud.admin()
    for name in ("office", "office-2"):
        await publish_map(rest, name, office)
    floors = (Floor(name="L1", map="office"), Floor(name="L2", map="office-2", elevation=3.0))
    await rest.put_building("office-house", json_of(Building(floors=floors)))
    await rest.put_robot("tb1", robot)
    assert rest.token is not None
    async with driving(cloud.url, rest.token, "tb1", office, Pose2D(*robot.initial_pose)) as drive:
        await until(lambda: bool(drive.poses))
        command = blocks(PAGE, "sh")[1]
        printed = await asyncio.to_thread(run_shell, f"export PPAAS_TOKEN={rest.token}\n{command}", tmp_path, cloud)
        assert '"id":"journey-' in printed
        goal = (await rest.get("/v1/robots/tb1/goals"))["items"][-1]
        async with patience(30.0):
            while goal["state"] == "active":
                await asyncio.sleep(0.2)
                goal = await rest.get(f"/v1/robots/tb1/goals/{goal['id']}")
        assert goal["state"] == "aborted", "no lift is drawn on these maps"
