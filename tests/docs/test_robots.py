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
