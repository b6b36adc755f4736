"""The page about people: its tables of parameters, and the robot of another make, which takes part in a real cloud."""

import asyncio
import os
import re
import shlex
import shutil
import sys
from pathlib import Path
from typing import Any

import msgspec
import pytest

from ppaas.messages.sensor_msgs import CameraInfo, CompressedImage
from ppaas.nodes.frames import PERSON
from ppaas.nodes.people_tracker.parameters import PeopleTrackerParameters
from ppaas.nodes.people_tracker.readings import MOST_PEOPLE
from ppaas.nodes.topics import COMPRESSED_DEPTH_IMAGE, DEPTH_CAMERA_INFO
from ppaas.parameters import Parameters
from ppaas.people.clock_offsets import LATEST, TOLERANCE
from ppaas.people.coordinator.coordinator import LASTS, LATE, NEAR
from ppaas.people.coordinator.group import SLOWEST
from ppaas.people.coordinator.parameters import CoordinatorParameters
from ppaas.people.following.parameters import FollowParameters
from ppaas.people.rules.base import Candidate
from ppaas.people.rules.registry import rule_names
from ppaas.perception.compressed_depth import decompress
from ppaas.perception.legs.detector import MAP_MARGIN, STRIDING
from ppaas.perception.legs.parameters import LegDetectorParameters
from ppaas.perception.torso.parameters import TorsoDetectorParameters
from robots.client.robot_file import RobotFile, load_robot_file
from tests.support.cloud.cloud import RunningCloud
from tests.support.documents import ADDRESS, blocks, table, text_of
from tests.support.endpoints.rosbridge_server import rosbridge_server
from tests.support.sources import ROOT
from tests.support.waiting import patience

PAGE = "docs/people.md"
EXAMPLES = ROOT / "docs" / "examples"


@pytest.mark.parametrize(
    ("node", "defaults"),
    [
        ("torso_detector", TorsoDetectorParameters()),
        ("leg_detector", LegDetectorParameters()),
        ("people_tracker", PeopleTrackerParameters()),
        ("follow_person", FollowParameters()),
    ],
)
def test_parameters_are_those_of_the_code(node: str, defaults: Parameters) -> None:
    listed = {}
    for names, values, _ in table(PAGE, f"parameter of `{node}`", "default", "meaning"):
        read = msgspec.json.decode(f"[{values.strip('`')}]".replace("`", ""))
        listed |= dict(zip(re.findall(r"\w+", names), read, strict=True))
    known = msgspec.json.decode(msgspec.json.encode(defaults))
    assert listed == {name: round(value, 3) if isinstance(value, float) else value for name, value in known.items()}


def test_numbers_are_those_of_the_code() -> None:
    page = re.sub(r"\s+", " ", text_of(PAGE))
    assert f"Two legs nearer than {STRIDING:g} m" in page
    assert f"hits within {MAP_MARGIN:g} m" in page
    assert f"more than {MOST_PEOPLE} people" in page
    assert f"off by more than {TOLERANCE:g} s" in page
    assert f"more than {LATEST:g} s later" in page
    for name in ("1", "torso_1", "person_1", "user_1"):
        assert PERSON.fullmatch(f"tb1/{name}")


def test_rules_are_those_that_are_installed() -> None:
    assert {name.strip("`") for name, _ in table(PAGE, "rule", "who is followed")} == set(rule_names())


def test_the_rule_of_the_page_chooses() -> None:
    [code] = [block for block in blocks(PAGE, "python") if "PeopleRule" in block]
    names: dict[str, Any] = {}
    exec(compile(code, PAGE, "exec"), names)
    people = [Candidate(1, first_seen=5.0), Candidate(2, first_seen=9.0), Candidate(3, followed=True)]
    assert names["Newest"]().choose(people, [], 2) == [3, 2]


def test_times_and_distances_of_the_coordinator_are_those_of_the_code() -> None:
    page, values = re.sub(r"\s+", " ", text_of(PAGE)), CoordinatorParameters()
    assert f"or did in the last {values.seen_for:g} s" in page
    assert f"from all robots, up to {values.predict_for:g} s" in page
    assert f"over the last {values.switch_history:g} s, and is smaller" in page
    assert f"at most over the last {values.deviation_history:g} s" in page
    assert f"within {NEAR:g} m of each other for {LASTS:g} s" in page
    assert f"for {values.give_up_for:g} s, and one that handed over for {values.hold:g} s" in page
    assert f"late by more than {SLOWEST:g} s" in page
    assert f"After {values.report_timeout:g} s it sees nobody" in page
    assert f"after {LATE * values.report_timeout:g} s it hands over" in page
    assert f"after {values.robot_timeout:g} s it has left" in page
    assert values.forget_after == 60.0


def test_robot_files_of_the_page_are_valid() -> None:
    for block in (block for block in blocks(PAGE, "json") if '"map"' in block):
        robot = msgspec.json.decode(block, type=RobotFile)
        assert robot.map == "office"


async def test_the_robot_with_a_camera_sends_odometry_its_mount_and_images(tmp_path: Path) -> None:
    [script] = [block for block in blocks(PAGE, "sh") if "people_turtlebot.py" in block]
    shutil.copy(ROOT / "tests" / "support" / "cloud" / "example_camera.py", tmp_path / "hardware.py")
    async with rosbridge_server() as server:
        robot = await asyncio.create_subprocess_exec(
            sys.executable, *shlex.split(script)[1:], cwd=ROOT,
            env=os.environ | {"PYTHONPATH": str(tmp_path), "PPAAS_URL": server.url, "PPAAS_TOKEN": "t"},
        )  # fmt: skip
        try:
            sent: dict[str, Any] = {}
            number = 0
            while not {"odom", "tf_static", DEPTH_CAMERA_INFO.name, COMPRESSED_DEPTH_IMAGE.name} <= sent.keys():
                number += 1
                frame = (await server.heard("publish", number, timeout=60.0))[number - 1]
                sent[frame["topic"]] = frame["msg"]
        finally:
            robot.kill()
            await robot.wait()
    view = msgspec.convert(sent[DEPTH_CAMERA_INFO.name], CameraInfo)
    image = msgspec.convert(sent[COMPRESSED_DEPTH_IMAGE.name], CompressedImage)
    assert decompress(image.format, image.data).shape == (view.height, view.width)
    frames = [transform["child_frame_id"] for transform in sent["tf_static"]["transforms"]]
    assert frames == ["camera_depth_frame", view.header.frame_id]


def test_the_registered_turtlebots_are_valid_and_find_and_follow_people() -> None:
    robot = load_robot_file(EXAMPLES / "turtlebot.json")
    assert {"depthimage_to_laserscan", "torso_detector", "follow_person"} == robot.parameters.keys()
    functions = {name for row in table(PAGE, "function", "what it does") for name in re.findall(r"(\w+)\(", row[0])}
    program = (EXAMPLES / "people_turtlebot.py").read_text(encoding="utf-8")
    assert set(re.findall(r"hardware\.(\w+)\(", program)) == functions


@pytest.mark.journey
async def test_the_robot_of_another_make_and_its_people_are_counted(cloud: RunningCloud) -> None:
    [script] = [block for block in blocks(PAGE, "sh") if "people_robot.py" in block]
    rest = await cloud.admin()
    assert rest.token is not None
    await rest.upload_map("office", *((EXAMPLES / f"office.{kind}").read_bytes() for kind in ("yaml", "pgm")))
    await rest.put_robot("guide", load_robot_file(EXAMPLES / "guide.json"))
    typed = script.splitlines()[-1].replace(ADDRESS.replace("http", "ws"), cloud.ws_url)
    robot = await asyncio.create_subprocess_exec(
        sys.executable, *shlex.split(typed)[1:],
        cwd=ROOT, env=os.environ | {"PPAAS_TOKEN": rest.token}, stdout=asyncio.subprocess.PIPE,
    )  # fmt: skip
    try:
        assert robot.stdout is not None
        async with patience(60.0):
            async for line in robot.stdout:
                if line.startswith(b"2 people on the map"):
                    break
            else:
                pytest.fail("the script ended before it saw two people")
    finally:
        robot.kill()
        await robot.wait()
