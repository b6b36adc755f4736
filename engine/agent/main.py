"""Agent of the local machine: ``python -m engine.agent.main``, with an ``AgentConfig`` as JSON on standard input.

When an agent was killed, robots wait for its successor, mostly for the fork server: so the fork server is started
before the agent's own modules are imported.
"""

import json
import sys
from pathlib import Path

from engine.agent.entries import ENTRIES
from engine.processes.imports import without_collection
from engine.processes.run_dir import add_owner, keep_temporary_files_in
from engine.runtimes.fork_server import early_start


def main() -> None:
    """Run the agent."""
    config_json = sys.stdin.buffer.read()
    config = json.loads(config_json)
    keep_temporary_files_in(Path(config["run_dir"]))  # the cloud removes it, if this process is killed
    add_owner(Path(config["run_dir"]))
    if config["runtime"] == early_start.RUNTIME:
        early_start.begin(ENTRIES.container.of_fork_server)
    with without_collection():
        from engine.agent.agent import run_agent  # noqa: PLC0415 - a slow import, after the fork server has started
    run_agent(config_json)


if __name__ == "__main__":
    main()
