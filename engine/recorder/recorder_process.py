"""The recorder of a machine, a process that an agent starts when the first container records."""

import asyncio
import contextlib
import json
import logging
import sys
from asyncio.subprocess import PIPE, Process
from collections.abc import Callable
from pathlib import Path
from typing import Protocol

import msgspec

from engine.processes.occasional_log import OccasionalLog
from engine.protocols.frame_receiver import LENGTH
from engine.protocols.framing import pack
from engine.protocols.machine_link import RecorderTold
from engine.recorder import main as recorder_main
from engine.recorder.frames import Left, Recorded, Told
from engine.specs.containers import ContainerSpec

logger = logging.getLogger(__name__)

MOST_WAITING = 16 << 20
"""Size of the batches that wait for the recorder, beyond which they are dropped [bytes]."""

RESTART_DELAY = 2.0
"""Time after the exit of a recorder before another one is started [s]."""

STOP_GRACE = 5.0
"""Time for the recorder to finish its files [s]."""

MOST_TOLD = 1 << 16
"""Largest frame of the recorder [bytes]."""

NOT_HERE = (
    "this machine keeps no recordings: robots are recorded on the machine of the cloud itself, which has a data folder"
)
MISSING = "recordings need the extra recording on the machine of the cloud: pip install 'ppaas[recording]'"

Tell = Callable[[RecorderTold], None]


class Recordings(Protocol):
    """Recorder of a machine, as the container gateway uses it."""

    def take(self, spec: ContainerSpec, batch: bytes, tell: Tell) -> None:
        """Record a batch of a container; ``tell`` is called with what its clone is to be told."""
        ...

    def left(self, spec: ContainerSpec) -> None:
        """Finish the files of a container that has ended."""
        ...


class NoRecorder:
    """Recorder of a machine that keeps no recordings."""

    def take(self, spec: ContainerSpec, batch: bytes, tell: Tell) -> None:
        """Tell the clone that this machine keeps no recordings."""
        tell(RecorderTold(NOT_HERE))

    def left(self, spec: ContainerSpec) -> None:
        """Do nothing."""


NO_RECORDER = NoRecorder()


class RecorderProcess:
    """Starts the recorder when it is needed, again if it exits, and passes batches to it.

    Parameters
    ----------
    folder : Path
        Folder of the recordings.
    reserve : Path, optional
        Folder with the reserve of disk space of the cloud.
    """

    def __init__(self, folder: Path, reserve: Path | None) -> None:
        self._settings = json.dumps({"folder": str(folder), "reserve": str(reserve) if reserve else ""})
        self._process: Process | None = None
        self._keeper: asyncio.Task[None] | None = None
        self._tell: dict[tuple[str, str], Tell] = {}
        self._owners: dict[tuple[str, str], str] = {}
        self._slow = OccasionalLog(logger)
        self._missing = False

    @property
    def pid(self) -> int | None:
        """Process id of the recorder; None while none runs."""
        return None if self._process is None else self._process.pid

    def take(self, spec: ContainerSpec, batch: bytes, tell: Tell) -> None:
        """Pass a batch to the recorder; batches of the time before it runs are dropped, and repeated latched ones."""
        if spec.robot is None:
            return
        key = spec.user, spec.robot.id
        self._tell[key], self._owners[key] = tell, spec.id
        if self._missing:
            tell(RecorderTold(MISSING))
        elif self._keeper is None:
            self._keeper = asyncio.create_task(self._keep())
        if not self._write(Recorded(*key, batch)):
            tell(RecorderTold(lost=1))

    def left(self, spec: ContainerSpec) -> None:
        """Finish the files of a container, unless another container of its robot records already."""
        if spec.robot is None or self._owners.get(key := (spec.user, spec.robot.id)) != spec.id:
            return
        del self._owners[key], self._tell[key]
        self._write(Left(*key))

    async def close(self) -> None:
        """Let the recorder finish its files, and wait for its end."""
        process = self._process
        if process is not None and process.stdin is not None:
            process.stdin.close()
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(STOP_GRACE):
                    await process.wait()
        if self._keeper is not None:
            self._keeper.cancel()
            await asyncio.gather(self._keeper, return_exceptions=True)
        if process is not None and process.returncode is None:
            process.kill()
            await process.wait()

    # -- the process ---------------------------------------------------------------------------------------------------

    def _write(self, frame: msgspec.Struct) -> bool:
        process = self._process
        if process is None or process.stdin is None or process.stdin.is_closing():
            return False
        if process.stdin.transport.get_write_buffer_size() > MOST_WAITING:
            self._slow.warning("the recorder is too slow: messages are not recorded")
            return False
        process.stdin.writelines(pack(frame))
        return True

    async def _keep(self) -> None:
        while True:
            try:
                status = await self._live()
            except OSError as error:
                logger.warning("the recorder could not be started: %s", error)
                status = None
            self._process = None
            if status == recorder_main.MISSING:
                self._missing = True
                for tell in self._tell.values():
                    tell(RecorderTold(MISSING))
                return
            logger.warning("the recorder exited with status %s, and is started again", status)
            await asyncio.sleep(RESTART_DELAY)

    async def _live(self) -> int:
        """Run the recorder once; return its exit status."""
        command = [sys.executable, "-m", recorder_main.__name__, self._settings]
        self._process = process = await asyncio.create_subprocess_exec(*command, stdin=PIPE, stdout=PIPE)
        assert process.stdout is not None
        decoder = msgspec.msgpack.Decoder(Told)
        with contextlib.suppress(asyncio.IncompleteReadError):
            while True:
                length = int.from_bytes(await process.stdout.readexactly(LENGTH), "big")
                if length > MOST_TOLD:
                    process.kill()
                    break
                self._pass_on(decoder.decode(await process.stdout.readexactly(length)))
        return await process.wait()

    def _pass_on(self, told: Told) -> None:
        tell = self._tell.get((told.user, told.robot))
        if tell is not None:
            tell(RecorderTold(told.problem, told.forgotten))
