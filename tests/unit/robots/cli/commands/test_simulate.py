"""One simulated robot against a running cloud."""

import argparse
import asyncio
import logging
from pathlib import Path

import pytest

from ppaas.errors import InvalidParameter, NotAuthenticated, NotFound
from ppaas.geometry import Pose2D
from ppaas.maps.formats.map_files import save_map
from robots.cli.command_parser import CommandParser
from robots.cli.commands import simulate
from robots.client.move_base import MoveBaseClient
from robots.client.rest import RestClient
from robots.client.robot_client import RobotClient
from robots.client.robot_file import RobotFile
from robots.demo.cloud_process import CloudProcess
from tests.support.waiting import patience
from tests.support.world.rooms import room

GRID = room(6.0, 6.0)


def parse(folder: Path, *more: str) -> argparse.Namespace:
    """Write a robot file and a map; return the command's arguments for them."""
    yaml, image = save_map(GRID, "room.pgm")
    (folder / "room.yaml").write_bytes(yaml)
    (folder / "room.pgm").write_bytes(image)
    robot = RobotFile(map="room", initial_pose=(2.0, 2.0, 0.5), cores=0.5)
    (folder / "rover.json").write_bytes(robot.encode())
    parser = CommandParser()
    simulate.configure(parser)
    return parser.parse_args([str(folder / "rover.json"), "--map", str(folder / "room.yaml"), *more])


def test_a_missing_token_error_names_the_login_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("PPAAS_TOKEN", raising=False)
    with pytest.raises(NotAuthenticated, match="ppaas login"):
        simulate.run(parse(tmp_path))


def test_an_unknown_local_node_is_refused_with_the_known_ones(tmp_path: Path) -> None:
    with pytest.raises(NotFound, match=r"unknown local node 'map_server'; known: amcl, auto, depth.*, move_base"):
        simulate.run(parse(tmp_path, "--token", "t", "--local-nodes", "amcl,map_server"))


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        (("a.json", "b.json", "--map", "m.yaml"), "several robots and --record go with --building"),
        (("a.json", "--map", "m.yaml", "--record", "r.json"), "several robots and --record go with --building"),
        (("a.json", "--building", "house", "--docks", "z.geojson"), "leave out --docks and --local-nodes"),
        (("a.json", "b.json", "--building", "house", "--id", "a"), "--id names one robot"),
    ],
)
def test_options_that_do_not_go_together_are_refused(arguments: tuple[str, ...], text: str) -> None:
    parser = CommandParser()
    simulate.configure(parser)
    with pytest.raises(InvalidParameter, match=text):
        simulate.run(parser.parse_args(list(arguments)))


def test_a_robot_needs_a_map_or_a_building() -> None:
    parser = CommandParser()
    simulate.configure(parser)
    for more in ((), ("--map", "m.yaml", "--building", "house")):
        with pytest.raises(SystemExit):
            parser.parse_args(["a.json", *more])


@pytest.mark.journey
async def test_a_simulated_robot_with_local_move_base_reaches_its_goal(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.INFO)
    async with CloudProcess() as cloud:
        url = cloud.ready.url
        rest = RestClient(url)
        await rest.login(cloud.ready.admin_user, cloud.password)
        await rest.upload_map("room", *save_map(GRID, "room.pgm"))
        assert rest.token is not None
        wanted = ("--url", url, "--token", rest.token, "--local-nodes", "move_base")
        simulating = asyncio.create_task(simulate._run(parse(tmp_path, *wanted)))
        async with patience(30):
            while not simulating.done() and not await rest.items("/v1/robots"):
                await asyncio.sleep(0.05)
        async with RobotClient(url, robot="rover", token=rest.token, role="operator") as operator:
            move_base = await MoveBaseClient(operator).start()
            estimate = await move_base.localized()
            assert estimate.distance_to(Pose2D(2.0, 2.0)) < 0.5
            async with patience(60):
                while "move_base runs on the robot: a client requested this home" not in caplog.messages:
                    await asyncio.sleep(0.05)
            outcome = await move_base.go(Pose2D(4.0, 4.0, 0.0), 60.0)
            assert outcome.reached, outcome
            assert move_base.estimate is not None
            assert move_base.estimate.distance_to(Pose2D(4.0, 4.0)) < 0.3
            simulating.cancel()
            await asyncio.gather(simulating, return_exceptions=True)
            homes = {node["node"]: node["home"] for node in await rest.items("/v1/robots/rover/nodes")}
            assert homes["move_base"] == "cloud", "a robot that leaves returns its nodes to the cloud"
