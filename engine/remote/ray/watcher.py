"""Watcher of a Ray cluster: ``python -m engine.remote.ray.watcher``.

It reads a ``WatchConfig`` as one line of JSON from standard input. It is a separate process, since Ray ends the
processes that are connected to a node when that node dies. It writes one line, which says whether it is connected. Then
each line on standard input names a machine whose agent is frozen; an empty line stops all agents. At the end of
standard input only the watcher exits: a killed cloud finds its agents again when it is restarted.
"""

import logging
import os
import selectors
import sys

import msgspec

from engine.protocols.refusals import Refusal
from engine.remote.ray.cluster import RayCluster
from engine.remote.ray.config import WatchAnswer, WatchConfig, WatchRefused, WatchStarted
from engine.remote.ray.supervisor import Supervisor
from ppaas.decoding import from_json
from ppaas.errors import PPaaSError
from ppaas.log_lines import log_lines

PERIOD = 0.25
"""Time between two checks of the cluster [s]; Ray itself reports a new node after a second or two."""


def serve(supervisor: Supervisor, commands: int) -> None:
    """Supervise the cluster and execute the commands of a file descriptor, until its end or a command to stop."""
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
            supervisor.reconcile()


def _read_line(file: int) -> bytes:
    # A buffered file would read ahead, and the selector would not see the lines in its buffer.
    line = b""
    while not line.endswith(b"\n") and (byte := os.read(file, 1)):
        line += byte
    return line


def main() -> None:
    """Run the watcher, with standard input and output as described above."""
    log_lines("%(levelname)s ray %(name)s: %(message)s", process="ray", level=logging.INFO)
    answers = os.dup(sys.stdout.fileno())
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # keeps Ray's output out of the answers
    config = from_json(_read_line(sys.stdin.fileno()), WatchConfig)
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
