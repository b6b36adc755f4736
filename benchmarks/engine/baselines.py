"""Baselines of the engine bench: start of a Python process, a fork that answers a byte, and an echo of a byte.

``python -m benchmarks.engine.baselines forks|echoes COUNT`` prints the time of each repetition [s]. It runs in its own
process with one thread, since a fork of a process with threads takes longer.
"""

import asyncio
import os
import socket
import sys

import msgspec

from benchmarks.harness.figures import Figure, median_of
from ppaas.clock import monotonic
from ppaas.decoding import from_json

NOTHING = (sys.executable, "-c", "pass")


def main() -> int:
    """Measure one baseline and print the time of each repetition."""
    kind, count = sys.argv[1], int(sys.argv[2])
    seconds = {"forks": _fork_often, "echoes": _echo_often}[kind](count)
    sys.stdout.write(msgspec.json.encode(seconds).decode())
    return 0


def _fork_often(count: int) -> list[float]:
    return [_fork_and_hear() for _ in range(count)]


def _echo_often(count: int) -> list[float]:
    ours, theirs = socket.socketpair()
    if not os.fork():
        ours.close()
        while byte := theirs.recv(1):
            theirs.send(byte)
        os._exit(0)
    theirs.close()
    with ours:
        seconds = [_echo(ours) for _ in range(count)]
    os.wait()
    return seconds


def _echo(there: socket.socket) -> float:
    began = monotonic()
    there.send(b"1")
    there.recv(1)
    return monotonic() - began


def _fork_and_hear() -> float:
    began = monotonic()
    reading, writing = os.pipe()
    child = os.fork()
    if not child:
        os.write(writing, b"1")
        os._exit(0)
    os.read(reading, 1)
    took = monotonic() - began
    os.close(reading)
    os.close(writing)
    os.waitpid(child, 0)
    return took


async def python() -> float:
    """Return the time of an empty Python process, from start to exit [s]."""
    began = monotonic()
    process = await asyncio.create_subprocess_exec(*NOTHING)
    await process.wait()
    return monotonic() - began


async def forks(count: int) -> list[float]:
    """Return the times until a forked child answered, for ``count`` forks in another process [s]."""
    return await _measured("forks", count)


async def echoes(count: int) -> list[float]:
    """Return the times to send a byte to a process and back, for ``count`` repetitions [s]."""
    return await _measured("echoes", count)


async def _measured(kind: str, count: int) -> list[float]:
    command = (sys.executable, "-m", __spec__.name, kind, str(count))
    process = await asyncio.create_subprocess_exec(*command, stdout=asyncio.subprocess.PIPE)
    told, _ = await process.communicate()
    return from_json(told, list[float])


def python_figure(part: str, started: list[float]) -> Figure:
    """Return the figure of empty Python processes."""
    return median_of(part, "python -c pass", started, yardstick=True, note="fork, exec and a bare interpreter")


def figures(part: str, started: list[float], forked: list[float]) -> list[Figure]:
    """Return the baselines for the start of a container."""
    return [
        python_figure(part, started),
        median_of(part, "fork, answered", forked, yardstick=True, note="os.fork of a small process, a byte by a pipe"),
    ]


if __name__ == "__main__":
    sys.exit(main())
