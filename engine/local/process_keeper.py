"""Process keeper: keeps named processes running, replaces frozen ones, and adopts the processes of a killed keeper."""

import asyncio
import logging
import os
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import msgspec

from engine.local.kept_process import KeptProcess, SpareProcesses
from engine.processes.background import Background
from engine.processes.child_process import end_process
from engine.processes.heartbeats import BeatFile, watch
from engine.processes.instances import is_dead, name_of, pid_of
from engine.processes.private_files import write_private
from ppaas import __version__
from ppaas.decoding import from_json

logger = logging.getLogger(__name__)


class KeptRecord(msgspec.Struct, frozen=True):
    """Process that was started.

    Parameters
    ----------
    process : str
        Its instance name.
    name : str
        Its name.
    settings : Raw
        Its settings, as JSON.
    release : str
        Release of its software; empty if it is earlier than this field.
    """

    process: str
    name: str
    settings: msgspec.Raw
    release: str = ""


def left_processes(file: Path) -> list[KeptRecord]:
    """Return the processes of a killed keeper that still run."""
    try:
        records = from_json(file.read_bytes(), list[KeptRecord])
    except (OSError, msgspec.DecodeError):
        return []
    return [record for record in records if not is_dead(record.process)]


class ProcessKeeper:
    """Keeps processes running; each shows by a ``BeatFile`` that it is not frozen.

    Parameters
    ----------
    command : sequence of str
        Command that runs each of them.
    settings : mapping of str to object
        Settings of each by name, passed as JSON on standard input.
    run_dir : Path
        Folder of their beat files.
    file : Path
        File that records them for the next keeper.
    spares : SpareProcesses, optional
        Processes of ``command`` that were started earlier; used before others are started.
    """

    def __init__(
        self,
        command: Sequence[str],
        settings: Mapping[str, Any],
        run_dir: Path,
        file: Path,
        spares: SpareProcesses | None = None,
    ) -> None:
        self._settings = {name: msgspec.Raw(msgspec.json.encode(one)) for name, one in settings.items()}
        self._file = file
        self._pids: dict[str, int] = {}
        self._beats = {name: BeatFile(run_dir, name) for name in settings}
        self._watching = Background()
        self._kept = {
            name: KeptProcess(
                f"process {name}",
                one,
                command,
                environment=dict(os.environ),
                started=partial(self._started, name),
                spares=spares,
            )
            for name, one in self._settings.items()
        }

    @property
    def names(self) -> frozenset[str]:
        """Names of the processes."""
        return frozenset(self._kept)

    @property
    def deaths(self) -> int:
        """Largest number of times in a row that one of them exited early or could not be started."""
        return max(kept.deaths for kept in self._kept.values())

    async def start(self) -> None:
        """Start or adopt the processes, and restart each whenever it exits or freezes."""
        for left in left_processes(self._file):
            if self._settings.get(left.name) == left.settings and left.release == __version__:
                self._kept[left.name].adopt(pid_of(left.process))
                self._note(left.name, pid_of(left.process))
            else:
                logger.warning(
                    "process %s of an earlier run is stopped: its settings or its release have changed", left.name
                )
                await end_process(left.process)
        for kept in self._kept.values():
            await kept.start()
        self._watching.run(watch((self._heartbeats, self._kill_frozen)))

    def change(self, settings: Mapping[str, Any]) -> None:
        """Note settings that the running processes follow, for those that are started after them; the names stay."""
        self._settings = {name: msgspec.Raw(msgspec.json.encode(one)) for name, one in settings.items()}
        for name, one in self._settings.items():
            self._kept[name].change(one)
        if self._pids:
            self._record()

    def _heartbeats(self) -> dict[str, int]:
        beats = {name: beat.last() for name, beat in self._beats.items()}
        return {name: last for name, last in beats.items() if last is not None}

    def _kill_frozen(self, name: str) -> None:
        logger.error("process %s does not respond any more: it is frozen, and replaced", name)
        self._beats[name].clear()
        self._kept[name].kill()

    def _started(self, name: str, pid: int) -> None:
        # Heartbeats of the process before say nothing about this one.
        self._beats[name].clear()
        self._note(name, pid)

    def _note(self, name: str, pid: int) -> None:
        self._pids[name] = pid
        self._record()

    def _record(self) -> None:
        records = [
            KeptRecord(process, name, self._settings[name], __version__)
            for name, pid in self._pids.items()
            if (process := name_of(pid)) is not None
        ]
        try:
            write_private(self._file, msgspec.json.encode(records))
        except OSError as error:
            logger.warning("the processes cannot be recorded, so the next keeper cannot adopt them: %s", error)

    async def stop(self) -> None:
        """Stop all processes."""
        await self._watching.cancel()
        await asyncio.gather(*(kept.stop() for kept in self._kept.values()))
        self._file.unlink(missing_ok=True)
