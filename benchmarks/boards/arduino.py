"""The client for Arduino, compiled for this computer: its memory, and the time of its work."""

import json
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import Any

import robots
from benchmarks.harness.figures import Figure
from ppaas.errors import Unavailable

PROGRAM = Path(__file__).with_name("arduino_program.cpp")
HEADER = Path(robots.__file__).parent / "arduino"

ROUNDS, QUICK_ROUNDS = 1_000_000, 10_000
"""Number of scans, of odometry and of velocities."""

MOST_RAM = 20_000
"""RAM of a small board [bytes]."""

PART = "Arduino"


def measure(*, quick: bool) -> list[Figure]:
    """Return the figures of the client for Arduino."""
    if shutil.which("g++") is None:
        raise Unavailable("g++ is not installed, which compiles the client for Arduino")
    with tempfile.TemporaryDirectory() as folder:
        made = f"{folder}/board"
        _run("g++", "-std=c++17", "-O2", "-fno-exceptions", "-I", str(HEADER), "-o", made, str(PROGRAM))
        figures: dict[str, Any] = json.loads(_run(made, str(QUICK_ROUNDS if quick else ROUNDS)))
    nanoseconds = {name: round(figures[name], 1) for name in ("text", "scan", "odometry", "velocity")}
    yardstick, modem = nanoseconds.pop("text"), "on this computer, without the modem"
    return [
        Figure(PART, "scan of 360 beams as text, without the client", yardstick, "ns", yardstick=True, note="snprintf"),
        Figure(PART, "scan of 360 beams, sent", nanoseconds["scan"], "ns", limit=yardstick, note=modem),
        Figure(PART, "odometry, sent", nanoseconds["odometry"], "ns", note=modem),
        Figure(PART, "velocity, read", nanoseconds["velocity"], "ns", note=modem),
        Figure(PART, "RAM of a robot", figures["size"], "bytes", limit=MOST_RAM, note="of 64 bits; a board's is less"),
    ]


def _run(*command: str) -> str:
    """Return the output of a program; raises ``Unavailable`` if it failed."""
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    if result.returncode != 0:
        raise Unavailable(f"{command[0]} failed: {result.stderr[-500:]}")
    return result.stdout
