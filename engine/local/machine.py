"""The local machine, and the interface for machines that a cloud starts itself.

The nodes of a Ray cluster (``engine.remote.ray``) have the same interface.
"""

import contextlib
import logging
import secrets
from pathlib import Path
from typing import Protocol

import msgspec

from engine.agent.config import AgentConfig
from engine.local.kept_process import KeptProcess
from engine.processes.child_process import end_process
from engine.processes.instances import is_dead, name_of, pid_of
from engine.processes.private_files import write_private
from engine.processes.run_dir import add_owner, make_run_dir
from engine.protocols.address import UnixAddress
from engine.runtimes.memory_tuning import lean_python
from ppaas import __version__
from ppaas.decoding import from_json

logger = logging.getLogger(__name__)


# -- record of the agent -----------------------------------------------------------------------------------------------


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


# -- machines ----------------------------------------------------------------------------------------------------------


class Agents(Protocol):
    """Keeps the agents of the machines that a cloud starts itself running."""

    expected_at_start: bool
    """Whether there is certainly a machine, so that the start of a cloud waits for it."""

    was_adopted: bool
    """Whether that machine has the agent of a killed cloud process."""

    @property
    def deaths(self) -> int:
        """Number of times in a row that the agent of that machine exited early."""
        ...

    async def start(self) -> None:
        """Start the agents, and restart them whenever they exit."""
        ...

    def kill(self, machine: str) -> None:
        """Kill the frozen agent of a machine, if it is one of these; it is restarted."""
        ...

    async def stop(self) -> None:
        """Stop all agents."""
        ...


def settle_config(wanted: AgentConfig, left: AgentRecord | None) -> AgentConfig:
    """Return the configuration of the local agent, with the folder and secret of the agent to adopt, or new ones.

    Raises
    ------
    InvalidInput, OSError
        From ``make_run_dir``.
    """
    run_dir, secret = None, secrets.token_urlsafe(24)
    adopted = left.matching_config(wanted) if left is not None else None
    if adopted is not None:
        with contextlib.suppress(OSError):  # it has just exited
            add_owner(Path(adopted.run_dir))
            run_dir, secret = Path(adopted.run_dir), adopted.secret
    run_dir = run_dir or make_run_dir()
    control = str(UnixAddress(run_dir / "control.sock"))
    return msgspec.structs.replace(wanted, control=control, secret=secret, run_dir=str(run_dir))


class LocalMachine:
    """Keeps the agent of the local machine running.

    Parameters
    ----------
    config : AgentConfig
        Configuration of the agent, from ``settle_config``.
    file : Path, optional
        File that records the agent for the next cloud process.
    left : AgentRecord, optional
        Agent of a killed cloud process. It is adopted if its folder is ``config``'s, and stopped first otherwise.
    """

    expected_at_start = True

    def __init__(self, config: AgentConfig, file: Path | None = None, left: AgentRecord | None = None) -> None:
        self._config = config
        self._file = file
        self._left = left
        adopted = left.matching_config(config) if left is not None else None
        self.was_adopted = adopted is not None and adopted.run_dir == config.run_dir
        self._agent = KeptProcess(
            f"agent of machine {config.machine!r}", config, environment=lean_python.environment(), started=self._record
        )

    @property
    def deaths(self) -> int:
        """Number of times in a row that the agent exited early."""
        return self._agent.deaths

    def _record(self, pid: int) -> None:
        if self._file is not None:
            write_record(self._file, pid, self._config)

    async def start(self) -> None:
        """Start or adopt the agent, and restart it whenever it exits."""
        left, self._left = self._left, None
        if left is not None and self.was_adopted:
            self._agent.adopt(left.pid)
            self._record(left.pid)
        elif left is not None:
            await left.end()
        await self._agent.start()

    def kill(self, machine: str) -> None:
        """Kill the agent if it is of that machine.

        The agent of another host cannot be killed from here; when it is frozen it does nothing, and its link is closed.
        """
        if machine == self._config.machine:
            self._agent.kill()

    async def stop(self) -> None:
        """Stop the agent."""
        await self._agent.stop()
        if self._file is not None:
            self._file.unlink(missing_ok=True)
