"""The recorder of a machine, a process that an agent starts when the first container records."""

import asyncio
import json
import logging
import socket
import sys
from asyncio.subprocess import Process
from collections.abc import Callable
from pathlib import Path
from typing import Protocol

import msgspec

from engine.processes.child_process import end
from engine.processes.occasional_log import OccasionalLog
from engine.protocols.framing import FrameStream
from engine.protocols.machine_link import RecorderTold
from engine.recorder import main as recorder_main
from engine.recorder.frames import Left, RecordedBatch, Told
from engine.specs.containers import ContainerSpec
from ppaas.distribution import install_hint
from ppaas.errors import InvalidInput

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
MISSING = f"recordings need the extra recording on the machine of the cloud: {install_hint('recording')}"

Tell = Callable[[RecorderTold], None]


class Recordings(Protocol):
    """Recorder of a machine, as the container gateway uses it."""

    def take(self, spec: ContainerSpec, batch: bytes, tell: Tell) -> None:
        """Record a batch of a container; ``tell`` is called with the report for its clone."""
        ...

    def left(self, spec: ContainerSpec) -> None:
        """Finish the files of a container that has ended."""
        ...


class NoRecorder:
    """Recorder of a machine that keeps no recordings."""

    def take(self, spec: ContainerSpec, batch: bytes, tell: Tell) -> None:
        """Report to the clone that this machine keeps no recordings."""
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
        self._stream: FrameStream[Told] | None = None
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
        if not self._write(RecordedBatch(*key, batch)):
            tell(RecorderTold(lost=1))

    def left(self, spec: ContainerSpec) -> None:
        """Finish the files of a container, unless another container of its robot records already."""
        if spec.robot is None or self._owners.get(key := (spec.user, spec.robot.id)) != spec.id:
            return
        del self._owners[key], self._tell[key]
        self._write(Left(*key))

    async def close(self) -> None:
        """Stop the recorder once it has finished its files, and wait for its end."""
        if self._keeper is not None:
            self._keeper.cancel()
            await asyncio.gather(self._keeper, return_exceptions=True)
        if self._process is not None:
            await end(self._process, STOP_GRACE)

    # -- the process ---------------------------------------------------------------------------------------------------

    def _write(self, frame: msgspec.Struct) -> bool:
        if self._stream is None:
            return False
        if self._stream.waiting > MOST_WAITING:
            self._slow.warning("the recorder is too slow: messages are not recorded")
            return False
        self._stream.write(frame)
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
        ours, theirs = socket.socketpair()
        stream = FrameStream[Told](*await asyncio.open_connection(sock=ours), Told, MOST_TOLD)
        try:
            with theirs:
                command = [sys.executable, "-m", recorder_main.__name__, self._settings]
                process = self._process = await asyncio.create_subprocess_exec(*command, stdin=theirs.fileno())
            self._stream = stream
            await self._pass_on(stream, process)
            return await process.wait()
        finally:
            self._stream = None
            await stream.close()  # at its end, the recorder finishes its files

    async def _pass_on(self, stream: FrameStream[Told], process: Process) -> None:
        """Pass the recorder's answers to the clones, until it exits; kill it if it violates the protocol."""
        try:
            while (told := await stream.receive()) is not None:
                tell = self._tell.get((told.user, told.robot))
                if tell is not None:
                    tell(RecorderTold(told.problem, told.forgotten))
        except InvalidInput as error:
            logger.error("the recorder is killed: %s", error)
            process.kill()
