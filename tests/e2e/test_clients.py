"""Unmodified clients of rosbridge, old and new, do the same job: look around, cancel one goal and reach another.

Those for ROS 1 use the topics of Move Base's action; those for ROS 2 use actions of rosbridge, and types and stamps as
in ROS 2. ``make test-clients`` installs and builds the clients. ROS# runs on .NET, so its frames stand for it
(``tests/support/clients/ros_sharp.py``).
"""

import json
import re
import shutil
import sys
import tomllib
from pathlib import Path
from typing import NamedTuple

import pytest

from ppaas.maps.grid import GridMap
from tests.support.cloud.client_script import Operated, operating
from tests.support.cloud.cloud import RunningCloud
from tests.support.sources import ROOT

pytestmark = [pytest.mark.journey, pytest.mark.clients]

SCRIPTS = ROOT / "tests" / "support" / "clients"
NODE = Path(__file__).parent / "roslib"
RUST = Path(__file__).parent / "roslibrust"
BUILT = ROOT / "build" / "clients"
FEEDBACK = {1: {"base_position"}, 2: {"current_pose", "estimated_time_remaining", "distance_remaining"}}
"""Fields of the feedback of Move Base's action and of Nav2's, by the version of ROS."""

FOLLOWED = ["succeeded", ["distance_to_goal", "speed", "tracking_feedback"]]
"""End of FollowPath, and the fields of its feedback, of a client that follows a path."""


class Client(NamedTuple):
    """Client library: its version of ROS, the command that runs it, its PYTHONPATH, and the file that it needs."""

    ros: int
    command: tuple[str, ...]
    python_path: Path = ROOT
    needs: Path = ROOT
    tool: str = ""


def roslibpy(ros: int, python_path: Path) -> Client:
    return Client(ros, (sys.executable, str(SCRIPTS / f"roslibpy_{ros}.py")), python_path)


def roslib(ros: int, package: str) -> Client:
    return Client(ros, ("node", str(NODE / f"client_{ros}.mjs")), needs=NODE / "node_modules" / package, tool="Node 20")


def roslibrust() -> Client:
    binary = BUILT / "roslibrust" / "debug" / "roslibrust-client"
    return Client(1, (str(binary),), needs=binary, tool="cargo")


def ros_sharp(ros: int, transport: str) -> Client:
    return Client(ros, (sys.executable, "-m", f"tests.support.clients.ros_sharp_{ros}", transport))


CLIENTS = {
    "roslibpy-1.8": roslibpy(1, BUILT / "roslibpy-1"),
    "roslibpy-2.1": roslibpy(2, ROOT),
    "roslib-1.4": roslib(1, "roslib-1"),
    "roslib-2.1": roslib(2, "roslib"),
    "roslibrust-0.26": roslibrust(),
    "ROS#-WebSocketSharp": ros_sharp(1, "WebSocketSharp"),
    "ROS#-WebSocketUWP": ros_sharp(1, "WebSocketUWP"),
    "ROS#-WebSocketNet": ros_sharp(2, "WebSocketNet"),
}


@pytest.mark.parametrize("name", CLIENTS)
async def test_a_client_drives_a_robot(name: str, cloud: RunningCloud, office_map: GridMap) -> None:
    client = CLIENTS[name]
    if shutil.which(client.command[0]) is None or not client.needs.exists():
        pytest.skip(f"{name} is not built: install {client.tool} and run make test-clients")
    robot, path = "tb-" + re.sub(r"\W", "-", name), str(client.python_path)
    async with operating(client.command, cloud, office_map, robot, 41, PYTHONPATH=path) as operated:
        check(operated, client.ros, office_map)
        if name == "roslib-1.4":
            assert operated.found.told["raw"] is True, "the map of cbor-raw is that of JSON"


def check(operated: Operated, ros: int, grid: GridMap) -> None:
    found, errors = operated.found
    assert errors == b"", errors.decode()
    assert {"/cmd_vel", "/map", "/scan"} <= set(found["topics"])
    assert {"/move_base/make_plan", "/rosapi/topics"} <= set(found["services"])
    assert found["cells"] == [grid.data.size, grid.data.size]
    assert found["pose"] == pytest.approx([operated.start.x, operated.start.y], abs=0.3)
    assert found["plan"] > 2
    assert set(found["feedback"]) >= FEEDBACK[ros]
    assert found["ends"] == ["cancelled", "succeeded"]
    assert found.get("followed", FOLLOWED) == FOLLOWED
    assert operated.drive.scorer.error(0, operated.near) <= 0.25


def test_the_versions_are_pinned() -> None:
    locked = (ROOT / "deploy" / "requirements.lock").read_text(encoding="utf-8")
    roslibpy = re.findall(r"^roslibpy==([\d.]+)", (SCRIPTS / "roslibpy_1.lock").read_text("utf-8") + locked, re.M)
    roslib = json.loads((NODE / "package.json").read_text(encoding="utf-8"))["dependencies"]
    roslibrust = tomllib.loads((RUST / "Cargo.toml").read_text(encoding="utf-8"))["dependencies"]["roslibrust"]
    assert (roslibpy, roslibrust["version"]) == (["1.8.1", "2.1.0"], "=0.26.0")
    assert {name: roslib[name] for name in ("roslib-1", "roslib")} == {
        "roslib-1": "npm:roslib@1.4.1", "roslib": "2.1.0",
    }  # fmt: skip
