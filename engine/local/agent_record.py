"""The agent of the cloud's own machine, as a cloud process leaves it behind and the next one finds it."""

import asyncio
import logging
import os
import signal
from pathlib import Path

import msgspec

from engine.agent.config import AgentConfig
from engine.processes.instances import is_dead, name_of, pid_of
from engine.processes.private_files import write_private
from ppaas import __version__

logger = logging.getLogger(__name__)

END_GRACE = 5.0
BLINK = 0.02


class AgentRecord(msgspec.Struct, frozen=True):
    """An agent that was started here.

    Parameters
    ----------
    process : str
        Its name among all processes that live or lived.
    cloud : str
        Name of the cloud process that it serves.
    told : Raw
        What it was told; read only where it is of this release, since others may tell otherwise.
    release : str
        Of this program, that it runs.
    """

    process: str
    cloud: str
    told: msgspec.Raw
    release: str = ""

    @property
    def pid(self) -> int:
        """Its process id."""
        return pid_of(self.process)

    @property
    def is_waiting(self) -> bool:
        """It is there, and the cloud process that started it is not: it waits for another."""
        return not is_dead(self.process) and is_dead(self.cloud)

    def matching_config(self, wanted: AgentConfig) -> AgentConfig | None:
        """Return what it was told, if it runs as an agent would that is started now."""
        if self.release != __version__:
            return None
        try:
            own = msgspec.json.decode(self.told, type=AgentConfig)
        except msgspec.DecodeError:  # of a checkout before this one, which says the same of its release
            return None
        same = msgspec.structs.replace(
            wanted, control=own.control, secret=own.secret, run_dir=own.run_dir, cloud=own.cloud
        )
        return own if same == own else None

    async def end(self) -> None:
        """End it with what it carries, by force if it does not go by itself."""
        logger.warning(
            "the agent of the cloud before, of release %s, ends with what it carries: %s",
            self.release or "(untold)",
            f"this cloud is {__version__}" if self.release != __version__ else "it runs otherwise than is wanted now",
        )
        os.kill(self.pid, signal.SIGTERM)
        try:
            async with asyncio.timeout(END_GRACE):
                while not is_dead(self.process):  # noqa: ASYNC110 - it is no child of ours
                    await asyncio.sleep(BLINK)
        except TimeoutError:
            os.killpg(self.pid, signal.SIGKILL)


def read_record(file: Path) -> AgentRecord | None:
    """Return the agent that a cloud process which was killed left behind, if it still waits."""
    try:
        left = msgspec.json.decode(file.read_bytes(), type=AgentRecord)
    except (OSError, msgspec.DecodeError):
        return None
    return left if left.is_waiting else None


def write_record(file: Path, pid: int, config: AgentConfig) -> None:
    """Note an agent that was started, for a cloud process after this one."""
    process = name_of(pid)
    if process is None:
        return  # it has ended already
    left = AgentRecord(process, config.cloud, msgspec.Raw(msgspec.json.encode(config)), __version__)
    try:
        write_private(file, msgspec.json.encode(left))
    except OSError as error:
        logger.warning("should this process be killed, what runs here cannot be adopted: %s", error)
