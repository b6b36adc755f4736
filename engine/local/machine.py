"""The machines that a cloud has started itself: this one, or the nodes of a Ray cluster (``engine.remote.ray``)."""

import contextlib
import secrets
from pathlib import Path
from typing import Protocol

import msgspec

from engine.agent.config import AgentConfig
from engine.local.agent_process import AgentProcess
from engine.local.agent_record import AgentRecord, write_record
from engine.processes.run_dir import make_run_dir, own
from engine.protocols.address import UnixAddress


class Agents(Protocol):
    """What keeps the agents of the machines that a cloud has started itself."""

    expected_at_start: bool
    """Tell whether there is a machine for sure, so that the start of a cloud waits for it."""

    was_adopted: bool
    """Tell whether that machine is one that was left behind."""

    @property
    def deaths(self) -> int:
        """How often the agent of that machine died, one time soon after the other."""
        ...

    async def start(self) -> None:
        """Start the agents, and go on starting them."""
        ...

    def kill(self, machine: str) -> None:
        """End the agent of a machine by force, if it is one of these: it is frozen, and is started again."""
        ...

    async def stop(self) -> None:
        """End all agents."""
        ...


def settle_config(wanted: AgentConfig, left: AgentRecord | None) -> AgentConfig:
    """Return what the agent of this machine is told, with the folder and the secret that it had, or with new ones.

    Raises
    ------
    InvalidInput, OSError
        As ``make_run_dir`` does.
    """
    run_dir, secret = None, secrets.token_urlsafe(24)
    told = left.matching_config(wanted) if left is not None else None
    if told is not None:
        with contextlib.suppress(OSError):  # it has ended just now
            own(Path(told.run_dir))
            run_dir, secret = Path(told.run_dir), told.secret
    run_dir = run_dir or make_run_dir()
    control = str(UnixAddress(run_dir / "control.sock"))
    return msgspec.structs.replace(wanted, control=control, secret=secret, run_dir=str(run_dir))


class LocalMachine:
    """Keeps the agent of this machine.

    Parameters
    ----------
    config : AgentConfig
        What it is told; of one that a cloud process before this one left behind, what it was told.
    file : Path, optional
        Where the agent is noted for a cloud process after this one.
    left : AgentRecord, optional
        One that was left behind: it goes on if it has the folder of ``config``, and ends first if not.
    """

    expected_at_start = True

    def __init__(self, config: AgentConfig, file: Path | None = None, left: AgentRecord | None = None) -> None:
        self._config = config
        self._file = file
        self._left = left
        told = left.matching_config(config) if left is not None else None
        self.was_adopted = told is not None and told.run_dir == config.run_dir
        self._agent = AgentProcess(config, started=self._note)

    @property
    def deaths(self) -> int:
        """How often the agent died, one time soon after the other."""
        return self._agent.deaths

    def _note(self, pid: int) -> None:
        if self._file is not None:
            write_record(self._file, pid, self._config)

    async def start(self) -> None:
        """Start the agent, and go on starting it."""
        left, self._left = self._left, None
        if left is not None and self.was_adopted:
            self._agent.adopt(left.pid)
            self._note(left.pid)
        elif left is not None:
            await left.end()
        await self._agent.start()

    def kill(self, machine: str) -> None:
        """End the agent by force if it is of that machine.

        Of one on another host no more is heard when it is frozen, and it does nothing by then.
        """
        if machine == self._config.machine:
            self._agent.kill()

    async def stop(self) -> None:
        """End the agent."""
        await self._agent.stop()
        if self._file is not None:
            self._file.unlink(missing_ok=True)
