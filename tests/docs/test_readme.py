"""Commands and code of the README work as printed."""

import asyncio
import json
import re
from collections.abc import AsyncIterator
from pathlib import Path

import pytest

from ppaas import errors
from ppaas.geometry import Pose2D
from ppaas.messages.geometry_msgs import Twist
from ppaas.messages.nav_msgs import Odometry
from ppaas.messages.sensor_msgs import LaserScan
from robots.client.map_files import read_map_file
from robots.client.move_base import MoveBaseClient
from robots.client.robot_client import RobotClient
from robots.client.robot_file import load_robot_file
from robots.sim.simulator import Simulator
from robots.sim.world import World
from tests.support.cloud.cloud import RunningCloud
from tests.support.documents import ADDRESS, blocks, run_shell, script, text_of
from tests.support.sources import ROOT

README = "README.md"
EXAMPLES = ROOT / "docs" / "examples"


class Base:
    """The base of the reader's robot: here a simulated one."""

    def __init__(self) -> None:
        self.world = World(read_map_file(EXAMPLES / "office.yaml"))
        self._robot = self.world.add_robot(load_robot_file(EXAMPLES / "tb1.json").pose)

    @property
    def pose(self) -> Pose2D:
        return self._robot.base.pose

    def command(self, twist: Twist) -> None:
        self._robot.command(twist)

    async def readings(self) -> AsyncIterator[tuple[Odometry, LaserScan]]:
        while True:
            yield self._robot.odometry(), self._robot.scan()
            await asyncio.sleep(0.05)


def test_the_make_targets_exist() -> None:
    targets = re.findall(r"^make (\w+)", "\n".join(blocks(README, "sh")), re.MULTILINE)
    assert targets
    assert set(targets) <= set(re.findall(r"^(\w+):.*##", text_of("Makefile"), re.MULTILINE))


def test_the_extras_exist() -> None:
    project = text_of("pyproject.toml")
    named = {extra for found in re.findall(r"'\.\[([\w,]+)\]'", text_of(README)) for extra in found.split(",")}
    assert named == {"cloud", "plan", "sim"}
    assert all(f"\n{extra} = [" in project for extra in named)


def test_the_codes_are_those_of_the_errors() -> None:
    found = re.findall(r"(\d{3}) ([a-z ]+)[,.]", text_of(README).replace("\n", " "))
    by_code = {kind.code: kind for kind in errors.PlanningError.__subclasses__() if kind.code}
    assert found
    for code, words in found:
        assert set(words.split()) - {"the"} <= set(by_code[int(code)].slug.split("-")), words


@pytest.mark.journey
def test_the_shell_commands_end_with_a_plan(cloud: RunningCloud, tmp_path: Path) -> None:
    printed = run_shell(script(README), tmp_path, cloud)
    plan = json.loads(printed.splitlines()[-1])
    assert plan["poses"][0][:2] == pytest.approx([2.0, 2.0], abs=0.05)
    assert plan["poses"][-1][:2] == pytest.approx([10.0, 8.0], abs=0.05)
    assert plan["length"] > 10.0


@pytest.mark.journey
async def test_the_smallest_robot_drives_to_the_goal_of_its_operator(
    cloud: RunningCloud, monkeypatch: pytest.MonkeyPatch
) -> None:
    rest = await cloud.admin()
    assert rest.token is not None
    await rest.upload_map("office", *((EXAMPLES / f"office.{kind}").read_bytes() for kind in ("yaml", "pgm")))
    await rest.put_robot("tb1", load_robot_file(EXAMPLES / "tb1.json"))
    monkeypatch.setenv("PPAAS_TOKEN", rest.token)
    [code] = blocks(README, "python")
    names: dict[str, object] = {}
    exec(code.replace(ADDRESS, cloud.url), names)
    drive = names["drive"]
    assert callable(drive)
    base = Base()
    tasks = [asyncio.create_task(work) for work in (drive(base), Simulator(base.world).run())]
    async with RobotClient(cloud.url, robot="tb1", token=rest.token, role="operator") as operator:
        move_base = await MoveBaseClient(operator).start()
        await move_base.localized()
        outcome = await move_base.go(Pose2D(3.0, 2.0, 0.0), 60.0)
    for task in tasks:
        task.cancel()
    assert outcome.reached, outcome
    assert base.pose.distance_to(Pose2D(3.0, 2.0)) < 0.3
    for result in await asyncio.gather(*tasks, return_exceptions=True):
        assert isinstance(result, asyncio.CancelledError)
