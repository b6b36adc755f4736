"""Commands of floors.md are run as they stand."""

import asyncio
from pathlib import Path
from typing import Any

import pytest

from ppaas.buildings.building import Building, Floor, json_of
from ppaas.geometry import Pose2D
from ppaas.maps.formats.map_files import load_map
from ppaas.maps.grid import GridMap
from robots.cli.command_parser import CommandParser
from robots.cli.commands import demo
from robots.client.robot_file import RobotFile, load_robot_file
from robots.demo.cloud_process import free_port
from tests.support.cloud.cloud import RunningCloud, publish_map
from tests.support.cloud.drive import driving
from tests.support.cloud.floors import GROUND, LOFT, START, ZONES, simulated_building
from tests.support.documents import blocks, run_shell
from tests.support.waiting import patience, until

PAGE = "docs/floors.md"
MOVE, SEND, DEMO, SIMULATE = range(4)
"""Blocks of commands of the page."""


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
    command = blocks(PAGE, "sh")[MOVE]
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
        command = blocks(PAGE, "sh")[SEND]
        printed = await asyncio.to_thread(run_shell, f"export PPAAS_TOKEN={rest.token}\n{command}", tmp_path, cloud)
        assert '"id":"journey-' in printed
        goal = (await rest.get("/v1/robots/tb1/goals"))["items"][-1]
        async with patience(30.0):
            while goal["state"] == "active":
                await asyncio.sleep(0.2)
                goal = await rest.get(f"/v1/robots/tb1/goals/{goal['id']}")
        assert goal["state"] == "aborted", "no lift is drawn on these maps"


def test_the_commands_of_the_demo_are_valid() -> None:
    parser = CommandParser()
    demo.configure(parser)
    for line in blocks(PAGE, "sh")[DEMO].splitlines():
        parsed = parser.parse_args(line.split()[2:])
        assert parsed.show == demo.BUILDING


@pytest.mark.journey
async def test_a_building_of_the_cloud_is_simulated_by_the_commands_of_the_page(
    cloud: RunningCloud, tmp_path: Path
) -> None:
    rest, port = await cloud.admin(), free_port()
    command = blocks(PAGE, "sh")[SIMULATE].replace("--record", f"--device-port {port} --record")
    # Tests of journeys wait for the rides of robots.
    command = "".join(line for line in command.splitlines(keepends=True) if "inn-L2 reached" not in line)
    printed = await asyncio.to_thread(run_shell, f"export PPAAS_TOKEN={rest.token}\n{command}", tmp_path, cloud)
    assert '"id":"journey-' in printed
    [goal] = (await rest.get("/v1/robots/porter/goals"))["items"]
    assert (goal["state"], goal["pose"]) == ("active", [5.5, -3.5, 0.0])
    [lift] = (await rest.get("/v1/buildings/inn"))["building"]["lifts"]
    assert lift["device"] == f"http://127.0.0.1:{port}/lifts/north"


async def test_the_program_of_the_page_simulates_a_building(capsys: pytest.CaptureFixture[str]) -> None:
    [code] = blocks(PAGE, "python")
    names: dict[str, Any] = {}
    exec(code, names)
    maps, zones = {"L1": GROUND, "L2": LOFT}, {"L1": ZONES, "L2": ZONES}
    running = asyncio.create_task(names["simulate"](simulated_building().layout.building, maps, zones, START))
    await until(lambda: running.done() or "http://127.0.0.1:" in capsys.readouterr().out)
    assert not running.done()
    running.cancel()
    await asyncio.gather(running, return_exceptions=True)
