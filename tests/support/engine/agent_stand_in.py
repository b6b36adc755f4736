"""Script that replaces an agent: it writes down its process id and behaves as the name of its machine says.

``stay`` exits on SIGTERM, ``stubborn`` ignores it and has a child, ``die`` exits at once.
"""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import msgspec

from engine.agent.config import AgentConfig


def main() -> None:
    config = msgspec.json.decode(sys.stdin.buffer.read(), type=AgentConfig)
    pids = str(os.getpid())
    if config.machine == "stubborn":
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
        pids += f" {subprocess.Popen([sys.executable, '-c', 'import time; time.sleep(60)']).pid}"
    with (Path(config.run_dir) / "agents").open("a") as file:
        file.write(f"{pids}\n")
    if config.machine == "die":
        sys.exit(3)
    time.sleep(60)


if __name__ == "__main__":
    main()
