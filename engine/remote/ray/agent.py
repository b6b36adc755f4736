"""Agent of a Ray node: ``python -m engine.remote.ray.agent``, with a ``NodeConfig`` as JSON on standard input.

It joins the cloud with its ticket and runs as any machine of another host, until SIGTERM or the exit of its actor.
"""

import logging
import os
import shutil
import signal
import sys
from pathlib import Path

import uvloop

from engine.processes.helper_program import end_with
from engine.remote.agent import MachineOptions, stay
from engine.remote.membership import join
from engine.remote.ray.config import DONE, NodeConfig
from ppaas.decoding import from_json
from ppaas.errors import PPaaSError, Unavailable
from ppaas.log_lines import log_lines

logger = logging.getLogger(__name__)

PATIENCE = 60.0
"""Time for which the cloud may be unreachable, as during a restart [s]; after that the node is released."""


async def run(config: NodeConfig) -> int:
    """Join and run the machine until SIGTERM; return the exit status.

    Raises
    ------
    PPaaSError
        The cloud refuses this machine, or was unreachable for too long.
    """
    try:
        membership = await join(Path(config.folder), config.ticket, config.machine)
    except Unavailable as error:
        logger.warning("machine %s could not join its cloud and tries again: %s", config.machine, error)
        return 1
    await stay(membership, MachineOptions(config.cores, config.labels, PATIENCE, config.endpoints))
    return 0


def main() -> None:
    """Run the agent; remove the folder of the actor if that has died."""
    log_lines("%(levelname)s agent %(name)s: %(message)s", process="agent", level=logging.INFO)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    config = from_json(sys.stdin.buffer.read(), NodeConfig)
    end_with(config.keeper)
    try:
        status = uvloop.run(run(config))
    except PPaaSError as error:
        logger.error("the node is not a machine any more: %s", error)
        status = DONE
    finally:
        if os.getppid() != config.keeper:
            shutil.rmtree(config.folder, ignore_errors=True)
    sys.exit(status)


if __name__ == "__main__":
    main()
