"""Record of the local agent, with which a cloud process finds the agent of a killed cloud process."""

import logging
from pathlib import Path

import msgspec

from engine.agent.config import AgentConfig
from engine.processes.ending import end_process
from engine.processes.instances import is_dead, name_of, pid_of
from engine.processes.private_files import write_private
from ppaas import __version__
from ppaas.decoding import from_json

logger = logging.getLogger(__name__)


class AgentRecord(msgspec.Struct, frozen=True):
    """An agent that was started on this machine.

    Parameters
    ----------
    process : str
        Instance name of the agent's process.
    cloud : str
        Instance name of the cloud process that it serves.
    told : Raw
        Its ``AgentConfig``. It is only decoded if the release is the same, since others may have another format.
    release : str
        Release of this program that the agent runs.
    """

    process: str
    cloud: str
    told: msgspec.Raw
    release: str = ""

    @property
    def pid(self) -> int:
        """Process id."""
        return pid_of(self.process)

    @property
    def is_waiting(self) -> bool:
        """Whether it runs and its cloud process does not, so that it waits for another one."""
        return not is_dead(self.process) and is_dead(self.cloud)

    def matching_config(self, wanted: AgentConfig) -> AgentConfig | None:
        """Return its configuration, or None if a new agent would get another one, apart from addresses and secret."""
        if self.release != __version__:
            return None
        try:
            own = from_json(self.told, AgentConfig)
        except msgspec.DecodeError:  # written by an older checkout with the same release number
            return None
        same = msgspec.structs.replace(
            wanted, control=own.control, secret=own.secret, run_dir=own.run_dir, cloud=own.cloud
        )
        return own if same == own else None

    async def end(self) -> None:
        """Stop it with its containers; kill it if it does not exit by itself."""
        logger.warning(
            "the agent of the previous cloud process, of release %s, is stopped with its containers: %s",
            self.release or "(unknown)",
            f"this cloud is {__version__}" if self.release != __version__ else "its configuration has changed",
        )
        await end_process(self.process)


def read_record(file: Path) -> AgentRecord | None:
    """Return the agent of a killed cloud process, if it still waits for another one."""
    try:
        left = from_json(file.read_bytes(), AgentRecord)
    except (OSError, msgspec.DecodeError):
        return None
    return left if left.is_waiting else None


def write_record(file: Path, pid: int, config: AgentConfig) -> None:
    """Record an agent that was started, for the next cloud process."""
    process = name_of(pid)
    if process is None:
        return  # it has exited already
    left = AgentRecord(process, config.cloud, msgspec.Raw(msgspec.json.encode(config)), __version__)
    try:
        write_private(file, msgspec.json.encode(left))
    except OSError as error:
        logger.warning("the agent cannot be recorded, so a restarted cloud cannot adopt its containers: %s", error)
