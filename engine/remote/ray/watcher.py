"""Watches a Ray cluster: ``python -m engine.remote.ray.watcher`` with a ``WatchConfig`` as a line of standard input.

It is a process of its own, since Ray ends whoever takes part in a cluster when the node it is on dies. It answers in
one line whether it is connected. After that a line on standard input names a machine whose agent is frozen, and an
empty one has all agents ended. The end of standard input ends the watcher alone: a cloud that was killed finds its
agents again when it is started anew.
"""

import logging
import os
import selectors
import sys

import msgspec

from engine.protocols.robot_link import Refusal
from engine.remote.ray.cluster import RayCluster
from engine.remote.ray.config import WatchAnswer, WatchConfig, WatchRefused, WatchStarted
from engine.remote.ray.supervisor import Supervisor
from ppaas.errors import PPaaSError

PERIOD = 0.25
"""Seconds between two looks at the cluster; Ray itself tells of a node that joined after a second or two."""


def serve(supervisor: Supervisor, commands: int) -> None:
    """Look after the cluster, and do what the file descriptor of commands says, until it ends or says so."""
    with selectors.DefaultSelector() as selector:
        selector.register(commands, selectors.EVENT_READ)
        rest = b""
        while True:
            if selector.select(PERIOD):
                read = os.read(commands, 4096)
                *lines, rest = (rest + read).split(b"\n")
                for line in filter(None, lines):
                    supervisor.kill_agent(line.decode())
                if b"" in lines:
                    supervisor.end_all()
                if not read or b"" in lines:
                    return
            supervisor.look()


def _read_line(file: int) -> bytes:
    # Not by a buffered file: it would read on, and what it had read would never show as ready.
    line = b""
    while not line.endswith(b"\n") and (byte := os.read(file, 1)):
        line += byte
    return line


def main() -> None:
    """Run with standard input and output as they are told of above."""
    logging.basicConfig(level=logging.INFO, format="%(levelname)s ray %(name)s: %(message)s")
    answers = os.dup(sys.stdout.fileno())
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # what Ray prints is no answer
    config = msgspec.json.decode(_read_line(sys.stdin.fileno()), type=WatchConfig)
    answer: WatchAnswer = WatchStarted()
    try:
        supervisor = Supervisor(RayCluster(config), config.cores)
    except PPaaSError as error:
        answer = WatchRefused(Refusal(error.slug, str(error)))
    os.write(answers, msgspec.json.encode(answer) + b"\n")
    if isinstance(answer, WatchRefused):
        sys.exit(1)
    serve(supervisor, sys.stdin.fileno())


if __name__ == "__main__":
    main()
