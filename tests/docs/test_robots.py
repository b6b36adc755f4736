"""The robot scripts of robots.md drive to the goal of their operator, on simulated hardware."""

import ast
import asyncio
import itertools
import json
import os
import re
import shlex
import shutil
import sys
from pathlib import Path

import msgspec
import pytest

from ppaas.geometry import Pose2D
from ppaas.perception.depth_scan import DepthScanParameters
from ppaas.wire.ros import ros_types
from robots.bridges.core.tables import UpTopic
from robots.bridges.ros1.move_base import MOVE_BASE, ROS_1
from robots.client.move_base import MoveBaseClient
from robots.client.robot_client import RobotClient
from robots.client.robot_file import RobotFile, load_robot_file
from tests.support.cloud.cloud import RunningCloud
from tests.support.documents import ADDRESS, blocks, script, table, text_of
from tests.support.sources import ROOT

EXAMPLES = ROOT / "docs" / "examples"
PAGE = "docs/robots.md"
GOAL = Pose2D(3.5, 2.0, 0.0)


def commands() -> list[str]:
    return [line for line in script(PAGE).splitlines() if line.startswith("python ")]


def test_the_script_has_thirty_lines() -> None:
    module = ast.parse((EXAMPLES / "robot.py").read_text(encoding="utf-8"))
    module.body = module.body[1:]  # without its docstring
    assert len(ast.unparse(module).splitlines()) <= 30
    assert "thirty lines" in text_of(PAGE)


def test_each_robot_script_of_the_page_is_tested() -> None:
    assert [Path(shlex.split(line)[1]).name for line in commands()] == ["robot.py", "roslibpy_robot.py"]


def test_the_hardware_functions_are_those_that_the_scripts_use() -> None:
    described = {re.split(r"\W", function)[0] for function, _ in table(PAGE, "function", "what it does")}
    for name in ("robot.py", "roslibpy_robot.py"):
        assert set(re.findall(r"hardware\.(\w+)\(", (EXAMPLES / name).read_text(encoding="utf-8"))) == described


@pytest.mark.journey
@pytest.mark.parametrize("command", commands(), ids=["ours", "roslibpy"])
async def test_the_robot_drives_to_the_goal_of_its_operator(cloud: RunningCloud, tmp_path: Path, command: str) -> None:
    rest = await cloud.admin()
    assert rest.token is not None
    await rest.upload_map("office", *((EXAMPLES / f"office.{kind}").read_bytes() for kind in ("yaml", "pgm")))
    await rest.put_robot("tb1", load_robot_file(EXAMPLES / "tb1.json"))
    shutil.copy(ROOT / "tests" / "support" / "cloud" / "example_hardware.py", tmp_path / "hardware.py")
    truth = tmp_path / "truth.json"
    environment = os.environ | {
        "PYTHONPATH": str(tmp_path), "EXAMPLES": str(EXAMPLES), "SCORER": str(truth),
        "PPAAS_URL": cloud.url, "PPAAS_TOKEN": rest.token,
    }  # fmt: skip
    typed = command.replace(ADDRESS.replace("http", "ws"), cloud.ws_url).replace("$PPAAS_TOKEN", rest.token)
    robot = await asyncio.create_subprocess_exec(sys.executable, *shlex.split(typed)[1:], cwd=ROOT, env=environment)
    try:
        async with RobotClient(cloud.url, robot="tb1", token=rest.token, role="operator") as operator:
            move_base = await MoveBaseClient(operator).start()
            await move_base.localized()
            outcome = await move_base.go(GOAL, 60.0)
        assert robot.returncode is None
        assert outcome.reached, outcome
        assert Pose2D(*json.loads(truth.read_text())).distance_to(GOAL) < 0.3
    finally:
        robot.kill()
        await robot.wait()


def test_the_depth_camera_parameters_are_those_of_the_code() -> None:
    defaults = msgspec.structs.asdict(DepthScanParameters())
    listed = {}
    rows = table(PAGE, "parameter of the node", "default", "what it is")
    for names, values, _ in itertools.takewhile(lambda row: row[0], rows):
        listed |= dict(zip(re.findall(r"\w+", names), re.findall(r"[\w.]+", values), strict=True))
    assert listed == {
        name: f"{value:g}" if isinstance(value, float) else str(value) for name, value in defaults.items()
    }
    example = next(block for block in blocks(PAGE, "json") if "depthimage_to_laserscan" in block)
    robot = msgspec.json.decode(example, type=RobotFile)
    assert msgspec.convert(robot.parameters["depthimage_to_laserscan"], DepthScanParameters).scan_height == 10


ROS1_PAGE = text_of("docs/ros1.md")

NOT_OF_ROS_1 = {"goal_update", "dynamic_pose"}
"""Topics of Nav2 that a robot with ROS 1 may have, and that the page leaves out."""


@pytest.mark.parametrize("name", [*(one.name for one in ROS_1.down), *(one.name for one in ROS_1.services), MOVE_BASE])
def test_what_goes_to_the_robot_is_listed(name: str) -> None:
    assert f"`{name}`" in ROS1_PAGE


@pytest.mark.parametrize("topic", [one for one in ROS_1.up if one.cloud not in NOT_OF_ROS_1], ids=lambda one: one.cloud)
def test_what_goes_to_the_cloud_is_listed(topic: UpTopic) -> None:
    short = topic.names[0].removeprefix("camera/depth/").removeprefix("image_raw")
    assert f"`{topic.names[0]}`" in ROS1_PAGE or f"`{short}`" in ROS1_PAGE


def test_all_types_are_those_of_noetic() -> None:
    types = ros_types("noetic")
    assert all(types.knows(one.type) for one in (*ROS_1.up, *ROS_1.down, *ROS_1.services))
    assert types.md5("octomap_msgs/Octomap") == "9a45536b45c5e409cd49f04bb2d9999f"
