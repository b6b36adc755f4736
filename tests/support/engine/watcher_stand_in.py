"""Script that replaces the watcher of a Ray cluster: it writes down its input.

For the host ``refuse`` it refuses the connection, for ``crash`` it exits without an answer, for any other it connects
and runs until the end of its input.
"""

import os
import sys
from pathlib import Path

import msgspec

from engine.protocols.refusals import Refusal
from engine.remote.ray.config import WatchConfig, WatchRefused, WatchStarted


def main() -> None:
    config = msgspec.json.decode(sys.stdin.readline(), type=WatchConfig)
    notes = Path(config.folder) / "watchers"
    with notes.open("a") as file:
        file.write(f"{os.getpid()}\n")
    if config.host == "crash":
        sys.exit(3)
    refused = config.host == "refuse"
    answer = WatchRefused(Refusal("unavailable", "wrong token")) if refused else WatchStarted()
    sys.stdout.write(msgspec.json.encode(answer).decode() + "\n")
    sys.stdout.flush()
    if refused:
        sys.exit(1)
    for line in sys.stdin:
        with notes.open("a") as file:
            file.write(line.strip() or "end all")
            file.write("\n")


if __name__ == "__main__":
    main()
