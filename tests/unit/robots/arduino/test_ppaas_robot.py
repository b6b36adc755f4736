"""The client for Arduino, compiled for this computer, against a server that plays the cloud."""

import asyncio
import json
import shutil
import subprocess
from asyncio.subprocess import PIPE
from pathlib import Path
from typing import Any

import pytest
from websockets.asyncio.server import ServerConnection

from tests.support.cloud.board_robot import ARDUINO, PROGRAMS, STRICT, in_cpp
from tests.support.cloud.board_scenes import (
    CMD_VEL,
    drive_on,
    move_container,
    playing,
    published,
    receive_until,
    refuse_token,
)

pytestmark = pytest.mark.skipif(shutil.which("g++") is None, reason="g++ is not installed")

DRIVE, STOP = "drive 0.25 0.0 -0.5", "drive 0.00 0.0 0.0"


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> str:
    [made] = asyncio.run(in_cpp(tmp_path_factory.mktemp("arduino"), "arduino_scenes"))
    return made


async def run(program: str, port: int, milliseconds: int = 1200) -> list[str]:
    """Return the lines that the board printed in this time."""
    board = await asyncio.create_subprocess_exec(program, str(port), str(milliseconds), stdout=PIPE)
    output, _ = await board.communicate()
    return output.decode().splitlines()


async def test_a_board_says_what_it_measures_and_drives_as_it_is_told(program: str) -> None:
    heard: list[Any] = []
    closed: list[Any] = []

    async def scene(socket: ServerConnection) -> None:
        heard.extend(await receive_until(socket, 4))
        await socket.send(published("map", {"data": [0] * 50_000}))
        await socket.send(published("amcl_pose", {"x": 3}))
        await socket.send(CMD_VEL)
        await (await socket.ping())
        await socket.wait_closed()
        closed.extend((socket.close_code, socket.close_reason))

    async with playing(scene) as cloud:
        lines = await run(program, cloud.port)
    assert cloud.paths == ["/?robot=tb1&status=1&compact=1&session=board&resume=none"]
    assert [(each["op"], each["topic"]) for each in heard] == [
        ("subscribe", "cmd_vel"), ("subscribe", "amcl_pose"), ("publish", "odom"), ("publish", "scan"),
    ]  # fmt: skip
    odom, scan = heard[2]["msg"], heard[3]["msg"]
    assert (odom["pose"]["pose"]["position"]["y"], odom["twist"]["twist"]["angular"]["z"]) == (2.0, -0.5)
    assert odom["header"]["stamp"]["nsecs"] == 7_000_000
    assert (scan["ranges"], scan["angle_max"], scan["range_min"]) == ([1.5, 0.0, None], 0.0, 0.12)
    assert (scan["header"]["frame_id"], scan["header"]["stamp"]["nsecs"]) == ("base_scan", 8_000_000)
    assert json.loads(lines[0].removeprefix("text "))["msg"] == {"x": 3}
    assert lines[1:] == [DRIVE, STOP], "it stops when no velocity comes, and once"
    assert closed == [1000, "left"]


async def test_a_board_resumes_its_session_with_the_number_of_messages_it_received(program: str) -> None:
    async with playing(move_container, drive_on) as cloud:
        lines = await run(program, cloud.port)
    assert cloud.paths[1].endswith("&resume=abc.2")
    assert lines[:3] == [DRIVE, STOP, DRIVE], "it stops when the connection is lost"


@pytest.mark.parametrize(("code", "reason"), [(1008, "not-authenticated: expired"), (1011, "conflict: x"), (4409, "x")])
async def test_a_board_gives_up_where_it_must_not_connect_again(program: str, code: int, reason: str) -> None:
    async def scene(socket: ServerConnection) -> None:
        await socket.close(code, reason)

    async with playing(scene) as cloud:
        assert await run(program, cloud.port, 5000) == [f"refused {code} {reason}"]


async def test_a_board_says_why_the_handshake_was_refused(program: str) -> None:
    async with playing(process_request=refuse_token) as cloud:
        assert await run(program, cloud.port, 5000) == ["text the token is unknown", "refused HTTP status 401"]


def test_the_header_needs_neither_exceptions_nor_the_heap(tmp_path: Path) -> None:
    made = tmp_path / "board.o"
    command = ["g++", *STRICT, "-Os", "-I", str(ARDUINO), "-c", "-o", str(made), str(PROGRAMS / "arduino_board.cpp")]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
    needed = made.read_bytes()
    assert not any(name in needed for name in (b"malloc", b"_Znw", b"_Zda", b"__cxa_throw"))
