"""The client of MicroPython, in a heap of 32 kB, against a server that plays the cloud."""

import asyncio
import json
from asyncio.subprocess import PIPE
from pathlib import Path
from typing import Any

import pytest
from websockets.asyncio.server import ServerConnection

from tests.support.cloud.board_robot import HEAP, compile_for_board, micropython
from tests.support.cloud.board_scenes import (
    CMD_VEL,
    drive_on,
    move_container,
    playing,
    published,
    receive_until,
    refuse_token,
)

pytestmark = pytest.mark.skipif(
    micropython() is None, reason="MicroPython is not installed: it has wheels for Linux only"
)

SCRIPT = """
import sys, time
from ppaas_robot import Refused, Robot
said = print
robot = Robot("127.0.0.1", int(sys.argv[1]), "tb1", "t0ken", 3, lambda *v: said("drive", *v), 300)
robot.on_status = lambda text: said("status", text)
robot.laser(-1.0, 0.5, 120, 8000, "base_scan")
robot.subscribe("/amcl_pose", lambda pose: said("pose", pose["x"]))
try:
    until = time.ticks_add(time.ticks_ms(), int(sys.argv[2]))
    while time.ticks_diff(until, time.ticks_ms()) > 0:
        if robot.poll() and robot.ranges[0] == 0:
            robot.ranges[0], robot.ranges[1], robot.ranges[2] = 1500, 0, 65535
            robot.send_odom(1.0, 2.0, 0.5, 0.25, 0.0, -0.5, 7)
            robot.send_scan(8)
        time.sleep_ms(10)
    robot.leave()
except Refused as error:
    said("refused", error)
"""


@pytest.fixture
async def folder(tmp_path: Path) -> Path:
    await compile_for_board(tmp_path)
    (tmp_path / "robot.py").write_text(SCRIPT)
    return tmp_path


async def run(folder: Path, port: int, milliseconds: int = 1500) -> list[str]:
    """Return the lines that the board printed in this time."""
    board = await asyncio.create_subprocess_exec(
        str(micropython()), "-X", f"heapsize={HEAP}", "robot.py", str(port), str(milliseconds), cwd=folder, stdout=PIPE
    )
    output, _ = await board.communicate()
    return output.decode().splitlines()


async def test_a_board_says_what_it_measures_and_drives_as_it_is_told(folder: Path) -> None:
    heard: list[Any] = []
    closed: list[Any] = []

    async def scene(socket: ServerConnection) -> None:
        heard.extend(await receive_until(socket, 4))
        await socket.send(published("map", {"data": [0] * 50_000}))
        await socket.send(published("amcl_pose", {"x": 3}))
        await socket.send(json.dumps({"op": "status", "level": "error", "msg": "not-found: x", "id": None}))
        await socket.send(CMD_VEL)
        await (await socket.ping())
        await socket.wait_closed()
        closed.extend((socket.close_code, socket.close_reason))

    async with playing(scene) as cloud:
        lines = await run(folder, cloud.port, 1200)
    assert cloud.paths == ["/?robot=tb1&status=1&compact=1&session=board&resume=none"]
    assert [(each["op"], each["topic"]) for each in heard] == [
        ("subscribe", "cmd_vel"), ("subscribe", "amcl_pose"), ("publish", "odom"), ("publish", "scan"),
    ]  # fmt: skip
    odom, scan = heard[2]["msg"], heard[3]["msg"]
    assert (odom["pose"]["pose"]["position"]["y"], odom["twist"]["twist"]["angular"]["z"]) == (2.0, -0.5)
    assert (scan["ranges"], scan["angle_max"], scan["range_min"]) == ([1.5, 0.0, None], 0.0, 0.12)
    assert (scan["header"]["frame_id"], scan["header"]["stamp"]["nsecs"]) == ("base_scan", 8_000_000)
    assert lines[:3] == ["pose 3", "status not-found: x", "drive 0.25 0.0 -0.5"]
    assert lines[3:] == ["drive 0.0 0.0 0.0"], "it stops when no velocity comes, and once"
    assert closed == [1000, "left"]


async def test_a_board_resumes_its_session_with_the_number_of_frames_it_received(folder: Path) -> None:
    async with playing(move_container, drive_on) as cloud:
        lines = await run(folder, cloud.port, 1200)
    assert cloud.paths[1].endswith("&resume=abc.2")
    drive, stop = "drive 0.25 0.0 -0.5", "drive 0.0 0.0 0.0"
    assert lines[:3] == [drive, stop, drive], "it stops when the connection is lost"


@pytest.mark.parametrize(("code", "reason"), [(1008, "not-authenticated: expired"), (1011, "conflict: x"), (4409, "x")])
async def test_a_board_gives_up_where_it_must_not_connect_again(folder: Path, code: int, reason: str) -> None:
    async def scene(socket: ServerConnection) -> None:
        await socket.close(code, reason)

    async with playing(scene) as cloud:
        assert await run(folder, cloud.port, 5000) == [f"refused {code} {reason}"]


async def test_a_board_says_why_the_handshake_was_refused(folder: Path) -> None:
    async with playing(process_request=refuse_token) as cloud:
        [line] = await run(folder, cloud.port, 5000)
    assert line.startswith("refused 401") and "the token is unknown" in line


LOGIN = """
import sys
from ppaas_robot import Refused, login
try:
    print(login("127.0.0.1", int(sys.argv[1]), "ann", "secret"))
except Refused as error:
    print("refused", error)
"""


@pytest.mark.parametrize(
    ("answer", "line"),
    [
        (b'HTTP/1.1 201 Created\r\n\r\n{"token": "t0ken"}', "t0ken"),
        (b"HTTP/1.1 401 No\r\n\r\nwrong", "refused 401 b'wrong'"),
    ],
)
async def test_a_board_logs_in_with_a_password(folder: Path, answer: bytes, line: str) -> None:
    heard: list[bytes] = []

    async def respond(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        heard.append(await reader.readuntil(b"}"))
        writer.write(answer)
        writer.close()

    (folder / "robot.py").write_text(LOGIN)
    async with await asyncio.start_server(respond, "127.0.0.1", 0) as server:
        assert await run(folder, server.sockets[0].getsockname()[1]) == [line]
    assert heard[0].startswith(b"POST /v1/tokens HTTP/1.0\r\n")
    assert json.loads(heard[0].split(b"\r\n\r\n")[1]) == {"user": "ann", "password": "secret"}


async def test_large_topics_are_refused(folder: Path) -> None:
    script = SCRIPT.replace('"/amcl_pose"', '"local_costmap/costmap"')
    (folder / "robot.py").write_text(f"try:\n  exec({script!r})\nexcept ValueError as error:\n  print(error)\n")
    assert await run(folder, 1) == ["local_costmap/costmap is too large for this board"]
