"""The agent of the cloud's own machine: ``python -m engine.agent.main``, with an ``AgentConfig`` as JSON on its input.

Robots wait for it when it was killed, and most of all for its fork server: that is started before the agent is loaded.
"""

import json
import sys
from pathlib import Path

from engine.agent.entries import ENTRIES
from engine.processes.run_dir import add_owner, keep_temporary_files_in
from engine.runtimes.fork_server import early_start


def main() -> None:
    """Be the agent."""
    told = sys.stdin.buffer.read()
    config = json.loads(told)
    keep_temporary_files_in(Path(config["run_dir"]))  # it goes with the cloud, should this be killed
    add_owner(Path(config["run_dir"]))
    if config["runtime"] == early_start.RUNTIME:
        early_start.begin(ENTRIES.container.of_fork_server)
    from engine.agent.agent import be_told  # noqa: PLC0415 - it takes as long as a third of what the fork server loads

    be_told(told)


if __name__ == "__main__":
    main()
