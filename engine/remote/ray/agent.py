"""The agent of a Ray node: ``python -m engine.remote.ray.agent`` with a ``NodeConfig`` as JSON on standard input.

It joins the cloud by its ticket, and is a machine of it as any on another host, until SIGTERM or the end of its actor.
"""

import logging
import os
import shutil
import signal
import sys
from pathlib import Path

import msgspec
import uvloop

from engine.processes.parent_watch import end_with
from engine.remote.agent import MachineOptions, stay
from engine.remote.membership import join
from engine.remote.ray.config import DONE, NodeConfig
from ppaas.errors import PPaaSError, Unavailable

logger = logging.getLogger(__name__)

PATIENCE = 60.0
"""Seconds for which the cloud may be away, as when it was killed and is started anew; then the node is given back."""


async def run(config: NodeConfig) -> int:
    """Join, and be a machine until SIGTERM; return the exit status.

    Raises
    ------
    PPaaSError
        The cloud does not want this machine, or was away for too long.
    """
    try:
        membership = await join(Path(config.folder), config.ticket, config.machine)
    except Unavailable as error:
        logger.warning("machine %s has not joined its cloud, and tries again: %s", config.machine, error)
        return 1
    await stay(membership, MachineOptions(config.cores, config.labels, PATIENCE))
    return 0


def main() -> None:
    """Run; what the actor had is removed here if it is dead."""
    logging.basicConfig(level=logging.INFO, format="%(levelname)s agent %(name)s: %(message)s")
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    config = msgspec.json.decode(sys.stdin.buffer.read(), type=NodeConfig)
    end_with(config.keeper)
    try:
        status = uvloop.run(run(config))
    except PPaaSError as error:
        logger.error("the node is no machine any more: %s", error)
        status = DONE
    finally:
        if os.getppid() != config.keeper:
            shutil.rmtree(config.folder, ignore_errors=True)
    sys.exit(status)


if __name__ == "__main__":
    main()
